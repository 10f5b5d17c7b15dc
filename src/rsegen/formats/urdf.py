"""The format `urdf`: the map as a static link, with visual meshes and collision boxes.

A link has one friction coefficient, so a map of several has as many links, connected by fixed joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen.formats.base import Format, Step, register
from rsegen.formats.parts import objs
from rsegen.gazebo.obj import material_name, mtl
from rsegen.gazebo.sdf import numbers, utf8
from rsegen.gazebo.shapes import split_by_friction
from rsegen.geometry import boxes
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Flag
from rsegen.scene.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Urdf(Format):
    """A static link (URDF) for PyBullet, Isaac Lab and RViz, with a visual mesh per colour and collision boxes."""

    name: ClassVar[str] = "urdf"
    also: ClassVar[tuple[str, ...]] = ("pybullet",)
    step: ClassVar[Step] = "surface"

    world: Annotated[
        bool, Flag(help="fix the map to a link `world` by a joint, for engines in which it would fall (Drake, DART)")
    ] = False

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the URDF file, and the visual meshes in the folder meshes."""
        return urdf_files(scene, world=self.world)


def urdf_files(scene: Scene, folder: str = "", root: str = "", *, world: bool = False) -> dict[str, Iterable[bytes]]:
    """Return the files of a map's URDF below `folder`; its mesh URIs start with `root`, or are relative to the file.

    world: hold the map by a joint to a link of that name
    """
    surfaces = {material: content for material, _, content in objs(scene)}
    meshes = {folder + _mesh(scene, material): content for material, content in surfaces.items()}
    colours = {f"{folder}meshes/{scene.name}.mtl": mtl(scene, textured=False)} if meshes else {}
    return {f"{folder}{scene.name}.urdf": utf8(_robot(scene, surfaces, root, world=world)), **meshes, **colours}


def _robot(scene: Scene, materials: Iterable[int], root: str, *, world: bool) -> Iterator[str]:
    """Yield the URDF text: one link per friction coefficient; the first has the map's name and all visual meshes."""
    hint = "" if root else "\n     In a ROS package, write package://PACKAGE/PATH/meshes/ for meshes/."
    yield f"""\
<?xml version="1.0"?>
<!-- made by rsegen: metres, z up, the middle of the map at 0 0 0, the ground at z = 0.{hint} -->
<robot name="{scene.name}">
"""
    if world:
        yield '  <link name="world"/>\n'
        yield _joint("world", scene.name)
    for index, (friction, field) in enumerate(split_by_friction(scene, scene.field)):
        name = f"{scene.name}_friction_{decimal(friction)}" if index else scene.name
        # Bullet reads friction from <contact>, and takes a link without a mass for one of 1 kg.
        yield f"""\
  <link name="{name}">
    <inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
    <contact><lateral_friction value="{decimal(friction)}"/></contact>
"""
        for material in () if index else materials:
            rgba = numbers((*scene.surface_colour(material), 1))
            yield f"""\
    <visual name="{material_name(material)}">
      <geometry><mesh filename="{root}{_mesh(scene, material)}"/></geometry>
      <material name="{scene.name}_{material_name(material)}"><color rgba="{rgba}"/></material>
    </visual>
"""
        cut = boxes(field)
        for size, centre in zip(cut.sizes.tolist(), cut.centres.tolist(), strict=True):
            yield f"""\
    <collision>
      <origin xyz="{numbers(centre)}"/>
      <geometry><box size="{numbers(size)}"/></geometry>
    </collision>
"""
        yield "  </link>\n" + (_joint(scene.name, name) if index else "")
    yield "</robot>\n"


def _joint(parent: str, child: str) -> str:
    return f"""\
  <joint name="{child}_fixed" type="fixed">
    <parent link="{parent}"/>
    <child link="{child}"/>
  </joint>
"""


def _mesh(scene: Scene, material: int) -> str:
    return f"meshes/{scene.name}_{material_name(material)}.obj"
