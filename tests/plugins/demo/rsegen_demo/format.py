"""A format."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen import Scene
from rsegen.formats.base import Format
from rsegen.params.sorts import Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Ascii(Format):
    """Heights as an ASCII grid (ASC) in metres, the northernmost row first."""

    name: ClassVar[str] = "ascii"

    digits: Annotated[int, Integer(0, 9, help="decimal places of a height")] = 3

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """One file."""
        heights = scene.field.heights
        head = f"ncols {heights.shape[0]}\nnrows {heights.shape[1]}\ncellsize {scene.field.block_width:g}\n"
        rows = (" ".join(f"{height:.{self.digits}f}" for height in row) + "\n" for row in heights.T[::-1])
        return {f"{scene.name}.heights": [head.encode(), "".join(rows).encode()]}
