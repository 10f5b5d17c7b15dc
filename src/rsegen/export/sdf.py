"""SDF text that Gazebo Classic 11 and Gazebo Sim read alike: version 1.6, no plug-in, nothing from the internet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.export.numbers import decimal
from rsegen.scene import Scene

VERSION = "1.6"

HEAD = f'<?xml version="1.0"?>\n<!-- made by rsegen -->\n<sdf version="{VERSION}">\n'
TAIL = "</sdf>\n"

_WORLD = """\
  <world name="{name}">
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_factor>1</real_time_factor>
      <real_time_update_rate>1000</real_time_update_rate>
    </physics>
    <scene>
      <ambient>0.5 0.5 0.5 1</ambient>
      <background>0.75 0.8 0.85 1</background>
      <shadows>false</shadows>
    </scene>
    <light name="sun" type="directional">
      <cast_shadows>false</cast_shadows>
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


def world(scene: Scene, models: Iterable[str]) -> Iterator[str]:
    """A world file: physics, light, a ground plane that reaches well beyond the map, and `models`."""
    side = max(100.0, 2 * max(scene.field.extent))
    yield HEAD + _WORLD.format(name=scene.name, side=decimal(side), friction=_friction(scene.friction))
    yield from models
    yield "  </world>\n" + TAIL


def mesh_model(name: str, uri: str | None, friction: float, place: tuple[float, float] = (0.0, 0.0)) -> str:
    """A static model of one mesh, seen and touched alike; an empty one where there is no mesh."""
    x, y = map(decimal, place)
    pose = f"<pose>{x} {y} 0 0 0 0</pose>"
    shape = f"<mesh><uri>{uri}</uri></mesh>"
    parts = _touched(shape, friction) + _seen(shape) if uri else ""
    return _model(name, pose, parts)


def box_model(name: str, place: tuple[str, str], size: tuple[float, float], scene: Scene, material: int) -> str:
    """A static box on the ground: `place` its centre, `size` its width and height, in metres."""
    width, height = map(decimal, size)
    x, y = place
    pose = f"<pose>{x} {y} {decimal(size[1] / 2)} 0 0 0</pose>"
    shape = f"<box><size>{width} {width} {height}</size></box>"
    colour = " ".join(map(decimal, scene.colour(material)))
    paint = f"<material><ambient>{colour} 1</ambient><diffuse>{colour} 1</diffuse></material>"
    return _model(name, pose, _touched(shape, scene.friction) + _seen(shape, paint))


def encoded(texts: Iterable[str]) -> Iterator[bytes]:
    """Text as bytes, piece by piece."""
    return (text.encode() for text in texts)


def _model(name: str, pose: str, parts: str) -> str:
    return f"""\
    <model name="{name}">
      <static>true</static>
      {pose}
      <link name="link">
{parts}      </link>
    </model>
"""


def _touched(shape: str, friction: float) -> str:
    """`kd` 1000 lets soft wheels roll over the seams between coplanar triangles, which ODE would take for bumps."""
    return f"""\
        <collision name="collision">
          <geometry>{shape}</geometry>
          <surface>
            <contact><ode><kd>1000</kd></ode></contact>
            {_friction(friction)}
          </surface>
        </collision>
"""


def _seen(shape: str, paint: str = "") -> str:
    return f"""\
        <visual name="visual">
          <geometry>{shape}</geometry>{paint and chr(10) + " " * 10 + paint}
        </visual>
"""


def _friction(mu: float) -> str:
    return f"<friction><ode><mu>{decimal(mu)}</mu><mu2>{decimal(mu)}</mu2></ode></friction>"
