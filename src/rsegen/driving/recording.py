"""Recordings of drives: robots driven over a world in a simulator, with their poses and contacts over time.

The world is paused while the routes of all robots decide at their poses; then each gets its command, the world steps
for a period, and contacts are sampled. So the machine's speed decides nothing: the same runs, world and simulator give
the same trajectories. An embedded simulator keeps a record every 0.05 s, and counts contacts at every step. Poses of a
server come from its own record, or from the robots' plug-ins. In a batch of worlds routes decide one after the other.
Cost: the physics, and in a server a round trip per period; in Gazebo Classic 0.4 s, as its paused server answers five
times a second (decision 10). A server that fails is started again, with new routes.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from itertools import pairwise, permutations
from math import ceil, isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsegen.driving.drive_metrics import Trajectory
from rsegen.driving.filming import FilmedWorld, picture_of_end
from rsegen.driving.routes import STOP, PlannedWay, Route
from rsegen.driving.world_file import camera_model, last_frame, time_step, world_with_robots
from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.base import Installation
from rsegen.simulators.batch import BatchWorlds
from rsegen.simulators.embedded import EmbeddedSimulator, PlacedRobot
from rsegen.simulators.poses import Contact, Pose, Record, SteppedWorld, wrapped
from rsegen.simulators.server import attempted, running_server

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
    """Yield the contacts of these robots with other models, in the order of time."""
    names = set(robots)
    for second, contacts in samples:
        for contact in contacts:
            # Both ways round, as a contact between two robots is one of each.
            for (robot, _, part), (touched, _, _) in permutations(name.partition("::") for name in contact.collisions):
                if robot in names and touched != robot:
                    yield RobotContact(round(second, 3), robot, part, touched, *contact.position)


def contact_shares(samples: ContactSamples, robot: str) -> Mapping[str, float]:
    """Return the share of samples in which each part of a robot had contact, 0..1, the largest first."""
    touches = {(contact.t, contact.part) for contact in robot_contacts(samples, [robot])}
    counts = Counter(part for _, part in sorted(touches))
    return {part: round(count / len(samples), 3) for part, count in counts.most_common()}


def contacts_csv(samples: ContactSamples, robots: Iterable[str]) -> Iterator[str]:
    """Yield the lines of contacts.csv: a header, then a line per contact."""
    yield ",".join(RobotContact._fields) + "\n"
    for t, *names, x, y, z in robot_contacts(samples, robots):
        yield ",".join([f"{t:g}", *names, *(f"{round(along, 4) + 0:.4f}" for along in (x, y, z))]) + "\n"


PERIOD = 0.05
"""Seconds between two rows of a trajectory: at 0.4 m/s 2 cm, a tenth of a block or less; logs grow with its inverse."""

_LEAST = 1e-3
"""Metres or radians: smaller numbers in a record count as written as exactly as this one."""

_SAME = 1e-4
"""Seconds between two times that are one: a tenth of a physics step."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotRun(PlacedRobot):
    """A robot with its name in the world, its start pose, and a function that makes its route anew for each attempt.

    way: the one that its route follows
    """

    route: Callable[[], Route]
    way: PlannedWay | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveRecording:
    """The recording of a drive: trajectories by robot, contact samples, and the simulator's error lines.

    samples: empty if contacts were not wanted, or if the simulator does not report any
    image, video: a JPEG and an animated WebP, if they are asked for
    attempts: number of servers that were started; all before the last one failed
    touched: for each robot, the share of all steps in which each part had contact, if the simulator counts them
    notes: on the physics of the robots
    """

    trajectories: Mapping[str, Trajectory]
    samples: ContactSamples
    errors: Sequence[str]
    image: bytes = b""
    video: bytes = b""
    attempts: int = 1
    touched: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    notes: Sequence[str] = ()

    def shares(self, robot: str) -> Mapping[str, float]:
        """Return the share of the time in which each part of a robot had contact, 0..1, the largest first."""
        return self.touched[robot] if robot in self.touched else contact_shares(self.samples, robot)


def record_embedded(  # noqa: PLR0913  # as `record_drive`
    simulator: EmbeddedSimulator,
    scene: Scene,
    runs: Sequence[RobotRun],
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    *,
    contacts: bool = True,
    motors: str | None = None,
    picture: bool = False,
    video: bool = False,
) -> DriveRecording:
    """Return the recording of robots that drive in this process for `seconds` of simulation time.

    The same runs, scene and simulator give the same trajectories, bit by bit, with a picture or a video too.
    """
    simulator.refuse_missing()
    world = simulator.world(scene, runs, motors=motors or MOTORS[0], period=PERIOD)
    filmed = FilmedWorld(world, scene, runs) if video else None
    samples = drive_in_steps(filmed or world, runs, seconds, world.step_seconds, progress, contacts=contacts)
    return DriveRecording(
        trajectories=trajectories(world.recorded(), runs),
        samples=samples,
        image=picture_of_end(scene, runs, world.link_poses()) if picture else b"",
        video=filmed.video() if filmed else b"",
        errors=[],
        touched=world.shares() if contacts else {},
        notes=list(world.notes()),
    )


