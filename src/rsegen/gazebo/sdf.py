"""SDF texts for both Gazebo Classic 11 and Gazebo Sim: version 1.6, no plugins, no downloads.

Everything is text in pieces, so that a world of many models is written while it is made.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import hypot
from typing import NamedTuple

from rsegen.params.numbers import decimal
from rsegen.scene.colours import Colour
from rsegen.scene.scene import Scene

VERSION = "1.6"

HEADER = f'<?xml version="1.0"?>\n<!-- made by rsegen -->\n<sdf version="{VERSION}">\n'
FOOTER = "</sdf>\n"

_WORLD = """\
  <world name="{name}">{gui}
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_factor>1</real_time_factor>
      <real_time_update_rate>1000</real_time_update_rate>{solver}
    </physics>
    <scene>
      <ambient>0.5 0.5 0.5 1</ambient>
      <background>0.75 0.8 0.85 1</background>
      <shadows>{shadows}</shadows>{sky}
    </scene>
    <light name="sun" type="directional">
      <cast_shadows>{shadows}</cast_shadows>
      <pose>0 0 10 0 0 0</pose>
      <diffuse>0.7 0.7 0.7 1</diffuse>
      <specular>0.1 0.1 0.1 1</specular>
      <direction>-0.4 0.3 -0.86</direction>
    </light>
    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="collision">
          <geometry><plane><normal>0 0 1</normal><size>{side} {side}</size></plane></geometry>
          <surface>{friction}</surface>
        </collision>
        <visual name="visual">
          <geometry><plane><normal>0 0 1</normal><size>{side} {side}</size></plane></geometry>
          <material><ambient>0.6 0.6 0.6 1</ambient><diffuse>0.6 0.6 0.6 1</diffuse></material>
        </visual>
      </link>
    </model>
"""


_CAMERA = """
    <gui>
      <camera name="user_camera"><pose>{pose}</pose></camera>
    </gui>"""


_SOLVER = "\n      <dart><solver><solver_type>{}</solver_type></solver></dart>"


def world(scene: Scene, models: Iterable[str]) -> Iterator[str]:
    """Yield the text of a world file: physics, light, a ground plane much larger than the map, and `models`."""
    # The camera sees the whole map from the south-south-east and above.
    pose = numbers(round(0.95 * hypot(*scene.field.extent) * part, 3) for part in (0.4, -0.7, 0.6))
    yield HEADER + _WORLD.format(
        name=scene.name,
        gui=_CAMERA.format(pose=f"{pose} 0 0.6398 2.09") if scene.recipe.is_textured else "",
        solver="" if scene.recipe.solver == "dantzig" else _SOLVER.format(scene.recipe.solver),
        shadows="true" if scene.recipe.shadows else "false",
        sky="\n      <sky></sky>" if scene.recipe.sky else "",
        side=decimal(max(100.0, 2 * max(scene.field.extent))),
        friction=_friction(scene.friction),
    )
    yield from models
    yield "  </world>\n" + FOOTER


class Shape(NamedTuple):
    """A named <geometry> with its centre in metres; its <material> if visual, its friction coefficient if collision."""

    name: str
    geometry: str
    centre: Sequence[float] = ()
    material: str = ""
    friction: float = 1.0


def mesh_geometry(name: str, uri: str) -> Shape:
    """Return the shape of a mesh file."""
    return Shape(name, f"<mesh><uri>{uri}</uri></mesh>")


def box_geometry(name: str, size: Iterable[float], centre: Sequence[float] = ()) -> Shape:
    """Return the shape of an axis-aligned box, its size in metres."""
    return Shape(name, f"<box><size>{numbers(size)}</size></box>", centre)


_STATIC = """\
      <static>true</static>
      <pose>{place} 0 0 0</pose>
      <link name="link">
"""
_BODY = """\
      <joint name="to_world" type="fixed"><parent>world</parent><child>link</child></joint>
      <link name="link">
        <gravity>false</gravity>
        <kinematic>true</kinematic>
        <inertial>
          <mass>1000000</mass>
          <inertia><ixx>1000000</ixx><iyy>1000000</iyy><izz>1000000</izz></inertia>
        </inertial>
"""
"""The beginning of a model that is static, and of one that is a body which nothing moves (decision 17).

Gazebo Classic takes the body for kinematic, and the joint does nothing; Gazebo Sim does not know `kinematic`, and the
joint holds it.
"""

LIFT = 0.00001
"""Metres by which a model that is a body is above the ground plane, so that they are not in contact in every step."""


def model(
    name: str, visuals: Iterable[Shape], collisions: Iterable[Shape], place: str = "0 0 0", *, is_body: bool = False
) -> Iterator[str]:
    """Yield the text of a model of visual and collision shapes, in pieces; `place` is x, y and z in metres.

    is_body: a body in the origin, which nothing moves, in place of a static model
    """
    yield f'    <model name="{name}">\n' + (_BODY if is_body else _STATIC.format(place=place))
    for shape in collisions:
        (x, y, z), friction = shape.centre or (0, 0, 0), _friction(shape.friction)
        raised = shape._replace(centre=(x, y, z + LIFT)) if is_body else shape
        # `kd` 1000 lets soft wheels roll over seams between coplanar triangles in ODE.
        yield f"""\
        <collision name="{shape.name}">{_pose(raised)}
          <geometry>{shape.geometry}</geometry>
          <surface>
            <contact><ode><kd>1000</kd></ode></contact>
            {friction}
          </surface>
        </collision>
"""
    for shape in visuals:
        yield f"""\
        <visual name="{shape.name}">{_pose(shape)}
          <geometry>{shape.geometry}</geometry>{shape.material and _LINE + shape.material}
        </visual>
"""
    yield "      </link>\n    </model>\n"


def numbers(values: Iterable[float]) -> str:
    """Return numbers as SDF text, separated by spaces."""
    return " ".join(map(decimal, values))


def material(colour: Colour) -> str:
    """Return the text of a <material> of one colour."""
    rgba = numbers((*colour, 1))
    return f"<material><ambient>{rgba}</ambient><diffuse>{rgba}</diffuse></material>"


def utf8(texts: Iterable[str]) -> Iterator[bytes]:
    """Return texts as UTF-8 bytes, piece by piece."""
    return (text.encode() for text in texts)


def _pose(shape: Shape) -> str:
    return f"{_LINE}<pose>{numbers(shape.centre)} 0 0 0</pose>" if shape.centre else ""


_LINE = "\n" + " " * 10


def _friction(mu: float) -> str:
    return f"<friction><ode><mu>{decimal(mu)}</mu><mu2>{decimal(mu)}</mu2></ode></friction>"
