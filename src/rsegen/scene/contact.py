"""Contact parameters between blocks and robots in MuJoCo: all of them, so that no default of a robot's model acts.

MuJoCo lets two geoms touch if the bits `contype` of one meet `conaffinity` of the other. Blocks have all bits, so
they touch whatever can touch anything. Of two geoms the one with the higher `priority` decides friction, condim, solref
and solimp; of equal ones MuJoCo takes the larger friction and condim.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from rsegen.errors import ParameterError
from rsegen.params.sorts import Float, Integer, ListOf, validate

_ALL_BITS = 2**31 - 1

_CONDIMS = (1, 3, 4, 6)
"""Dimensions that a contact of MuJoCo may have."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """Contact parameters of blocks in MuJoCo, with MuJoCo's names and, except for the priority, its defaults.

    Feet have priorities of 0 and 1, so by default the blocks' friction acts; below theirs only the robot's acts, and
    with an equal one the larger.

    Raises
    ------
    ParameterError
        If a value is none of MuJoCo's.
    """

    priority: Annotated[int, Integer(-1000, 1000, help="above that of robots, blocks decide friction")] = 10
    condim: Annotated[
        int, Integer(1, 6, help="3: friction against sliding; 4: turning too; 6: rolling too; 1: none")
    ] = 3
    torsional: Annotated[float, Float(0, 1000, unit="m", help="friction against turning")] = 0.005
    rolling: Annotated[float, Float(0, 1000, unit="m", help="friction against rolling")] = 0.0001
    solref: Annotated[Sequence[float], ListOf(Float(), 2, help="how stiff contacts are")] = (0.02, 1.0)
    solimp: Annotated[Sequence[float], ListOf(Float(), 5, help="how hard contacts are")] = (
        0.9,
        0.95,
        0.001,
        0.5,
        2.0,
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.condim not in _CONDIMS:
            raise ParameterError("condim", f"{self.condim} is not a condim of MuJoCo; use 1, 3, 4 or 6")

    def frictions(self, sliding: float) -> tuple[float, float, float]:
        """Return the three coefficients of friction of a block: sliding, torsional, rolling."""
        return sliding, self.torsional, self.rolling

    def attributes(self, sliding: float) -> Mapping[str, tuple[float, ...]]:
        """Return the numbers of each attribute of a geom that decides a contact, for a coefficient of friction."""
        return {
            "contype": (_ALL_BITS,),
            "conaffinity": (_ALL_BITS,),
            "condim": (self.condim,),
            "priority": (self.priority,),
            "friction": self.frictions(sliding),
            "solmix": (1,),
            "solref": tuple(self.solref),
            "solimp": tuple(self.solimp),
            "margin": (0,),
            "gap": (0,),
        }


CONTACT = Contact()