def record_batch(
    title: str, worlds: BatchWorlds, runs: Sequence[RobotRun], seconds: float
) -> list[DriveRecording | SimulatorFailed]:
    """Return the recordings of robots that drive in a world each, for `seconds` of simulation time, or their errors.

    Each begins, decides, is recorded and ends as in `record_embedded`; a robot at its goal waits for the others.
    title: of the simulator, for errors. All routes have the same period.
    """
    # Marks are the steps at which routes decide, or poses are recorded; all worlds step from mark to mark together.
    routes = [run.route() for run in runs]
    period, look, end = (round(part / worlds.step_seconds) for part in (routes[0].period, PERIOD, seconds))
    marks = sorted({*range(0, end, period), *range(0, end, look), end})
    rows = np.empty((len(runs), len(marks), 7))
    driving, counts = dict(enumerate(routes)), [len(marks)] * len(runs)
    failures: dict[int, SimulatorFailed] = {}

    def look_at(mark: int) -> None:
        """Record the poses of all robots at a mark, and end the drives of worlds that have failed."""
        second = round(marks[mark] * worlds.step_seconds, 6)
        rows[:, mark, 0], rows[:, mark, 1:] = second, worlds.poses()
        for world, why in worlds.problems().items():
            if driving.pop(world, None):
                problem = f"{title}: after {second:g} s {why}, so this drive has no result"
                failures[world] = SimulatorFailed(problem)

    look_at(0)
    for mark, (begin, until) in enumerate(pairwise(marks)):
        if begin % period == 0:
            worlds.drive(*_motions(driving, rows[:, mark, 1:]).T)
            # The record of a world ends at the first mark at which its robot does not drive.
            counts = [count if world in driving else min(count, mark + 1) for world, count in enumerate(counts)]
        if not driving:
            break
        worlds.step(until - begin)
        look_at(mark + 1)
    return [
        failures.get(world)
        or DriveRecording(trajectories={run.name: Trajectory(rows=rows[world, : counts[world]])}, samples=(), errors=())
        for world, run in enumerate(runs)
    ]


def _motions(driving: dict[int, Route], poses: Array) -> Array:
    """Return v and w of robots at their poses, (worlds, 2); robots at their goals stop, and leave `driving`."""
    motions = np.zeros((len(poses), 2))
    for world, route in list(driving.items()):
        at = Pose.of(poses[world].tolist())
        if route.is_done(at):
            del driving[world]
        else:
            motions[world] = route.motion(at)
    return motions


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
    """Return the recording of robots that drive for `seconds` of simulation time; a failed server is tried again.

    The same runs, world and simulator give the same trajectories. `progress` is called with the simulated seconds that
    are done; contacts: sample them, as in `drive_in_steps`; camera_extent: size in metres of the map that a camera
    looks at, which needs a screen.
    """
    # The world with the robots is written once, next to no other; each attempt runs it in its own server.
    simulator, screen = here.simulator, camera_extent is not None
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        frames = Path(folder, "frames")
        models = [run.robot.model(run.name, here.backend, astuple(run.start)) for run in runs]
        models = [simulator.with_contact_sensors(model) for model in models] if contacts else models
        models += [camera_model(camera_extent, (1280, 720), rate=1, frames=frames)] if camera_extent else []
        text = world_with_robots(world, models, unthrottled=True, backend=here.backend)
        file = Path(folder, world.name)
        file.write_text(text, "utf-8")
        folder_of_models, options = world.absolute().parent.parent, simulator.record_options(PERIOD)

        def attempt() -> DriveRecording:
            poses = Record()
            with running_server(here, file, models=folder_of_models, options=options, screen=screen) as server:
                with server.connect() as live:
                    live.record([run.name for run in runs])
                    watched = contacts and live.watch_contacts()
                    samples = drive_in_steps(live, runs, seconds, time_step(text), progress, poses, contacts=watched)
                    end, recorded = live.clock().simulated, live.recorded()
                errors = server.errors
                server.stop()
                record = simulator.read_record(server.home) or recorded or poses
            if poses and record[0][0] > poses[0][0] + _SAME:  # a server that records later has no start
                record = [*poses[:1], *record]
            if simulator.digits:
                record = with_more_digits(record, poses, simulator.digits)
            driven = trajectories(record, runs, end)
            if missing := [run.name for run in runs if run.name not in driven]:
                raise SimulatorFailed(f"the simulator kept no record of {missing[0]}")
            return DriveRecording(trajectories=driven, samples=samples, errors=errors)

        recording, attempts = attempted(attempt)
        return replace(recording, attempts=attempts, image=last_frame(frames) if screen else b"")


