"""The commands `rsegen drive` and `rsegen drives`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

from rsegen.cli.flags import add_input, add_recipe_flags, add_target_recipe_flags, recipe_from, target_of, which_map
from rsegen.cli.parameters import Force, MapReference, Scheduler, Workers
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, checked_flags, progress_shown, seconds_bar
from rsegen.driving.parameters import Best, Drives, DriveSeed, Duration, RouteName, Size, Speed, Tracks, Turn, Wheels
from rsegen.errors import ParameterError, shown
from rsegen.field.crossing import robot_kinds
from rsegen.params.command import Shell, add_flags, command, default, flags_in_errors, given
from rsegen.params.sorts import Choice, FilePath, Flag, Integer
from rsegen.pictures.flags import PictureName, picture_of
from rsegen.robots.parameters import MOTORS, MotorModel, RobotModel
from rsegen.simulators.parameters import OWN_FLAGS, WORLD, DriveSimulator, ManySimulator, Timeout, ignore

if TYPE_CHECKING:
    from rsegen.driving.drive import DriveResult
    from rsegen.driving.many import ManyDrives
    from rsegen.driving.prediction import Prediction
    from rsegen.recipe.recipe import Recipe
    from rsegen.writing.target_worlds import Target


@command
def drive(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    wheels: Wheels = None,
    tracks: Tracks = None,
    size: Size = None,
    speed: Speed = None,
    turn: Turn = None,
    robots: Annotated[int, Integer(1, 100, usual=(1, 10), help="number of robots"), Shell(metavar="N")] = 1,
    simulator: DriveSimulator = None,
    motors: MotorModel = None,
    route: RouteName = "straight",
    best: Best = None,
    duration: Duration = 30.0,
    seed: DriveSeed = None,
    predict: Annotated[
        bool,
        Flag(help="first predict how surely the robot gets across, by drives in MuJoCo"),
        Shell(help="skip the prediction before the drive; ways are then planned from poses alone"),
    ] = True,
    output: Annotated[
        str | Path | None,
        FilePath(help="folder for trajectories, metrics and a picture"),
        Shell(("-o", "--output"), "DIR"),
    ] = None,
    contacts: Annotated[
        bool,
        Flag(help="record what the robots touch"),
        Shell(help="do not record contacts; with them Gazebo Sim takes 1.5 to 1.8 times the CPU time"),
    ] = True,
    picture: Annotated[
        bool,
        Flag(
            help="add picture.jpg to the folder: the end of the drive from the south-west; in Gazebo it needs a screen"
        ),
    ] = False,
    video: Annotated[
        bool, Flag(help="add drive.webp to the folder: the drive from the south-west in real time; in MuJoCo")
    ] = False,
    force: Force = False,
    timeout: Timeout = 20.0,
    progress: Callable[[float], None] | None = None,
) -> DriveResult:
    """Drive robots over a map in a simulator without a window, and report how far each got.

    The same seed and simulator give the same trajectories.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        A world made by rsegen, its folder, a recipe or a scene.
    progress : callable, optional
        Called with the simulation time in seconds.

    Returns
    -------
    DriveResult
        Trajectories, metrics and contacts.

    Raises
    ------
    UserError
        If a value is wrong, or the simulator is not installed.
    """
    from rsegen.driving.drive import (
        DriveResult,
        drivable,
        drive_notes,
        driven_robot,
        file_names,
        frame_notes,
        refuse_best,
        refuse_in_gazebo,
        refuse_output,
        short_notes,
        solver_notes,
        still_notes,
    )
    from rsegen.driving.planning import planned_runs, predictor_for
    from rsegen.driving.recording import record_drive, record_embedded
    from rsegen.params.streams import fresh_seed
    from rsegen.robots.lookup import robot_file
    from rsegen.simulators.base import Installation
    from rsegen.simulators.embedded import embedded_simulator
    from rsegen.simulators.server import choose_installation
    from rsegen.writing.dry import announce_files
    from rsegen.writing.execute import cores
    from rsegen.writing.store import unchanged_if_stopped
    from rsegen.writing.target_worlds import world_of

    # All that can be wrong is refused before a simulator is started, which may take seconds.
    refuse_best(best, route)
    model = drivable(robot, wheels, tracks, size=size, speed=speed, turn=turn)
    seed = fresh_seed() if seed is None else seed
    refuse_output(None if output is None else Path(output), picture=picture, video=video, force=force)
    world, embedded = world_of(target, map), embedded_simulator(simulator)
    if motors is not None and not embedded:
        raise ParameterError("motors", f"is for MuJoCo; {shown(simulator)} has its own motors")
    if not embedded:
        refuse_in_gazebo(picture=picture, video=video)
    program = embedded or choose_installation(world.made_for, simulator, timeout)
    scene, report = world.scene(), progress or ignore
    predictor = predictor_for(program.backend, motors, cores()) if predict else None
    runs, prediction = planned_runs(predictor, scene, model, route, count=robots, seed=seed, best=best or "safe")
    pictured = picture and "pictures" not in program.drives_without
    if output is not None:
        announce_files(Path(output), file_names(runs, picture=pictured, video=video), is_whole=True)
    with unchanged_if_stopped(output):
        if isinstance(program, Installation):
            extent = scene.field.extent if pictured else None
            with world.on_disk() as file:
                recording = record_drive(program, file, runs, duration, report, contacts=contacts, camera_extent=extent)
        else:
            recorded = {"contacts": contacts, "picture": pictured, "video": video}
            recording = record_embedded(program, scene, runs, duration, report, motors=motors, **recorded)
    driven = tuple(driven_robot(run, scene, recording, route) for run in runs)
    result = DriveResult(
        scene=scene,
        simulator=str(program),
        route=route,
        seed=seed,
        robots=driven,
        errors=tuple(recording.errors),
        notes=(
            *drive_notes(program, runs, recording, contacts=contacts, picture=picture),
            *still_notes(program, runs, recording, route, motors),
            *frame_notes(scene, runs, recording),
            *short_notes(prediction, driven, duration),
            *solver_notes(program.backend, scene, prediction, driven),
        ),
        contact_samples=recording.samples,
        way=runs[0].way,
        prediction=prediction,
        image=recording.image,
        video=recording.video,
        file=robot_file(robot),
        motors=(motors or MOTORS[0]) if embedded else None,
        duration=duration,
    )
    if output is not None:
        result.write(output, force=force)
    return result


@command
def drive_many(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    *,
    maps: int | None = None,
    robot: RobotModel = "burger",
    wheels: Wheels = None,
    tracks: Tracks = None,
    size: Size = None,
    speed: Speed = None,
    turn: Turn = None,
    simulator: ManySimulator = None,
    motors: MotorModel = None,
    route: RouteName = "straight",
    best: Best = None,
    duration: Duration = 30.0,
    output: Annotated[
        str | Path | None, FilePath(help="folder for the table of all drives"), Shell(("-o", "--output"), "DIR")
    ] = None,
    force: Force = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    progress: Callable[[int], None] | None = None,
) -> ManyDrives:
    """Drive a robot over each map of a recipe, in MuJoCo, and count how many it crosses.

    One robot over each map, on all cores or a Dask cluster. `rsegen drive` over a map gives the same drive, bit by bit,
    wherever it is simulated. In mujoco-warp thousands of maps are driven side by side, straight across, with numbers of
    32 bits: robots are mostly within a millimetre in the first second, and most drives end alike.

    Parameters
    ----------
    recipe : Recipe
        The maps.
    maps : int, optional
        Their number; by default all maps of the recipe.
    progress : callable, optional
        Called with the number of drives that are done now and then.

    Returns
    -------
    ManyDrives
        A row for each drive, and the share of maps that were crossed with its interval.

    Raises
    ------
    UserError
        If a value is wrong, or the simulator is not installed.
    """
    from rsegen.driving.drive import drivable, refuse_best
    from rsegen.driving.many import ManyPlan, make_drives
    from rsegen.recipe.recipe import with_maps
    from rsegen.robots.lookup import robot_file
    from rsegen.simulators.batch import batch_simulator
    from rsegen.writing.execute import Execution
    from rsegen.writing.store import refuse_taken, unchanged_if_stopped

    # As in `drive`: all that can be wrong is refused before the first of thousands of drives.
    refuse_best(best, route)
    plan = ManyPlan(
        recipe=with_maps(recipe, maps),
        robot=drivable(robot, wheels, tracks, size=size, speed=speed, turn=turn),
        motors=motors,
        route=route,
        best=best or "safe",
        duration=duration,
        file=robot_file(robot),
        batch=batch_simulator(simulator),
    )
    if output is not None:
        refuse_taken([Path(output)], force=force, holds="drives")
    with unchanged_if_stopped(output):
        result = make_drives(plan, Execution(workers=workers, scheduler=scheduler), progress or ignore)
    if output is not None:
        result.write(output, force=force)
    return result


@command
def predict(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    wheels: Wheels = None,
    tracks: Tracks = None,
    size: Size = None,
    speed: Speed = None,
    turn: Turn = None,
    motors: MotorModel = None,
    route: Annotated[str, Choice(("way", "straight"), help="along the safest way found, or straight across")] = "way",
    best: Best = None,
    drives: Drives = 20,
) -> Prediction:
    """Predict how surely a robot gets across a map, from west to east.

    It is driven in MuJoCo again and again, each time with other errors of its start, its position, friction and the
    heights of blocks, until the outcome is plain: 6 drives that end alike, or up to `drives`. On route way, ways are
    planned by poses, tried, and planned anew by what drives have shown.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        As for `rsegen.drive`.

    Returns
    -------
    Prediction
        The probability, the drives, where and why they ended, and the way.

    Raises
    ------
    UserError
        If a value is wrong, or MuJoCo is not installed.
    """
    from rsegen.driving.drive import drivable, refuse_best
    from rsegen.driving.planning import planned_runs, required_simulator
    from rsegen.driving.prediction import Predictor
    from rsegen.writing.execute import cores
    from rsegen.writing.target_worlds import world_of

    refuse_best(best, route)
    model = drivable(robot, wheels, tracks, size=size, speed=speed, turn=turn)
    simulator = required_simulator("a prediction needs")
    predictor = Predictor(simulator=simulator, motors=motors or MOTORS[0], drives=drives, workers=cores())
    scene = world_of(target, map).scene()
    _, prediction = planned_runs(predictor, scene, model, route, count=1, seed=0, best=best or "safe")
    return cast("Prediction", prediction)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Picture:
    """The picture that the shell can ask for."""

    output: Annotated[PictureName, Shell(help="draw the way and all drives on the plan; its ending is the format")] = (
        None
    )
    force: Force = False


def add_predict(command: Parser) -> None:
    """Add the flags of `rsegen predict`."""
    command.explain(predict.__doc__, "docs/certainty.md says how often it is right.", robot_kinds)
    add_input(command, "a world made by rsegen, its folder, or a recipe", name="target", metavar=WORLD)
    add_flags(command.group("prediction"), predict)
    add_flags(command.group("output"), _Picture)
    add_target_recipe_flags(command)


def run_predict(arguments: argparse.Namespace) -> Report:
    """Predict, and draw."""
    from rsegen.driving.plots import prediction_plot
    from rsegen.robots.lookup import robot_of
    from rsegen.writing.target_worlds import world_of

    picture = picture_of(arguments.output, force=arguments.force)
    with flags_in_errors(predict):
        scene = world_of(target_of(arguments), arguments.map).scene()
    prediction = call(predict, arguments, scene, map=None)
    kind = given(predict, arguments).get("robot", default(predict, "robot"))
    content = {"map": scene.name, "robot": kind, **prediction.as_json()}
    robot = robot_of(kind)
    if picture:
        picture.write(partial(prediction_plot, scene, robot.kind, prediction))
    remarks = (f"note: {robot.kind}: {remark}" for remark in getattr(robot, "remarks", ()))
    notes = (*which_map(arguments.target, arguments.map), *remarks)
    return Report(lines=[f"{scene.name}, {robot.kind}: {prediction}"], content=content, notes=notes)


def add_drive(command: Parser) -> None:
    """Add the flags of `rsegen drive`."""
    epilog = (
        "The burger, the default robot, cannot cross frames; the crawler can. --boundary none makes maps without them. "
        "rsegen sim lists the installed simulators. With --obstacle alone, --seed is also the seed of the map."
    )
    command.explain(drive.__doc__, epilog, robot_kinds)
    add_input(command, "a world made by rsegen, its folder, or a recipe", name="target", metavar=WORLD)
    add_flags(command.group("drive"), drive)
    add_target_recipe_flags(command, ("seed", *OWN_FLAGS))


def run_drive(arguments: argparse.Namespace) -> Report:
    """Drive, and report the metrics."""
    with flags_in_errors(drive):
        target = target_of(arguments, OWN_FLAGS if arguments.target is None else ("seed", *OWN_FLAGS))
    given_values = checked_flags(drive, arguments)
    with seconds_bar(given_values.get("duration", default(drive, "duration"))) as progress:
        result = call(drive, arguments, target, progress=progress)
    played = []
    if "output" in given_values:
        folder = Path(given_values["output"])
        played = [f"in {folder}: {', '.join([*result.pictures, 'trajectories, contacts and metrics'])}"]
        played += [f"to see it drive: rsegen gui {shlex.quote(str(folder))}"]
    notes = which_map(arguments.target, arguments.map)
    return Report(lines=chain(result.report(), played), content=result.as_json, notes=notes)


def add_drives(command: Parser) -> None:
    """Add the flags of `rsegen drives`."""
    epilog = "rsegen drive RECIPE --map INDEX drives one of them again, to look at it."
    command.explain(drive_many.__doc__, epilog, robot_kinds)
    add_input(command)
    add_flags(command.group("drive"), drive_many)
    add_recipe_flags(command, without=OWN_FLAGS)


def run_drives(arguments: argparse.Namespace) -> Report:
    """Drive over all maps, and report how many were crossed."""
    from rsegen.simulators.batch import batch_simulator
    from rsegen.writing.execute import cores

    with flags_in_errors(drive_many):
        recipe = recipe_from(arguments, OWN_FLAGS)
        options = given(drive_many, arguments)
        if batch_simulator(options.get("simulator")) is None:
            options = {"workers": cores()} | options
    with progress_shown(recipe.maps, "drive", miniters=1) as bar, flags_in_errors(drive_many):
        result = drive_many(recipe, progress=bar.update, **options)
    return Report(lines=result.report(), content=result.as_json)
