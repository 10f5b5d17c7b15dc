"""Depth cameras of a real Gazebo Classic that look at a map: somebody else's renderer as a judge of scans."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import rsegen
from rsegen.driving.world_file import world_with_robots
from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.simulators.base import Installation
from rsegen.simulators.gazebo_classic import ClassicWorld
from rsegen.simulators.server import running_server
from rsegen.simulators.wire import MessageTypes

IMAGE = MessageTypes(
    {"Image": {"width": (1, int), "height": (2, int), "pixel_format": (3, int), "step": (4, int), "data": (5, bytes)}}
)
FIELD_OF_VIEW = 1.0
SIZE = (640, 480)
FARTHEST = 6.0
PATIENCE = 120
"""Tries, of a tenth of a simulated second each, until a camera has sent a picture."""

EYE = """\
<model name="{name}">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="depth">
      <always_on>1</always_on>
      <update_rate>5</update_rate>
      <camera>
        <horizontal_fov>{view}</horizontal_fov>
        <image><width>{width}</width><height>{height}</height><format>R8G8B8</format></image>
        <clip><near>0.1</near><far>{farthest}</far></clip>
      </camera>
    </sensor>
  </link>
</model>
"""

Place = tuple[float, float, float]


def depth_clouds(recipe: rsegen.Recipe, places: Sequence[Place], here: Installation) -> list[Array]:
    """Clouds of a recipe's first map by depth cameras at some places [m], which look at its middle.

    Points (n, 3) in the map's frame [m], a cloud per camera. The server needs a screen, if only a virtual one.
    """
    eyes = [
        EYE.format(
            name=f"eye{number}",
            pose=" ".join(f"{value:.6f}" for value in (*place, *_heading(place))),
            view=FIELD_OF_VIEW,
            width=SIZE[0],
            height=SIZE[1],
            farthest=FARTHEST,
        )
        for number, place in enumerate(places)
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        world = rsegen.generate(recipe, folder / "worlds").maps[0].world
        file = folder / world.name
        file.write_text(world_with_robots(world, eyes, backend=here.backend), "utf-8")
        with running_server(here, file, models=folder / "worlds", screen=True) as server, server.connect() as live:
            if not isinstance(live, ClassicWorld):
                raise SimulatorFailed("not a Gazebo Classic")
            return [_cloud(live, f"eye{number}/link/camera/image", place) for number, place in enumerate(places)]


def _heading(place: Place) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a camera that looks at the origin."""
    x, y, z = place
    return 0.0, float(np.arctan2(z, np.hypot(x, y))), float(np.arctan2(-y, -x))


def _cloud(live: ClassicWorld, topic: str, place: Place) -> Array:
    live.client.subscribe(topic, "ImageStamped")
    for _ in range(PATIENCE):
        live.step(100)
        time.sleep(0.1)
        message = live.client.last(topic)
        if message:
            return _points(IMAGE.decode("Image", message["image"]), place)
    raise SimulatorFailed("the depth camera sent no picture: the simulator could not render (is there a screen?)")


def _points(image: Mapping[str, Any], place: Place) -> Array:
    """The points of a depth image [m]; depth is along the camera's axis."""
    width, height = SIZE
    depth = np.frombuffer(image["data"], dtype="<f4").reshape(height, width).astype(float)
    focal = width / 2 / np.tan(FIELD_OF_VIEW / 2)
    v, u = np.indices(depth.shape)
    local = np.stack([np.ones_like(depth), -(u - (width - 1) / 2) / focal, -(v - (height - 1) / 2) / focal], axis=-1)
    seen = np.isfinite(depth) & (depth > 0.1) & (depth < FARTHEST * 0.98)
    _, pitch, yaw = _heading(place)
    about_y = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    about_z = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    return np.asarray((local * depth[..., None])[seen] @ (about_z @ about_y).T + np.asarray(place))
