"""The format `glb` (glTF 2.0 in one file): meshes by colour, for viewers, browsers, game engines and Blender.

glTF has y up. The map is rotated so that viewers show its x to the right, its z up and its y away from the viewer.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import ClassVar

import numpy as np

from rsegen.formats import MESH
from rsegen.formats.base import Format, Step, register
from rsegen.formats.parts import groups, srgb_to_linear
from rsegen.formats.solid import solid
from rsegen.gazebo.obj import material_name, texture_files, texture_name
from rsegen.params.extras import Extra
from rsegen.scene.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Glb(Format):
    """A watertight mesh with a material per level and frame (glTF 2.0, binary), in metres, y up as in glTF."""

    name: ClassVar[str] = "glb"
    also: ClassVar[tuple[str, ...]] = ("gltf", "dae", "collada", "fbx", "blender")
    extra: ClassVar[Extra | None] = MESH
    step: ClassVar[Step] = "mesh"

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return a GLB file."""
        return {f"{scene.name}.glb": _glb(scene)}


def _glb(scene: Scene) -> Iterator[bytes]:
    """Yield the file of a mesh per material and texture, in one piece."""
    import trimesh
    from PIL import Image
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    images = {name: Image.open(BytesIO(b"".join(content))) for name, content in texture_files(scene).items()}
    whole, picture = solid(scene.field, textured=bool(images)), trimesh.Scene()
    for material, part, chosen in groups(whole.materials, whole.sides if images else None):
        vertices, triangles, *_ = whole.part(chosen)
        name, uv, image = material_name(material, part), None, None
        if images:
            # A vertex per pair of texture coordinates.
            corners = np.concatenate([whole.vertices[whole.triangles[chosen]], whole.coordinates[chosen]], axis=2)
            known, indices = np.unique(corners.reshape(-1, 5), axis=0, return_inverse=True)
            vertices, triangles, uv = known[:, :3], indices.reshape(-1, 3), known[:, 3:]
            image = images[texture_name(scene, part)].convert("RGB")
        matte = PBRMaterial(
            name=name,
            baseColorFactor=[*srgb_to_linear(scene.tint(material)), 1.0],
            metallicFactor=0.0,
            roughnessFactor=1.0,
            baseColorTexture=image,
        )
        mesh = trimesh.Trimesh(vertices[:, [0, 2, 1]] * [1, 1, -1] + 0.0, triangles, process=False)  # y up
        mesh.visual = TextureVisuals(uv=uv, material=matte)
        picture.add_geometry(mesh, node_name=name, geom_name=name)
    yield picture.export(file_type="glb") if picture.geometry else _EMPTY


_JSON = b'{"asset":{"version":"2.0"}} '
_EMPTY = struct.pack("<4sIIII", b"glTF", 2, 20 + len(_JSON), len(_JSON), 0x4E4F534A) + _JSON
"""The file of a flat map, which trimesh does not write."""
