"""PLY: triangles with a colour at each vertex."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from rsegen.exporters.formats.base import MESH, Extra, Format, register
from rsegen.exporters.formats.solid import BYTES_A_CELL, solid
from rsegen.exporters.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Ply(Format):
    """A closed mesh with a colour for each level and the frame (PLY, binary), in metres, z up."""

    name: ClassVar[str] = "ply"
    extra: ClassVar[Extra | None] = MESH

    @property
    def bytes_a_cell(self) -> int:
        """That of a closed surface."""
        return BYTES_A_CELL

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """One."""
        return {f"{scene.name}.ply": _ply(scene)}


def _ply(scene: Scene) -> Iterator[bytes]:
    """Where two colours meet, each has vertices of its own, so that no colour runs into another."""
    from trimesh import Trimesh
    from trimesh.util import concatenate

    parts = []
    for material, part in solid(scene.field).parts():
        parts.append(part.mesh)
        parts[-1].visual.vertex_colors = [*scene.colour(material), 1.0]
    mesh: Any = concatenate(parts) if parts else Trimesh()
    yield mesh.export(file_type="ply", vertex_normal=False)
