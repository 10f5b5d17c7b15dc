"""What one run makes of a map design: how many maps, from which index on, and what they are called."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import Integer, Text, validate
from rsegen.params.streams import SEEDS


@dataclass(frozen=True, kw_only=True)
class Run:
    """How many maps to make, from which index on, and what they are called."""

    name: Annotated[
        str,
        Text(
            r"[A-Za-z0-9_][A-Za-z0-9_.\-]{0,63}",
            "1..64 letters, digits, _ . - (no . or - first)",
            help="name of the maps",
        ),
    ] = "rse"
    description: Annotated[str, Text(r"[^\x00-\x1f]{0,500}", "one line of up to 500 characters", help="for people")] = (
        ""
    )
    maps: Annotated[int, Integer(1, help="number of maps to generate")] = 1
    first_map: Annotated[int, Integer(0, SEEDS - 1, help="index of the first map")] = 0

    def __post_init__(self) -> None:
        validate(self)
        self.check_run()

    def check_run(self) -> None:
        """Raise a ParameterError if the last index is too large."""
        if self.first_map + self.maps > SEEDS:
            raise ParameterError("maps", f"{shown(self.maps)} from first_map {self.first_map} on go beyond {SEEDS - 1}")

    @property
    def indices(self) -> range:
        """The indices of its maps."""
        return range(self.first_map, self.first_map + self.maps)

    def map_name(self, index: int) -> str:
        """What map `index` is called, on disk and in the simulator."""
        return f"{self.name}_{index:04d}"
