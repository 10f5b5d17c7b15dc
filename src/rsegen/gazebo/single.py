"""Mesh type `single`: the map is one model, in a package that any world can include."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from rsegen.gazebo import sdf, shapes
from rsegen.scene.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the model package, and a world that has this model."""
    name = scene.name
    return {
        "model.config": [_CONFIG.format(name=name, version=sdf.VERSION).encode()],
        "model.sdf": sdf.utf8(chain([sdf.HEADER], _model(scene, f"model://{name}/"), [sdf.FOOTER])),
        f"{name}.world": sdf.utf8(sdf.world(scene, _model(scene))),
        **shapes.mesh_files(scene, scene.field, name),
    }


def model_count(scene: Scene) -> int:
    """Return the number of models: one."""
    return 1


def collision_count(scene: Scene) -> int:
    """Return the number of its meshes (tiles, or parts of one friction) or boxes."""
    return shapes.collision_count(scene, scene.field)


def _model(scene: Scene, root: str = "") -> Iterator[str]:
    """Return the text of the map as a model; its mesh URIs start with `root`."""
    own = shapes.shapes(scene, scene.field, scene.name, root)
    return sdf.model(scene.name, *own, is_body=scene.recipe.simulator == "classic")


_CONFIG = """\
<?xml version="1.0"?>
<model>
  <name>{name}</name>
  <version>1.0</version>
  <sdf version="{version}">model.sdf</sdf>
  <author>
    <name>rsegen</name>
  </author>
  <description>A Random Step Environment; recipe.json makes it again.</description>
</model>
"""
