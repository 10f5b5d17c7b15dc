"""URDF: the map as a link that nothing moves, seen as meshes, touched as boxes.

A link has one coefficient of friction, so a map of several has as many links, joined for good.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import ClassVar

from rsegen.exporters.formats.base import Format, register
from rsegen.exporters.formats.coloured import coloured_objs
from rsegen.exporters.gazebo.obj import material_name, mtl
from rsegen.exporters.gazebo.sdf import numbers, utf8
from rsegen.exporters.gazebo.shapes import split_by_friction
from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import StepField
from rsegen.geometry import boxes


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Urdf(Format):
    """A static link (URDF) for PyBullet, Isaac Lab and RViz, with a mesh for each colour and boxes to touch."""

    name: ClassVar[str] = "urdf"

    @property
    def bytes_a_cell(self) -> int:
        """A few boxes and faces."""
        return 600

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """The links, and in the folder meshes what is seen of them."""
        objs = coloured_objs(scene)
        meshes = {_mesh(scene, material): content for material, content in objs.items()}
        colours = {f"meshes/{scene.name}.mtl": mtl(scene)} if meshes else {}
        return {f"{scene.name}.urdf": utf8(_robot(scene, objs)), **meshes, **colours}


def _robot(scene: Scene, materials: Iterable[int]) -> Iterator[str]:
    """A link for each coefficient of friction; the first has the map's name and all that is seen."""
    yield f"""\
<?xml version="1.0"?>
<!-- made by rsegen: metres, z up, the middle of the map at 0 0 0, the ground at z = 0.
     In a ROS package, write package://PACKAGE/PATH/meshes/ for meshes/. -->
<robot name="{scene.name}">
"""
    visuals = [_visual(scene, material) for material in materials]
    for number, (friction, field) in enumerate(split_by_friction(scene, scene.field)):
        name = f"{scene.name}_friction_{decimal(friction)}" if number else scene.name
        yield from _link(name, friction, chain([] if number else visuals, _collisions(field)))
        if number:
            yield _joint(scene.name, name)
    yield "</robot>\n"


def _link(name: str, friction: float, shapes: Iterable[str]) -> Iterator[str]:
    """<contact> is Bullet's word for friction; PyBullet takes a link whose mass is not said for one of 1 kg."""
    yield f"""\
  <link name="{name}">
    <inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
    <contact><lateral_friction value="{decimal(friction)}"/></contact>
"""
    yield from shapes
    yield "  </link>\n"


def _joint(parent: str, child: str) -> str:
    return f"""\
  <joint name="{child}_fixed" type="fixed">
    <parent link="{parent}"/>
    <child link="{child}"/>
  </joint>
"""


def _visual(scene: Scene, material: int) -> str:
    rgba = numbers((*scene.colour(material), 1))
    return f"""\
    <visual name="{material_name(material)}">
      <geometry><mesh filename="{_mesh(scene, material)}"/></geometry>
      <material name="{scene.name}_{material_name(material)}"><color rgba="{rgba}"/></material>
    </visual>
"""


def _collisions(field: StepField) -> Iterator[str]:
    found = boxes(field)
    for size, centre in zip(found.sizes.tolist(), found.centres.tolist(), strict=True):
        yield f"""\
    <collision>
      <origin xyz="{numbers(centre)}"/>
      <geometry><box size="{numbers(size)}"/></geometry>
    </collision>
"""


def _mesh(scene: Scene, material: int) -> str:
    return f"meshes/{scene.name}_{material_name(material)}.obj"
