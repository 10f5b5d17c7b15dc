"""Commands of simulators: `rsegen open`, `drive`, `spots`, `spawn`, `respawn`, `remove` and `experiment`."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import (
    AnyRobot,
    Force,
    MapReference,
    MapsFolder,
    ModelName,
    OutputFolder,
    Place,
    RobotModel,
    RunningSimulator,
    SimulatorName,
    Timeout,
)
from rsegen.errors import ParameterError
from rsegen.field.limits import SIDE, SPEED, TURN
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Choice, FilePath, Flag, Float, Integer, ListOf, Reference, parameters
from rsegen.params.streams import SEEDS
from rsegen.recipe.recipe import Run

if TYPE_CHECKING:
    from rsegen.robots import Robot, SdfRobot
    from rsegen.simulation.driving.drive import DriveResult
    from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
    from rsegen.simulation.experiment.run import ExperimentResult
    from rsegen.simulation.open_world import OpenedWorld, OpenResult
    from rsegen.simulation.spawning import RemoveResult, RespawnResult, SpawnResult
    from rsegen.simulation.worlds import Target
    from rsegen.standing.spots import Spot


@command
def open(  # noqa: A001, PLR0913  # the command's name; each is a flag of it
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    simulator: SimulatorName = None,
    headless: Annotated[bool, Flag(help="run only the server, without a window")] = False,
    seconds: Annotated[
        float | None,
        Float(0, 1e9, unit="s", help="end so long after the world has loaded"),
        Shell(metavar="N", default="never"),
    ] = None,
    shared: Annotated[bool, Flag(help="use the default address, so that other programs can connect")] = False,
    timeout: Timeout = 20.0,
    on_start: Callable[[OpenedWorld], None] | None = None,
    on_error: Callable[[str], None] | None = None,
) -> OpenResult:
    """Open a world in the newest installed Gazebo that supports it, and wait; Ctrl-C or closing the window ends it.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        A world file, the folder of a map or of maps, a recipe (a temporary world is made) or a scene.
    on_start : callable, optional
        Called once before the simulator runs.
    on_error : callable, optional
        Called with each of its error lines; of lines that differ in numbers alone with the first at once, and in the
        end with their count.

    Returns
    -------
    OpenResult
        The world, the exit code and the error lines.

    Raises
    ------
    SimulatorFailed
        If the simulator says that it did not load the world, if it has not for `timeout` seconds without progress when
        `seconds` are given, or if a server without a window ends by itself or prints errors.
    """
    from rsegen.simulation.open_world import open_until_end
    from rsegen.simulation.worlds import world_of

    return open_until_end(
        world_of(target, map),
        simulator,
        headless=headless,
        seconds=seconds,
        shared=shared,
        timeout=timeout,
        on_start=on_start or _ignore,
        on_error=on_error or _ignore,
    )


@command
def drive(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    wheels: Annotated[
        str | None,
        Reference("LEFT,RIGHT or FRONT+REAR,FRONT+REAR", help="joints of the wheels of a model in a file"),
        Shell(metavar="LEFT,RIGHT", default="of its drive plug-in, of ROS's controllers, or by their shapes"),
    ] = None,
    tracks: Annotated[
        str | None,
        Reference(
            "LEFT,RIGHT or TRACK+FLIPPER,TRACK+FLIPPER",
            help="links of the tracks of a model in a file, and of their flippers",
        ),
        Shell(metavar="LEFT,RIGHT", default="of its drive plug-in"),
    ] = None,
    size: Annotated[
        tuple[float, float, float] | None,
        ListOf(SIDE, 3, help="length, width and height of the robot in the file"),
        Shell(metavar="L,W,H", default="of its collision shapes"),
    ] = None,
    speed: Annotated[
        float | None,
        replace(SPEED, help="maximum speed of the robot in the file"),
        Shell(metavar="V", default="of its plug-in, controller or joints, else 0.2"),
    ] = None,
    turn: Annotated[
        float | None,
        replace(TURN, help="maximum turn rate of the robot in the file"),
        Shell(metavar="W", default="of its plug-in or controller, else 0.5"),
    ] = None,
    robots: Annotated[int, Integer(1, 100, help="number of robots"), Shell(metavar="N")] = 1,
    simulator: SimulatorName = None,
    route: Annotated[
        str,
        Choice(
            ("straight", "random", "way"),
            help="straight across the map, randomly on it, or across it on a way on which the robot's poses are good",
        ),
    ] = "straight",
    best: Annotated[
        str | None,
        Choice(
            ("length", "tilt", "margin"),
            help="for route way: the shortest way, that with the least tilt, or with the largest angle to tip over",
        ),
        Shell(default="length"),
    ] = None,
    duration: Annotated[float, Float(0.1, 1e5, unit="s", help="simulation time"), Shell(metavar="S")] = 30.0,
    seed: Annotated[
        int | None, Integer(0, SEEDS - 1, help="seed of start poses and routes"), Shell(default="drawn and printed")
    ] = None,
    output: Annotated[
        str | Path | None,
        FilePath(help="folder for trajectories, metrics and a picture"),
        Shell(("-o", "--output"), "DIR"),
    ] = None,
    contacts: Annotated[
        bool,
        Flag(help="record what the robots touch"),
        Shell(help="do not record contacts, which take Gazebo Sim 1.5 to 1.8 times the CPU time"),
    ] = True,
    picture: Annotated[
        bool, Flag(help="add gazebo.jpg to the folder, from a camera in Gazebo; needs a screen")
    ] = False,
    force: Force = False,
    timeout: Timeout = 20.0,
    progress: Callable[[float], None] | None = None,
) -> DriveResult:
    """Drive robots over a map in a Gazebo server without a window, and report how far each got.

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
        If a value is wrong or no Gazebo is installed.
    """
    from rsegen.params.streams import fresh_seed
    from rsegen.run.dry import foresee
    from rsegen.run.store import unchanged_if_stopped
    from rsegen.simulation.driving.drive import (
        DriveResult,
        drivable,
        drive_notes,
        driven_robot,
        file_names,
        refuse_output,
    )
    from rsegen.simulation.driving.recording import record_drive
    from rsegen.simulation.driving.robot_runs import robot_runs
    from rsegen.simulation.driving.routes import AlongWay
    from rsegen.simulation.simulators.server import choose_installation
    from rsegen.simulation.worlds import world_of

    # All that can be wrong is refused before a server is started, which takes seconds.
    if best is not None and route != AlongWay.name:
        raise ParameterError("best", f"is for route {AlongWay.name}, not for {route}")
    model = drivable(robot, wheels, tracks, size=size, speed=speed, turn=turn)
    seed = fresh_seed() if seed is None else seed
    refuse_output(None if output is None else Path(output), picture=picture, force=force)
    world = world_of(target, map)
    here, scene = choose_installation(world.made_for, simulator, timeout), world.scene()
    runs = robot_runs(scene.field, model, route, count=robots, seed=seed, best=best or "length")
    pictured = picture and "pictures" not in here.simulator.drives_without
    if output is not None:
        foresee(Path(output), file_names(runs, picture=pictured), is_whole=True)
    with unchanged_if_stopped(output), world.on_disk() as file:
        extent = scene.field.extent if pictured else None
        recording = record_drive(
            here, file, runs, duration, progress or _ignore, contacts=contacts, camera_extent=extent
        )
    result = DriveResult(
        scene=scene,
        simulator=str(here),
        route=route,
        seed=seed,
        robots=tuple(driven_robot(run, scene, recording, route) for run in runs),
        errors=tuple(recording.errors),
        notes=tuple(drive_notes(here, runs, recording, route, contacts=contacts, picture=picture)),
        contact_samples=recording.samples,
        way=runs[0].way,
        image=recording.image,
    )
    if output is not None:
        result.write(output, force=force)
    return result


@command
def spots(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    count: Annotated[int, Integer(1, 1000, help="number of spots"), Shell(metavar="N")] = 1,
    size: Annotated[
        tuple[float, float] | None,
        ListOf(SIDE, 2, help="length and width of a robot, in place of --robot"),
        Shell(metavar="L,W"),
    ] = None,
    max_tilt: Annotated[
        float, Float(0.1, 45, unit="degrees", help="largest tilt at which the robot rests"), Shell(metavar="DEG")
    ] = 3.0,
    seed: Annotated[
        int | None, Integer(0, SEEDS - 1, help="seed of the choice"), Shell(default="drawn and printed")
    ] = None,
) -> tuple[Spot, ...]:
    """Find spots on a map: a robot stands there level and firmly, on its wheels or tracks, and can drive away.

    At the spots of a seed `rsegen.drive` starts as many robots on a random route.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        As for `rsegen.drive`.

    Returns
    -------
    tuple of Spot
        The spots.

    Raises
    ------
    UserError
        If there are too few.
    """
    from math import radians

    from rsegen.params.streams import fresh_seed
    from rsegen.robots import robot_of
    from rsegen.simulation.driving.robot_runs import spot_generator, spots_on_map
    from rsegen.simulation.worlds import world_of
    from rsegen.standing.spots import body_of_size

    body = robot_of(robot).body_or_box if size is None else body_of_size(*size)
    rng = spot_generator(fresh_seed() if seed is None else seed)
    return spots_on_map(world_of(target, map).scene().field, body, count, rng, most_tilt=radians(max_tilt))


@command
def spawn(  # noqa: PLR0913  # each is a flag
    target: Target | Robot | SdfRobot,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    name: Annotated[
        str | None,
        replace(parameters(Run)["name"], help="name of the model"),
        Shell(metavar="NAME", default="the map's name, or the kind of robot"),
    ] = None,
    at: Annotated[
        Sequence[float] | None,
        Place(),
        Shell(
            metavar="X,Y[,Z[,YAW]]",
            default="for a robot a spot of a map that is there, else the free place nearest to the origin",
        ),
    ] = None,
    robot: Annotated[
        AnyRobot,
        Shell(help="put this robot on the map, which is spawned first if it is not there: its kind, or a file of it"),
    ] = None,
    pose: Annotated[
        Sequence[float] | None,
        ListOf(
            Float(-1e6, 1e6),
            3,
            help="where that robot is put down, at rest: x and y [m] from the map's middle, yaw [rad]",
        ),
        Shell(metavar="X,Y,YAW", default="a spot of the map"),
    ] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> SpawnResult:
    """Spawn a map, a robot, or a robot on a map in the running simulation, and give its name and pose there.

    With `robot` the name and the pose are its own; at a `pose` it is at rest as `rsegen.poses` has it, 5 mm higher.
    Gazebo Classic is looked for at GAZEBO_MASTER_URI, Gazebo Sim in GZ_PARTITION, or at their default addresses.

    Parameters
    ----------
    target : Recipe, Scene, str, path or robot
        The folder of a map or of maps, a recipe, a scene, a kind of robot, the file of one, or a robot.

    Returns
    -------
    SpawnResult
        Name and pose.

    Raises
    ------
    UserError
        If a value is wrong.
    NothingRuns
        If no simulation runs.
    """
    from rsegen.simulation.spawning import spawn_model

    return spawn_model(target, map, name, at, robot, pose, Path(output), simulator, timeout)


@command
def respawn(
    target: Target,
    *,
    map: Annotated[MapReference, Shell(metavar="INDEX", default="the next")] = None,  # noqa: A002  # the flag's name
    name: Annotated[ModelName, Shell(help="name of the model to replace, if several could be meant")] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> RespawnResult:
    """Replace the map of the running simulation by the next one of a recipe or folder, at the same pose.

    Robots and their programs go on; models on the map are put on top of the new blocks while the world is paused.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        The recipe of the current map, or the folder of its maps; after the last map of a folder comes the first.

    Returns
    -------
    RespawnResult
        Names and pose.

    Raises
    ------
    UserError
        If a value is wrong, or no map is there.
    NothingRuns
        If no simulation runs.
    """
    from rsegen.simulation.spawning import replace_map

    return replace_map(target, map, name, Path(output), simulator, timeout)


@command
def remove(*names: str, simulator: RunningSimulator = None, timeout: Timeout = 20.0) -> RemoveResult:
    """Delete maps, robots and other models from the running simulation; none of them if one does not exist.

    Parameters
    ----------
    *names : str
        Names of the models.

    Returns
    -------
    RemoveResult
        What was deleted.

    Raises
    ------
    UnknownName
        If one does not exist; the error lists the models.
    """
    from rsegen.simulation.spawning import remove_models

    return remove_models(names, simulator, timeout)


@command
def experiment(  # noqa: PLR0913  # each is a flag
    plan: str | os.PathLike[str] | ExperimentPlan,
    output: OutputFolder,
    *,
    simulator: Annotated[
        str | Sequence[str] | None,
        ListOf(
            Reference("sim or classic"),
            help="Gazebo Sim (sim), Gazebo Classic (classic), or both as sim,classic, which are compared",
        ),
        Shell(metavar="NAME[,NAME]", default="the newest that is installed"),
    ] = None,
    force: Force = False,
    timeout: Timeout = 20.0,
    progress: Callable[[int, Cell], None] | None = None,
    watch: Callable[[], None] | None = None,
) -> ExperimentResult:
    """Measure what maps cost a simulator while robots drive on them, and write tables and a plot into a folder.

    If the folder has outcomes of this plan, only the missing trials are run; `force` begins anew, and what is there
    stays until the new is complete. What `progress` and `watch` raise stops the experiment, and the same call continues
    it.

    Parameters
    ----------
    plan : str, path or ExperimentPlan
        The name of an included plan, a YAML file like these, or a plan.
    progress : callable, optional
        Called with the number of trials that are done, and the next cell.
    watch : callable, optional
        Called several times per second during a trial.

    Returns
    -------
    ExperimentResult
        Outcomes of every cell.

    Raises
    ------
    UserError
        Before the first trial, if the plan is wrong, a simulator is not installed, or the folder has other files of
        these names.
    """
    from rsegen.simulation.experiment.run import run_experiment

    return run_experiment(
        plan,
        Path(output),
        simulator,
        force=force,
        timeout=timeout,
        progress=progress or _ignore,
        watch=watch or _ignore,
    )


def _ignore(*_: object) -> None:
    """Ignore what a caller did not ask to be told."""
