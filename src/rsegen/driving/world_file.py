"""The world file of a drive: a world with robots, and perhaps a camera, as text that can be saved in any folder.

Robots are added as <model>s, URIs become absolute paths, and physics runs in real time or unthrottled. Gazebo Sim also
gets the systems that the world does not name: up to Fortress 6.7 the server loads its default systems only if the world
file has no plug-in at all, and a robot's plug-ins count, so time would run and nothing would fall.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring, tostring
from xml.sax.saxutils import escape

from rsegen.errors import FileError, SimulatorFailed
from rsegen.gazebo.sdf import numbers
from rsegen.input_files import text_of, xml_root
from rsegen.pictures.camera import south_west_of
from rsegen.robots.drives import system

ALWAYS = ("Physics", "UserCommands", "SceneBroadcaster")
"""The default systems of every version."""

# Sensors that a server computes by rendering; all others compute with the physics.
_RENDERED = ("camera", "depth_camera", "rgbd_camera", "thermal_camera", "segmentation_camera", "gpu_lidar", "gpu_ray")
_OF_SENSORS = {"imu": "Imu", "contact": "Contact"} | dict.fromkeys(_RENDERED, "Sensors")
"""Type of a sensor -> its system."""

_ANY_RATE = "100000"
"""Updates a second that no world reaches: an empty one needs 20 microseconds for a step. Without a limit (0) a Gazebo
Classic that is paused, as one is before, between and after its steps, would keep a processor busy."""

_NAME = re.compile(r"(gz::sim|ignition::gazebo)(?:::v\d+)?::systems::(\w+)")


def add_systems(world: Element, backend: str) -> None:
    """Add to a <world> the systems that its models need and that it does not name; none in Gazebo Classic."""
    if backend == "classic":
        return
    # Gazebo Sim still reads Fortress's names, and Fortress no later ones.
    names = (_NAME.fullmatch(plugin.get("name", "")) for plugin in world.findall("plugin"))
    named = {name[2] for name in names if name and (backend == "sim" or name[1] == "ignition::gazebo")}
    sensors = {_OF_SENSORS.get(sensor.get("type", ""), "") for sensor in world.iter("sensor")} - {""}
    for kind in (*ALWAYS, *sorted(sensors)):
        if kind not in named:
            world.append(fromstring(system(kind, backend)))  # noqa: S314  # ours


_MAX_WORLD_MIB = 512
"""The largest world that is read, MiB; parsed it takes several times this in memory."""

_ABSOLUTE = re.compile(r"[a-z][a-z0-9+.-]*:|/|\s*$")
"""A URI that is not relative to the folder of its file: with a scheme, from the root, or empty."""


def world_with_robots(
    world: Path, models: Iterable[str] = (), *, unthrottled: bool = False, backend: str = "classic"
) -> str:
    """Return the text of a world file with models added; its meshes have absolute paths.

    models: texts of <model>s; unthrottled: simulate as fast as the machine can, else in real time
    backend: of the installation; its systems are added if the world does not name them
    FileError if the file is not a world.
    """
    root = xml_root(text_of(world, _MAX_WORLD_MIB, "a world"), str(world))
    element = root.find("world")
    if root.tag != "sdf" or element is None:
        raise FileError(f"{world}: no <world> in <sdf>")
    for model in models:
        element.append(fromstring(model))  # noqa: S314  # ours
    for uri in root.iter("uri"):
        path = uri.text or ""
        if not _ABSOLUTE.match(path):
            uri.text = str(world.absolute().parent / path)
    add_systems(element, backend)
    if unthrottled:  # Gazebo Classic reads the update rate, Gazebo Sim the factor
        physics = element.find("physics")
        physics = SubElement(element, "physics", {"type": "ode"}) if physics is None else physics
        for name, rate in (("real_time_update_rate", _ANY_RATE), ("real_time_factor", "0")):
            limit = physics.find(name)
            (SubElement(physics, name) if limit is None else limit).text = rate
    return '<?xml version="1.0"?>\n' + tostring(root, encoding="unicode") + "\n"


def time_step(world: str) -> float:
    """Return the physics step of a world in seconds, from its text; by default a millisecond, as in both Gazebos."""
    element = fromstring(world).find("world/physics/max_step_size")  # noqa: S314  # ours
    return float(element.text or 0) if element is not None else 0.001


def camera_model(extent: tuple[float, float], pixels: tuple[int, int], *, rate: int, frames: Path | None = None) -> str:
    """Return the model of a camera that looks at a map from the south-west; its server needs a screen.

    rate: pictures per second, 0 for as many as possible; frames: a folder to save them in
    """
    # The same view as the embedded simulator's pictures have (`filming.py`).
    save = f'\n        <save enabled="true"><path>{escape(str(frames))}</path></save>' if frames else ""
    camera = south_west_of(extent, pixels)
    pose = numbers((*camera.place, 0, camera.pitch, camera.yaw))
    return f"""\
<model name="eye">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="camera">
      <always_on>1</always_on>
      <update_rate>{rate}</update_rate>
      <camera>
        <horizontal_fov>{camera.view}</horizontal_fov>
        <image><width>{pixels[0]}</width><height>{pixels[1]}</height></image>
        <clip><near>0.05</near><far>1000</far></clip>{save}
      </camera>
    </sensor>
  </link>
</model>
"""


def last_frame(frames: Path) -> bytes:
    """Return the last picture that was saved, a JPEG; SimulatorFailed if none was."""
    # Gazebo numbers them without leading zeros: the longest name is later.
    pictures = sorted(frames.glob("*.jpg"), key=lambda path: (len(path.name), path.name))
    if not pictures:
        raise SimulatorFailed(
            "the camera saved no picture: the simulator could not render (is there a screen with OpenGL?)"
        )
    return pictures[-1].read_bytes()
