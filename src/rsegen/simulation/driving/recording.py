"""Robots driven over a world in a simulator server, and the record of their poses and contacts.

A world file with robots added, as text that can be saved in any folder.

The systems that a world with robots names for Gazebo Sim.

Up to Fortress 6.7 the server loads its default systems only if the world file has no plug-in at all. Those of a robot
count, so time would run and nothing would fall.

A camera sensor of Gazebo that looks at a map, and its last picture.

What robots were in contact with, sampled each time that routes decide.
"""

from __future__ import annotations

import re
import tempfile
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from math import atan2, ceil, hypot, pi, sqrt
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, fromstring

import numpy as np

from rsegen.errors import FileError, SimulatorFailed
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.io.input_files import elements, text_of
from rsegen.robots.base import DrivableRobot
from rsegen.robots.drives import system
from rsegen.simulation.driving.drive_metrics import Trajectory
from rsegen.simulation.driving.routes import PlannedWay, Route
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.live_world import Contact, LiveWorld, Pose, Record
from rsegen.simulation.simulators.server import retried, running_server

ALWAYS = ("Physics", "UserCommands", "SceneBroadcaster")
"""The default systems of every version."""

_RENDERED = ("camera", "depth_camera", "rgbd_camera", "thermal_camera", "segmentation_camera", "gpu_lidar", "gpu_ray")
_OF_SENSORS = {"imu": "Imu", "contact": "Contact"} | dict.fromkeys(_RENDERED, "Sensors")
"""Type of a sensor -> its system."""

_NAME = re.compile(r"(gz::sim|ignition::gazebo)(?:::v\d+)?::systems::(\w+)")


def add_systems(world: Element, backend: str) -> None:
    """Add to a <world> the systems that its models need and that it does not name; none in Gazebo Classic."""
    if backend == "classic":
        return
    there = set(_named(world, backend))
    sensors = {_OF_SENSORS.get(sensor.get("type", ""), "") for sensor in world.iter("sensor")} - {""}
    for kind in (*ALWAYS, *sorted(sensors)):
        if kind not in there:
            world.append(fromstring(system(kind, backend)))  # noqa: S314  # ours


def _named(world: Element, backend: str) -> Iterator[str]:
    """The systems that a world names; Gazebo Sim still reads Fortress's names, and Fortress no later ones."""
    for plugin in world.findall("plugin"):
        found = _NAME.fullmatch(plugin.get("name", ""))
        if found and (backend == "sim" or found[1] == "ignition::gazebo"):
            yield found[2]


_MOST_MIB = 512
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:")


def world_with_robots(
    world: Path, models: Iterable[str] = (), *, unthrottled: bool = False, backend: str = "classic"
) -> str:
    """The text of a world file with models added, each the text of a <model>; meshes have absolute paths.

    unthrottled: simulated as fast as the machine can, else in real time; backend: that of the installation, whose
    systems are added where the world does not name them. FileError if the file is not a world.
    """
    root = elements(text_of(world, _MOST_MIB, "a world"), str(world))
    element = root.find("world")
    if root.tag != "sdf" or element is None:
        raise FileError(f"{world}: no <world> in <sdf>")
    for model in models:
        element.append(ET.fromstring(model))  # noqa: S314  # ours
    for uri in root.iter("uri"):
        uri.text = _absolute(uri.text or "", world.absolute().parent)
    add_systems(element, backend)
    if unthrottled:
        _unthrottle(element)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def time_step(world: str) -> float:
    """The physics step of a world in seconds, from its text."""
    found = ET.fromstring(world).find("world/physics/max_step_size")  # noqa: S314  # ours
    return float(found.text or 0) if found is not None else 0.001


def _absolute(uri: str, folder: Path) -> str:
    return uri if not uri.strip() or _SCHEME.match(uri) or uri.startswith("/") else str(folder / uri)


def _unthrottle(world: ET.Element) -> None:
    """Gazebo Classic reads the update rate, Gazebo Sim the factor."""
    physics = world.find("physics")
    if physics is None:
        physics = ET.SubElement(world, "physics", {"type": "ode"})
    for name in ("real_time_update_rate", "real_time_factor"):
        element = physics.find(name)
        (ET.SubElement(physics, name) if element is None else element).text = "0"


_AZIMUTH = pi / 4


def camera(extent: tuple[float, float], frames: Path) -> str:
    """The model of a camera that looks at a map of this extent from the south-west and saves a picture per second.

    Its server needs a screen, if only a virtual one.
    """
    save = f'\n        <save enabled="true"><path>{frames}</path></save>'
    return camera_model(extent, (1280, 720), rate=1, save=save)


