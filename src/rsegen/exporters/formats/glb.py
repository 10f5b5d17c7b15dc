"""The format `glb` (glTF 2.0 in one file): meshes by colour, for viewers, browsers, game engines and Blender.

glTF has y up. The map is rotated so that viewers show its x to the right, its z up and its y away from the viewer.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any, ClassVar

import numpy as np

from rsegen.exporters.colours import Colour
from rsegen.exporters.formats.base import Format, Step, register
from rsegen.exporters.formats.parts import srgb_to_linear, textured_groups
from rsegen.exporters.formats.solid import Solid, solid
from rsegen.exporters.gazebo.obj import material_name, texture_files, texture_name, textured_name
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array
from rsegen.params.extras import MESH, Extra


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Glb(Format):
    """A watertight mesh with a material per level and frame (glTF 2.0, binary), in metres, y up as in glTF."""

    name: ClassVar[str] = "glb"
    extra: ClassVar[Extra | None] = MESH
    step: ClassVar[Step] = "mesh"

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return a GLB file."""
        return {f"{scene.name}.glb": _glb(scene)}


def _glb(scene: Scene) -> Iterator[bytes]:
    import trimesh

    picture = trimesh.Scene()
    for name, mesh in _textured(scene) if scene.recipe.is_textured else _coloured(scene):
        picture.add_geometry(mesh, node_name=name, geom_name=name)
    yield picture.export(file_type="glb") if picture.geometry else _EMPTY


def _coloured(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Yield a mesh per material, with its name."""
    from trimesh.visual import TextureVisuals

    for material, part in solid(scene.field).parts():
        name = material_name(material)
        mesh = part._replace(vertices=_y_up(part.vertices)).mesh
        mesh.visual = TextureVisuals(material=_matte(name, scene.colour(material)))
        yield name, mesh


def _textured(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Yield a mesh per material and texture, with its name."""
    from PIL import Image
    from trimesh.visual import TextureVisuals

    images = {name: Image.open(BytesIO(b"".join(content))) for name, content in texture_files(scene).items()}
    whole = solid(scene.field, textured=True)
    for material, part, chosen in textured_groups(whole):
        # A vertex per pair of texture coordinates.
        corners = np.concatenate([whole.vertices[whole.triangles[chosen]], whole.coordinates[chosen]], axis=2)
        known, numbers = np.unique(corners.reshape(-1, 5), axis=0, return_inverse=True)
        name, image = textured_name(material, part), images[texture_name(scene, part)].convert("RGB")
        mesh = Solid(_y_up(known[:, :3]), numbers.reshape(-1, 3), whole.materials[chosen]).mesh
        matte = _matte(name, scene.tint(material), baseColorTexture=image)
        mesh.visual = TextureVisuals(uv=known[:, 3:], material=matte)
        yield name, mesh


def _matte(name: str, colour: Colour, **texture: Any) -> Any:
    """Return the material of a surface without gloss."""
    from trimesh.visual.material import PBRMaterial

    factor = [*srgb_to_linear(colour), 1.0]
    return PBRMaterial(name=name, baseColorFactor=factor, metallicFactor=0.0, roughnessFactor=1.0, **texture)


def _y_up(vertices: Array) -> Array:
    """Return vertices x, y, z as x, z, -y: rotated by 90 degrees about x."""
    return vertices[:, [0, 2, 1]] * [1, 1, -1] + 0.0


_JSON = b'{"asset":{"version":"2.0"}} '
_EMPTY = struct.pack("<4sIIII", b"glTF", 2, 20 + len(_JSON), len(_JSON), 0x4E4F534A) + _JSON
"""The file of a flat map, which trimesh does not write."""