def drive_in_steps(  # noqa: PLR0913  # what a drive is made of
    world: SteppedWorld,
    runs: Sequence[RobotRun],
    seconds: float,
    step: float,
    progress: Callable[[float], None] = lambda _: None,
    record: Record | None = None,
    *,
    contacts: bool = True,
) -> ContactSamples:
    """Drive, and return the contact samples: each period, routes decide, robots get commands, the world steps.

    It ends after `seconds` of simulation time, or when all routes are done. step: seconds of a physics step of the
    world; the poses at the beginning of each period, and at the end, are appended to `record`. Without `contacts` there
    are no samples.
    """
    # All robots share the period of the quickest route; it is a whole number of physics steps, so no time is lost.
    routes = {run.name: run.route() for run in runs}
    period = min(route.period for route in routes.values())
    samples: list[tuple[float, Sequence[Contact]]] = []
    for turn in range(ceil(round(seconds / step) / round(period / step))):
        poses = world.poses()
        if record is not None:
            record.append((turn * period, _rows(poses, runs)))
        if all(route.is_done(poses[name]) for name, route in routes.items()):
            break
        send_commands(world, runs, routes, poses)
        done = min((turn + 1) * period, seconds)
        steps = round((done - turn * period) / step)
        if contacts:
            samples.append((turn * period, world.step_with_contacts(steps)))
        else:
            world.step(steps)
        progress(done)
    else:
        if record is not None:
            record.append((seconds, _rows(world.poses(), runs)))
    return samples


def _rows(poses: Mapping[str, Pose], runs: Sequence[RobotRun]) -> dict[str, list[float]]:
    """Return the poses of robots as a record has them."""
    return {run.name: list(astuple(poses[run.name])) for run in runs}


def with_more_digits(record: Record, exact: Record, digits: int) -> Record:
    """Return a record of poses that have few significant digits, made sharper by exact poses at some of its times.

    Between these a robot goes straight as far as the record allows: each number stays within half of its last digit. So
    poses are exact where they are known, and change evenly where the record says nothing, as in `11.2, 11.2, 11.3`.
    """
    # Angles of the exact poses are unwrapped, so that numbers between pi and -pi are on the short way.
    times = [second for second, _ in exact]
    known = {name: np.array([poses[name] for _, poses in exact]) for name in (exact[0][1] if exact else ())}
    for rows in known.values():
        rows[:, 3:] = np.unwrap(rows[:, 3:], axis=0)
    result: Record = []
    for second, poses in record:
        sharp = dict(poses)
        for name in known.keys() & poses.keys():
            between = np.array([np.interp(second, times, along) for along in known[name].T])
            pose = np.array(poses[name])
            off = between - pose
            off[3:] = wrapped(off[3:])
            half = 0.5 * 10.0 ** (np.floor(np.log10(np.maximum(np.abs(pose), _LEAST))) + 1 - digits)
            sharp[name] = [*map(float, pose + np.clip(off, -half, half))]
        result.append((second, sharp))
    return result


def send_commands(
    world: SteppedWorld, runs: Sequence[RobotRun], routes: Mapping[str, Route], poses: Mapping[str, Pose]
) -> None:
    """Command every robot to drive as its route decides at its pose, or to stop if the pose is not finite."""
    for run in runs:
        at = poses[run.name]
        v, w = routes[run.name].motion(at) if all(map(isfinite, astuple(at))) else STOP
        world.drive(run.name, run.robot, v, w)


def trajectories(record: Record, runs: Sequence[RobotRun], end: float = 0.0) -> dict[str, Trajectory]:
    """Return the trajectories of robots that were in a record, by their names.

    A record has no state for times without motion, so the last row may be repeated at `end`, seconds.
    """
    driven = {}
    for run in runs:
        rows = [[second, *poses[run.name]] for second, poses in record if run.name in poses]
        if rows:
            last = [[end, *rows[-1][1:]]] if end > rows[-1][0] + _SAME else []
            driven[run.name] = Trajectory(rows=np.array([*rows, *last]))
    return driven