def camera_model(extent: tuple[float, float], pixels: tuple[int, int], *, rate: int, save: str = "") -> str:
    """The model of a camera that looks at a map of this extent; rate: pictures a second, 0 for as many as can be."""
    away = (1.1 * hypot(*extent) + 1.0) / sqrt(2)
    high = 0.8 * away
    pose = numbers((-away, -away, high, 0, round(atan2(high, away * sqrt(2)), 4), round(_AZIMUTH, 4)))
    return f"""\
<model name="eye">
  <static>true</static>
  <pose>{pose}</pose>
  <link name="link">
    <sensor name="camera" type="camera">
      <always_on>1</always_on>
      <update_rate>{rate}</update_rate>
      <camera>
        <horizontal_fov>0.9</horizontal_fov>
        <image><width>{pixels[0]}</width><height>{pixels[1]}</height></image>
        <clip><near>0.05</near><far>1000</far></clip>{save}
      </camera>
    </sensor>
  </link>
</model>
"""


def last_frame(frames: Path) -> bytes:
    """The last picture that was saved, a JPEG."""
    found = sorted(frames.glob("*.jpg"), key=lambda path: (len(path.name), path.name))
    if not found:
        raise SimulatorFailed(
            "the camera saved no picture: the simulator could not render (is there a screen with OpenGL?)"
        )
    return found[-1].read_bytes()


ContactSamples = Sequence[tuple[float, Sequence[Contact]]]
"""Simulated seconds, and all contacts at that time, sample by sample."""


class RobotContact(NamedTuple):
    """Contact of a part of a robot, LINK::COLLISION, with another model or robot; x, y, z: its mean point, metres."""

    t: float
    robot: str
    part: str
    other: str
    x: float
    y: float
    z: float


def robot_contacts(samples: ContactSamples, robots: Iterable[str]) -> Iterator[RobotContact]:
    """The contacts of these robots with other models, in the order of time."""
    names = set(robots)
    for second, contacts in samples:
        for contact in contacts:
            for (robot, _, part), (other, _, _) in _both_ways(contact.collisions):
                if robot in names and other != robot:
                    yield RobotContact(round(second, 3), robot, part, other, *contact.position)


def contact_shares(samples: ContactSamples, robot: str) -> Mapping[str, float]:
    """Return the share of samples in which each part of a robot had contact, 0..1, the largest first."""
    found = {(contact.t, contact.part) for contact in robot_contacts(samples, [robot])}
    counts = Counter(part for _, part in sorted(found))
    return {part: round(count / len(samples), 3) for part, count in counts.most_common()}


def contacts_csv(samples: ContactSamples, robots: Iterable[str]) -> Iterator[str]:
    """The lines of contacts.csv: a header, then a line per contact."""
    yield ",".join(RobotContact._fields) + "\n"
    for t, robot, part, other, *point in robot_contacts(samples, robots):
        yield ",".join([f"{t:g}", robot, part, other, *(f"{round(along, 4) + 0:.4f}" for along in point)]) + "\n"


def _both_ways(names: tuple[str, str]) -> Iterator[tuple[tuple[str, str, str], tuple[str, str, str]]]:
    one, other = names[0].partition("::"), names[1].partition("::")
    yield one, other
    yield other, one


PERIOD = 0.05
"""Seconds between two rows of a trajectory."""

_SAME = 1e-4
"""Seconds between two times that are one."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotRun:
    """A robot with its name in the world, its start pose, and a function that makes its route for each attempt.

    unevenness: by how much the ground at its start is too uneven for it, metres; 0 where it starts level; way: the one
    that its route follows
    """

    name: str
    robot: DrivableRobot
    start: Pose
    route: Callable[[], Route]
    unevenness: float = 0.0
    way: PlannedWay | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveRecording:
    """The trajectory of every robot by its name, the contact samples, the simulator's error lines, a JPEG if asked.

    There are no samples if contacts were not wanted, or if the simulator does not report any.
    """

    trajectories: Mapping[str, Trajectory]
    samples: ContactSamples
    errors: Sequence[str]
    image: bytes = b""


def record_drive(  # noqa: PLR0913  # each is a parameter of rsegen.drive
    here: Installation,
    world: Path,
    runs: Sequence[RobotRun],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    *,
    contacts: bool = True,
    camera_extent: tuple[float, float] | None = None,
) -> DriveRecording:
    """The recording of robots that drive for `seconds` of simulation time; if the server fails, it is tried again.

    The same runs, world and simulator give the same trajectories. `progress` is called with the simulated seconds that
    are done; contacts: sample them, as in `drive_in_steps`; camera_extent: size in metres of the map that a camera
    looks at, which needs a screen.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        frames = Path(folder, "frames")
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
        models = [here.simulator.with_contact_sensors(model) for model in models] if contacts else models
        extra = [camera(camera_extent, frames)] if camera_extent else []
        text = world_with_robots(world, [*models, *extra], unthrottled=True, backend=here.backend)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        folder_of_models = world.absolute().parent.parent
        attempt = _Attempt(file=file, models=folder_of_models, runs=runs, step=time_step(text), contacts=contacts)
        recording = retried(lambda: attempt.recording(here, seconds, progress, screen=camera_extent is not None))
        return replace(recording, image=last_frame(frames)) if camera_extent else recording


