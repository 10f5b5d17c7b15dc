"""`rsegen.drive`: robots driven over a map in a simulator, and how far each got, as a report, files and a picture.

Everything is checked before a server starts: the robot's file, its places, and whether the results can be written.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from math import ceil
from pathlib import Path, PurePosixPath

from rsegen.driving.drive_metrics import (
    SLOW,
    TIPPED,
    Course,
    DriveMetrics,
    Trajectory,
    drive_metrics,
    moves_by_window,
    possible_part,
)
from rsegen.driving.plots import trajectory_plot
from rsegen.driving.prediction import Prediction
from rsegen.driving.recording import ContactSamples, DriveRecording, RobotRun, contacts_csv
from rsegen.driving.robot_runs import finish_x
from rsegen.driving.routes import AlongWay, PlannedWay, Wandering
from rsegen.errors import ParameterError
from rsegen.params.command import Reported
from rsegen.params.numbers import lengths_in, whole_degrees
from rsegen.recipe.codec import map_json
from rsegen.robots.base import Robot
from rsegen.robots.drives import Tracks
from rsegen.robots.files.sdf_file import SdfRobot
from rsegen.robots.lookup import DrivableRobot, chosen_robot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.base import Installation
from rsegen.simulators.embedded import EmbeddedSimulator
from rsegen.simulators.poses import Pose
from rsegen.standing.spots import GAP
from rsegen.standing.ways import events
from rsegen.writing.programs import has_screen
from rsegen.writing.store import refuse_busy, refuse_taken, write_folder

_PARTS = 5
"""The parts of a robot with the most contacts that are reported, on one line; drive.json has all."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DrivenRobot:
    """A robot of a drive: its name in the world, kind, start pose, metrics and trajectory."""

    name: str
    kind: str
    start: Pose
    metrics: DriveMetrics
    trajectory: Trajectory


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DriveResult(Reported):
    """The result of `rsegen.drive`.

    Attributes
    ----------
    scene : Scene
        The map.
    simulator : str
        Title and version.
    route : str
        How the robots were sent.
    seed : int
        Seed of start poses and routes.
    robots : tuple of DrivenRobot
        Each robot with its trajectory and what is measured on it.
    errors : tuple of str
        The simulator's error lines.
    contact_samples : ContactSamples
        Simulated seconds, and the contacts at that time.
    notes : tuple of str
        What the simulator does not record, and what is odd about the drive, a sentence each.
    way : PlannedWay or None
        The way that the robots followed, on that route.
    prediction : Prediction or None
        How surely a robot gets across, as predicted by drives in the embedded simulator.
    image : bytes
        A JPEG of the end, empty without `picture`.
    video : bytes
        An animated WebP, empty without `video`.
    file : str or None
        The file of the robot, with its arguments, as it was named; None for a kind.
    motors : str or None
        How motors acted in MuJoCo; None in Gazebo, which has its own.
    duration : float or None
        The longest simulation time, seconds.
    """

    scene: Scene
    simulator: str
    route: str
    seed: int
    robots: tuple[DrivenRobot, ...]
    errors: tuple[str, ...]
    contact_samples: ContactSamples = field(repr=False)
    notes: tuple[str, ...] = ()
    way: PlannedWay | None = None
    prediction: Prediction | None = None
    image: bytes = field(default=b"", repr=False)
    video: bytes = field(default=b"", repr=False)
    file: str | None = None
    motors: str | None = None
    duration: float | None = None

    @property
    def pictures(self) -> list[str]:
        """The names of the pictures and of the film in the folder of the drive."""
        return [*PLOTS, *([PICTURE] if self.image else []), *([VIDEO] if self.video else [])]

    def as_json(self) -> dict[str, object]:
        """Return the content of drive.json, which `rsegen drive --json` prints."""
        return {
            "map": self.scene.name,
            "file": self.file,
            "simulator": self.simulator,
            "motors": self.motors,
            "route": self.route,
            "duration": self.duration,
            "seed": self.seed,
            **({"way": self.way.as_json()} if self.way else {}),
            **({"prediction": self.prediction.as_json()} if self.prediction else {}),
            "robots": [
                {"name": robot.name, "kind": robot.kind, "start": asdict(robot.start), **asdict(robot.metrics)}
                | {"incidents": [asdict(incident) for incident in robot.metrics.incidents]}
                for robot in self.robots
            ],
            "errors": list(self.errors),
            "notes": list(self.notes),
        }

    def report(self) -> Iterator[str]:
        """Yield the lines that `rsegen drive` prints: robots, their contacts, notes and warnings."""
        seed = f", seed {self.seed}" if self.route == Wandering.name else ""
        if self.prediction:
            yield f"predicted: {self.prediction}"
        if self.way:
            yield f"planned: {_foreseen(self.way)}"
        yield f"driven on {self.scene.name} in {self.simulator}, route {self.route}{seed}:"
        for robot in self.robots:
            metrics = robot.metrics
            crossed = "" if self.route == Wandering.name else _crossed(robot)
            tipped = f", tipped over {metrics.tipped}x" if metrics.tipped else ""
            driven = f"{metrics.distance:.2f} m in {metrics.seconds:g} s"
            incidents = "".join(f"; {incident}" for incident in metrics.incidents)
            yield f"  {robot.name}: {driven}{crossed}, stuck {metrics.stuck:g} s{tipped}{incidents}"
            if metrics.touched:
                most = list(metrics.touched.items())[:_PARTS]
                shares = ", ".join(f"{part} {share:.0%}" for part, share in most)
                yield f"    contact time per part (link::shape): {shares}"
        yield from (f"note: {line}" for line in self.notes)
        yield from (f"warning: {line}" for line in dict.fromkeys(self.errors))

    def write(self, folder: str | Path, *, force: bool = False) -> None:
        """Write trajectories, contacts, metrics and pictures into a folder; `force` replaces an earlier drive."""
        trajectories = {robot.name: robot.trajectory for robot in self.robots}
        files = {f"{name}.csv": _encoded(trajectory.csv()) for name, trajectory in trajectories.items()} | {
            "contacts.csv": _encoded(contacts_csv(self.contact_samples, trajectories)),
            "recipe.json": [map_json(self.scene.recipe, self.scene.index)],
            "drive.json": [json.dumps(self.as_json(), indent=2).encode() + b"\n"],
            **{plot: [trajectory_plot(self.scene, trajectories, self.way, plot.partition(".")[2])] for plot in PLOTS},
        }
        files |= {"way.csv": _encoded(self.way.csv())} if self.way else {}
        files |= {PICTURE: [self.image]} if self.image else {}
        files |= {VIDEO: [self.video]} if self.video else {}
        paths = {PurePosixPath(name): content for name, content in files.items()}
        write_folder(paths, Path(folder), "drive", force=force)


