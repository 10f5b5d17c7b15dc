"""The format `ply`: triangles with vertex colours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from rsegen.formats import MESH
from rsegen.formats.base import Format, Step, register
from rsegen.formats.parts import groups
from rsegen.formats.solid import solid
from rsegen.params.extras import Extra
from rsegen.scene.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Ply(Format):
    """A watertight mesh with vertex colours by level and frame (PLY, binary), in metres, z up."""

    name: ClassVar[str] = "ply"
    also: ClassVar[tuple[str, ...]] = ("pointcloud", "cloud", "pcd")
    extra: ClassVar[Extra | None] = MESH
    step: ClassVar[Step] = "mesh"

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return a PLY file."""
        return {f"{scene.name}.ply": _ply(scene)}


def _ply(scene: Scene) -> Iterator[bytes]:
    """Yield the PLY file; each colour has vertices of its own, so that colours are not interpolated."""
    from trimesh import Trimesh
    from trimesh.util import concatenate

    whole, parts = solid(scene.field), []
    for material, _, chosen in groups(whole.materials):
        parts.append(whole.part(chosen).mesh)
        parts[-1].visual.vertex_colors = [*scene.surface_colour(material), 1.0]
    mesh: Any = concatenate(parts) if parts else Trimesh()
    yield mesh.export(file_type="ply", vertex_normal=False)