@dataclass(frozen=True, kw_only=True, slots=True)
class _Attempt:
    """One attempt: the world file with robots, the folder of its models, the runs, the physics step in seconds, and
    whether contacts are sampled.
    """

    file: Path
    models: Path
    runs: Sequence[RobotRun]
    step: float
    contacts: bool

    def recording(
        self, here: Installation, seconds: float, progress: Callable[[float], None], *, screen: bool
    ) -> DriveRecording:
        """The recording made in a server of its own."""
        simulator, poses = here.simulator, Record()
        options = simulator.record_options(PERIOD)
        with running_server(here, self.file, models=self.models, options=options, screen=screen) as server:
            with server.connect() as live:
                live.record([run.name for run in self.runs])
                contacts = self.contacts and live.watch_contacts()
                samples = drive_in_steps(live, self.runs, seconds, self.step, progress, poses, contacts=contacts)
                end, recorded = live.clock().simulated, live.recorded()
            errors = server.errors
            server.stop()
            record = _from_the_start(simulator.read_record(server.home) or recorded or poses, poses)
        trajectories = {run.name: _trajectory(run.name, record, end) for run in self.runs}
        return DriveRecording(trajectories=trajectories, samples=samples, errors=errors)


def drive_in_steps(  # noqa: PLR0913  # what a drive is made of
    live: LiveWorld,
    runs: Sequence[RobotRun],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    record: Record | None = None,
    *,
    contacts: bool = True,
) -> ContactSamples:
    """The contact samples of a drive: each period, routes decide on motions, robots get commands, the world steps.

    It ends after `seconds` of simulation time, or when all routes are done. step: seconds of a physics step of the
    world; the poses at the beginning of each period are appended to `record`. Without `contacts` there are no samples.
    """
    routes = {run.name: run.route() for run in runs}
    period = min(route.period for route in routes.values())
    samples: list[tuple[float, Sequence[Contact]]] = []
    for turn in range(ceil(round(seconds / step) / round(period / step))):
        poses = live.poses()
        if record is not None:
            record.append((turn * period, {run.name: list(astuple(poses[run.name])) for run in runs}))
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        send_commands(live, runs, routes, poses)
        done = min((turn + 1) * period, seconds)
        steps = round((done - turn * period) / step)
        if contacts:
            samples.append((turn * period, live.step_with_contacts(steps)))
        else:
            live.step(steps)
        progress(done)
    return samples


def send_commands(
    live: LiveWorld, runs: Sequence[RobotRun], routes: Mapping[str, Route], poses: Mapping[str, Pose]
) -> None:
    """Send every robot the command for the motion that its route wants at its pose."""
    for run in runs:
        v, w = routes[run.name].motion(poses[run.name])
        live.send_command(run.robot.command(run.name, v, w, live.backend))


def _trajectory(name: str, record: Record, end: float) -> Trajectory:
    """The trajectory of a robot; a record has no states for times at which nothing moved, so `end` may be added."""
    rows = [[second, *poses[name]] for second, poses in record if name in poses]
    if not rows:
        raise SimulatorFailed(f"the simulator kept no record of {name}")
    last = [[end, *rows[-1][1:]]] if end > rows[-1][0] + _SAME else []
    return Trajectory(rows=np.array([*rows, *last]))


def _from_the_start(record: Record, poses: Record) -> Record:
    """A record with the first of these poses, which a server that records after its first steps does not have."""
    return [*poses[:1], *record] if poses and record[0][0] > poses[0][0] + _SAME else record