def _foreseen(way: PlannedWay) -> str:
    """Return the forecast for the way that the robots follow."""
    if way.length is not None:
        tilt, margin = (whole_degrees(angle or 0.0) for angle in (way.tilt, way.margin))
        steepest = f"the robot tilts by up to {tilt}, {margin} from tipping over{_at(way.margin_at)}"
        return f"a way of {way.length:.2f} m across; {', '.join([steepest, *events(way)])}"
    return f"no way across by its poses; it follows the best straight lane, where it {way.reason}{_at(way.at)}"


def _at(place: tuple[float, float] | None) -> str:
    """Return a place [m] in words that follow an event there; `+ 0` makes -0.0 a plain 0."""
    return f" at {place[0] + 0:.2f}, {place[1] + 0:.2f} m" if place else ""


def _crossed(robot: DrivenRobot) -> str:
    """Return when a robot was across, or where it was at the end."""
    if robot.metrics.crossed is not None:
        return f", crossed the map after {robot.metrics.crossed:g} s"
    if robot.metrics.incidents or not len(robot.trajectory.rows):
        return ", did not cross the map"
    x, y = robot.trajectory.rows[-1, 1:3] + 0.0
    return f", did not cross the map: it is at x {x:.2f}, y {y:.2f} m at the end"


def _encoded(lines: Iterable[str]) -> list[bytes]:
    return [line.encode() for line in lines]


PLOTS, PICTURE, VIDEO = ("drive.png", "drive.pdf"), "picture.jpg", "drive.webp"
"""Names in the folder of a drive: of the plans with the trajectories, the picture of the end, and the video."""


