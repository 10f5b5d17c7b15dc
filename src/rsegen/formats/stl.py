"""The format `stl`: triangles without colours, for 3D printers, slicers and mesh programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from rsegen.formats import MESH
from rsegen.formats.base import Format, Step, register
from rsegen.formats.solid import solid
from rsegen.params.extras import Extra
from rsegen.scene.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Stl(Format):
    """A watertight mesh without colours (STL, binary), in metres, z up."""

    name: ClassVar[str] = "stl"
    also: ClassVar[tuple[str, ...]] = ("mesh",)
    extra: ClassVar[Extra | None] = MESH
    step: ClassVar[Step] = "mesh"

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return an STL file."""
        return {f"{scene.name}.stl": _stl(scene)}


def _stl(scene: Scene) -> Iterator[bytes]:
    yield solid(scene.field).mesh.export(file_type="stl")
