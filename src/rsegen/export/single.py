"""Mesh type `single`: the map is one model of one merged mesh, as a package that any world can include."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.export import sdf
from rsegen.export.obj import mtl, obj
from rsegen.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """The model package, and a world with this model in it."""
    name = scene.name
    mesh = f"meshes/{name}.obj" if len(scene.mesh.faces) else None
    found: dict[str, Iterable[bytes]] = {
        "model.config": [_config(name).encode()],
        "model.sdf": sdf.encoded(_package(scene, mesh and f"model://{name}/{mesh}")),
        f"{name}.world": sdf.encoded(sdf.world(scene, [sdf.mesh_model(name, mesh, scene.friction)])),
    }
    if mesh:
        found |= {mesh: obj(scene.mesh, f"{name}.mtl"), f"meshes/{name}.mtl": mtl(scene)}
    return found


def models(scene: Scene) -> int:
    """One."""
    return 1


def faces(scene: Scene) -> int:
    """Rectangles of the merged surface."""
    return len(scene.mesh.faces)


def _package(scene: Scene, uri: str | None) -> Iterator[str]:
    yield sdf.HEAD
    yield sdf.mesh_model(scene.name, uri, scene.friction)
    yield sdf.TAIL


def _config(name: str) -> str:
    return f"""\
<?xml version="1.0"?>
<model>
  <name>{name}</name>
  <version>1.0</version>
  <sdf version="{sdf.VERSION}">model.sdf</sdf>
  <author>
    <name>rsegen</name>
  </author>
  <description>A Random Step Environment; recipe.json makes it again.</description>
</model>
"""