def file_names(runs: Sequence[RobotRun], *, picture: bool, video: bool) -> list[str]:
    """Return the names of the files of a drive in its folder."""
    usual = ("contacts.csv", "recipe.json", "drive.json", *PLOTS)
    names = [*(f"{run.name}.csv" for run in runs), *usual]
    return [*names, *(["way.csv"] if runs[0].way else []), *([PICTURE] if picture else []), *([VIDEO] if video else [])]


def drivable(
    robot: str | os.PathLike[str] | DrivableRobot, wheels: str | None, tracks: str | None, **limits: object
) -> DrivableRobot:
    """Return a robot of a kind or of a file that has a drive, as `chosen_robot` does."""
    model = chosen_robot(robot, wheels, tracks, **limits)
    _ = model.drive  # an error before anything is driven
    return model


def refuse_best(best: str | None, route: str) -> None:
    """Raise a ParameterError if the best way is asked for on another route."""
    if best is not None and route != AlongWay.name:
        raise ParameterError("best", f"is for route {AlongWay.name}, not for {route}")


def refuse_in_gazebo(*, picture: bool, video: bool) -> None:
    """Raise a ParameterError for what Gazebo does not give: a video, and a picture without a screen."""
    if video:
        raise ParameterError("video", "is for MuJoCo; Gazebo cannot record a video of a drive")
    if picture and not has_screen():
        raise ParameterError("picture", "Gazebo's camera needs a screen, and there is none; run under xvfb-run -a")


def refuse_output(output: Path | None, *, picture: bool, video: bool, force: bool) -> None:
    """Raise a UserError, before anything is driven, if the results could not be written."""
    for name, is_wanted in (("picture", picture), ("video", video)):
        if is_wanted and output is None:
            raise ParameterError(name, "needs a folder to write into; set output='DIR' too")
    if output is not None:
        for folder in (output, output.parent):
            refuse_busy(folder)
        refuse_taken([output], force=force, holds="drive")


def drive_notes(
    here: Installation | EmbeddedSimulator,
    runs: Sequence[RobotRun],
    recording: DriveRecording,
    *,
    contacts: bool,
    picture: bool,
) -> Iterator[str]:
    """Yield notes on what was derived from a robot's file, what went wrong, and what the simulator does not record."""
    yield from recording.notes
    if isinstance(runs[0].robot, SdfRobot):
        yield from runs[0].robot.notes(here.backend)
    if recording.attempts > 1:
        yield f"{here} failed and was started again; this is attempt {recording.attempts}"
    if contacts and not recording.samples:
        yield f"{here} does not record contacts of a drive"
    if picture and "pictures" in here.drives_without:
        yield f"{here} cannot take pictures of a drive"


def still_notes(
    here: Installation | EmbeddedSimulator,
    runs: Sequence[RobotRun],
    recording: DriveRecording,
    route: str,
    motors: str | None,
) -> Iterator[str]:
    """Yield a note on each robot that hardly moved, and why that may be; `motors`: how they acted in MuJoCo."""
    # Robots on tracks that stand still have one known reason, which the notes on single robots would hide.
    tracked = [run.name for run in runs if isinstance(run.robot, Robot) and isinstance(run.robot.drive, Tracks)]
    still = [name for name in tracked if recording.trajectories[name].is_still]
    if still and here.backend in ("sim", "fortress"):
        yield f"{', '.join(still)} did not move: tracks need the physics engine DART 6.13 or later in {here}"
        return
    has_torque = here.backend != "classic" and motors != MOTORS[1]
    for run in runs:
        yield from _hardly_moved(run, recording.trajectories[run.name], route, has_torque=has_torque)


def frame_notes(scene: Scene, runs: Sequence[RobotRun], recording: DriveRecording) -> Iterator[str]:
    """Yield a note if robots stand before the frame in the west at the end: they do not get over it."""
    field = scene.field
    west = -field.extent[0] / 2
    held = []
    # Held at the frame: in the last second its front is at the map, its middle not yet, and it hardly moves.
    for run in runs:
        rows = recording.trajectories[run.name].rows
        last = rows[rows[:, 0] > rows[-1, 0] - _NOTICED, 1] if len(rows) else rows[:, 0]
        front = last + run.robot.size[0] / 2
        is_there = (front > west - GAP / 4).all() and (last < west + field.block_width).all()
        if len(last) > 1 and is_there and last.max() - last.min() < SLOW * _NOTICED * run.robot.driving_speed:
            held.append(run.name)
    if held and field.frame[0].all():
        written = lengths_in(scene.units)
        is_helped = field.frame_height < _CRAWLED + 1e-9 and runs[0].robot.kind != "crawler"
        crawler = f"use robot='crawler', which climbs {written.with_unit(_CRAWLED, 3)}, or " if is_helped else "use "
        height = written.with_unit(field.frame_height, 3)
        advice = f"{crawler}boundary='none', which makes the map without frames"
        yield f"the frame, {height} high, stopped {', '.join(held)}; {advice}"


