"""`rsegen.drive`: robots driven over a map in a Gazebo server, and how far each got."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from rsegen.errors import ParameterError, shown
from rsegen.exporters.scene import Scene
from rsegen.params.sorts import Choice, Float, Integer
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.run.store import refuse_busy, refuse_not_a_folder, refuse_taken
from rsegen.simulation.driving.contacts import contact_shares
from rsegen.simulation.driving.drive_metrics import drive_metrics
from rsegen.simulation.driving.drive_result import DrivenRobot, DriveResult
from rsegen.simulation.driving.recording import DriveRecording, RobotRun, record_drive
from rsegen.simulation.driving.robot_runs import ROUTES, driving_speed, finish_x, robot_runs
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.robots import from_file, is_robot_file, robot_of
from rsegen.simulation.robots.base import DrivableRobot, Robot
from rsegen.simulation.robots.drives import Tracks
from rsegen.simulation.robots.limits import LIMITS
from rsegen.simulation.robots.sdf_file import SdfRobot
from rsegen.simulation.robots.solids import Vector
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.launching import choose_installation, has_screen
from rsegen.simulation.worlds import Target, world_of

ROBOTS, DURATION, SEED, ROUTE = Integer(1, 100), Float(0.1, 1e5, unit="s"), Integer(0, SEEDS - 1), Choice(ROUTES)


def drive(  # noqa: PLR0913  # each is a flag of the command
    target: Target,
    *,
    map: int | str | None = None,  # noqa: A002  # the flag's name
    robot: str | os.PathLike[str] | DrivableRobot = "burger",
    wheels: str | None = None,
    size: Vector | None = None,
    speed: float | None = None,
    turn: float | None = None,
    robots: int = 1,
    simulator: str | None = None,
    route: str = "straight",
    duration: float = 30.0,
    seed: int | None = None,
    output: str | Path | None = None,
    contacts: bool = True,
    picture: bool = False,
    force: bool = False,
    progress: Callable[[float], None] = lambda _: None,
) -> DriveResult:
    """Drive robots over a map in a Gazebo server without a window, and give the metrics and trajectory of each.

    robot: a kind, the SDF file of a model, or a robot; wheels: the joints of the model's wheels, if no drive in it is
    known, as LEFT,RIGHT, or FRONT+REAR,FRONT+REAR; size [m], speed [m/s] and turn [rad/s] replace those of an SDF file;
    simulator: `sim` or `classic`, by default the newest that is installed; duration: seconds of simulation time, with
    which `progress` is called; contacts: sample what the robots touch, for 1.5 to 1.8 times the CPU time in Gazebo
    Sim; output: a folder for the files of the result. The same seed and simulator give the same trajectories.
    UserError if a value is wrong or no Gazebo is installed.
    """
    model = _robot(robot, wheels, {"size": size, "speed": speed, "turn": turn})
    seed = fresh_seed() if seed is None else SEED.check("seed", seed)
    count, seconds = ROBOTS.check("robots", robots), DURATION.check("duration", duration)
    route = ROUTE.check("route", route)
    _check_output(output, picture=picture, force=force)
    world = world_of(target, map)
    here, scene = choose_installation(world.made_for, simulator), world.scene()
    runs = robot_runs(scene.field, model, route, count=count, seed=seed)
    with world.on_disk() as file:
        extent = scene.field.extent if picture and "pictures" not in here.simulator.drives_without else None
        recording = record_drive(here, file, runs, seconds, progress, contacts=contacts, camera_extent=extent)
    result = DriveResult(
        scene=scene,
        simulator=str(here),
        route=route,
        seed=seed,
        robots=tuple(_driven(run, scene, recording, route) for run in runs),
        errors=tuple(recording.errors),
        notes=tuple(_notes(here, runs, recording, contacts=contacts, picture=picture)),
        contact_samples=recording.samples,
        way=runs[0].way,
        image=recording.image,
    )
    if output is not None:
        result.write(output, force=force)
    return result


def _robot(
    robot: str | os.PathLike[str] | DrivableRobot, wheels: str | None, given: Mapping[str, object]
) -> DrivableRobot:
    """A robot of a kind or of an SDF file; only for a file may the user give wheels, size, speed and turn rate."""
    given = {name: value for name, value in given.items() if value is not None}
    if isinstance(robot, str | os.PathLike) and is_robot_file(robot):
        values = {name: LIMITS[name].check(name, value) for name, value in given.items()}
        model = from_file(robot, wheels).given(values)
        _ = model.drive  # an error before anything is driven
        return model
    for name in [*given, *(["wheels"] if wheels else [])]:
        kind = robot_of(robot).kind
        raise ParameterError(name, f"is for the robot of a file; {shown(kind)} has its own")
    return robot_of(robot)


def _check_output(output: str | Path | None, *, picture: bool, force: bool) -> None:
    """Raise a UserError, before anything is driven, if the results could not be written."""
    if picture and output is None:
        raise ParameterError("picture", "needs a folder to write into; give an output folder, as in -o DIR")
    if picture and not has_screen():
        raise ParameterError("picture", "Gazebo's camera needs a screen, and there is none; run under xvfb-run -a")
    if output is not None:
        refuse_not_a_folder(Path(output))
        refuse_busy(Path(output).parent)
        refuse_taken([output], force=force, holds="drive")


def _notes(
    here: Installation, runs: Sequence[RobotRun], recording: DriveRecording, *, contacts: bool, picture: bool
) -> Iterator[str]:
    """What was derived from a robot's file, and what the simulator does not give, in a sentence each."""
    if isinstance(runs[0].robot, SdfRobot):
        yield from runs[0].robot.notes(here.backend)
    if contacts and not recording.samples:
        yield f"{here} gives no contacts of a drive"
    if picture and "pictures" in here.simulator.drives_without:
        yield f"{here} gives no pictures of a drive"
    tracked = [run.name for run in runs if isinstance(run.robot, Robot) and isinstance(run.robot.drive, Tracks)]
    still = [name for name in tracked if recording.trajectories[name].is_still]
    if still and here.backend != "classic":
        yield f"{', '.join(still)} did not move: tracks need the physics engine DART 6.13 or later in {here}"


def _driven(run: RobotRun, scene: Scene, recording: DriveRecording, route: str) -> DrivenRobot:
    """The result of one robot."""
    trajectory = recording.trajectories[run.name]
    goal = None if route == Wandering.name else finish_x(scene.field, run.robot)
    shares = contact_shares(recording.samples, run.name)
    metrics = drive_metrics(trajectory, driving_speed(run.robot), goal, shares)
    return DrivenRobot(name=run.name, kind=run.robot.kind, start=run.start, metrics=metrics, trajectory=trajectory)
