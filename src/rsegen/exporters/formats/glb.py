"""The format `glb` (glTF 2.0 in one file): meshes by colour, for viewers, browsers, game engines and Blender.

glTF has y up. The map is rotated so that viewers show its x to the right, its z up and its y away from the viewer.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from rsegen.exporters.formats.base import MESH, Extra, Format, register
from rsegen.exporters.formats.solid import BYTES_A_CELL, solid
from rsegen.exporters.formats.srgb import srgb_to_linear
from rsegen.exporters.gazebo.obj import material_name
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Glb(Format):
    """A watertight mesh with a material per level and frame (glTF 2.0, binary), in metres, y up as in glTF."""

    name: ClassVar[str] = "glb"
    extra: ClassVar[Extra | None] = MESH

    @property
    def bytes_a_cell(self) -> int:
        """The memory of a watertight mesh."""
        return BYTES_A_CELL

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """One GLB file."""
        return {f"{scene.name}.glb": _glb(scene)}


def _glb(scene: Scene) -> Iterator[bytes]:
    import trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    found = trimesh.Scene()
    for material, part in solid(scene.field).parts():
        name = material_name(material)
        colour = [*srgb_to_linear(scene.colour(material)), 1.0]
        matt = PBRMaterial(name=name, baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=1.0)
        mesh = part._replace(vertices=_y_up(part.vertices)).mesh
        mesh.visual = TextureVisuals(material=matt)
        found.add_geometry(mesh, node_name=name, geom_name=name)
    yield found.export(file_type="glb") if found.geometry else _EMPTY


def _y_up(vertices: Array) -> Array:
    """Vertices x, y, z as x, z, -y: rotated by 90 degrees about x."""
    return vertices[:, [0, 2, 1]] * [1, 1, -1] + 0.0


_JSON = b'{"asset":{"version":"2.0"}} '
_EMPTY = struct.pack("<4sIIII", b"glTF", 2, 20 + len(_JSON), len(_JSON), 0x4E4F534A) + _JSON
"""The file of a flat map, which trimesh does not write."""