_CRAWLED = 0.1
"""Metres of a frame that the crawler gets over in every simulator."""


def short_notes(prediction: Prediction | None, robots: Sequence[DrivenRobot], seconds: float) -> Iterator[str]:
    """Yield a note if a drive of some seconds is shorter than the drives of its prediction took to cross."""
    if prediction is None or prediction.seconds is None or prediction.seconds <= seconds:
        return
    if late := [robot.name for robot in robots if robot.metrics.crossed is None]:
        took = f"the drives of the prediction that crossed took {prediction.seconds:.0f} s"
        yield f"{', '.join(late)} had {seconds:g} s, and {took}; use duration={ceil(1.5 * prediction.seconds)}"


_LIKELY = 0.5
"""Probability of crossing from which on the simulator is to be doubted if a robot is held."""


def solver_notes(
    backend: str, scene: Scene, prediction: Prediction | None, robots: Sequence[DrivenRobot]
) -> Iterator[str]:
    """Yield a note if robots that were likely to cross are held in Gazebo Sim, whose default solver may be why."""
    if backend not in ("sim", "fortress") or scene.recipe.solver != "dantzig":
        return
    if prediction is None or prediction.probability < _LIKELY:
        return
    if held := [robot.name for robot in robots if robot.metrics.crossed is None and robot.metrics.stuck > _NOTICED]:
        yield f"{', '.join(held)} may be held by the solver of contacts; solver='pgs' makes the map with another one"


_NOTICED = 1.0
"""Seconds after which a robot that hardly moves is noticed: one that starts has its speed after some tenths."""


def _hardly_moved(run: RobotRun, trajectory: Trajectory, route: str, *, has_torque: bool) -> Iterator[str]:
    """Yield a note if a robot moved by less than SLOW of its commanded distance where no block can be the reason.

    has_torque: whether its motors have a torque, with which light wheels push as well as heavy ones
    """
    # A robot is on level ground in the gap before the map. Only half of the gap counts, as a robot held at the first
    # block may not have come all of it. On a random route a block may hold a robot anywhere.
    drive, _ = possible_part(trajectory, run.robot.driving_speed, run.robot.size)
    t, x, y = drive.rows[:, :3].T
    level = x < run.start.x + GAP / 2
    end = len(x) if route == Wandering.name or level.all() else int(level.argmin()) + 1
    lengths, moves = moves_by_window(t[:end], x[:end], y[:end])
    seconds, moved = float(lengths.sum()), float(moves.sum())
    commanded = run.robot.driving_speed * seconds
    if seconds < _NOTICED or moved >= SLOW * commanded or drive.tilt.max() > TIPPED:
        return
    share = f"{run.name} moved {moved:.2f} m in {seconds:.3g} s, {moved / commanded:.1%} of what was commanded"
    parts = ", ".join((*run.robot.drive.left, *run.robot.drive.right))
    doubt = f"perhaps {parts} do not turn, do not touch the ground, or are not what it drives on"
    if not has_torque and isinstance(run.robot, SdfRobot) and (light := run.robot.light_wheels):
        doubt += f"; or, without a reaction of its motors, {light}"
    if route == Wandering.name:
        yield f"{share}: it is stuck where it started, or {doubt}"
    else:
        yield f"{share}, on the level ground before the map: {doubt}"


def driven_robot(run: RobotRun, scene: Scene, recording: DriveRecording, route: str) -> DrivenRobot:
    """Return the result of a robot's run out of a recording."""
    trajectory, robot = recording.trajectories[run.name], run.robot
    course = Course.over(scene.field, None if route == Wandering.name else finish_x(scene.field, robot))
    shares = recording.shares(run.name)
    metrics = drive_metrics(trajectory, robot.driving_speed, robot.size, course, shares)
    return DrivenRobot(name=run.name, kind=robot.kind, start=run.start, metrics=metrics, trajectory=trajectory)
