"""The window's door to robots and simulators; no other module of the window calls `rsegen.simulation`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rsegen.commands.drive import drive
from rsegen.commands.experiment import experiment
from rsegen.commands.generate import generate
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, StepField
from rsegen.gui.model.reach import Reach, RobotPart, RobotShape, Way
from rsegen.recipe.recipe import Recipe
from rsegen.robots import ROBOTS
from rsegen.robots.links import Box, Cylinder, SdfPose, Solid, rotation
from rsegen.simulation.driving.robot_runs import ROUTES, spot_generator, spots_on_map
from rsegen.simulation.driving.routes import followed
from rsegen.simulation.experiment.plan import PLANS, load_plan
from rsegen.simulation.simulators import SIMULATORS, Installation, LaunchCommand, OpenRequest
from rsegen.simulation.simulators.connecting import connected
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.simulators.patience import SECONDS
from rsegen.simulation.spawning.spawning import SpawnedMap, at_free_place, map_model, spawn_map
from rsegen.standing.body import Body
from rsegen.standing.spots import Outline, Spot
from rsegen.standing.ways import Reach as Places
from rsegen.standing.ways import reach as reached

__all__ = [
    "Installed",
    "LaunchCommand",
    "PlanSummary",
    "SpawnedMap",
    "Spawning",
    "drive_map",
    "experiment_plans",
    "how_to_install",
    "installed",
    "launch_of",
    "plan_summary",
    "reach",
    "robot_names",
    "robot_shape",
    "route_names",
    "run_experiment",
    "simulator_titles",
    "spawn",
    "why_it_cannot_open",
]

Installed = Mapping[str, Installation | None]
"""The installation of every simulator by its name; None if it is not installed."""

_ORIGIN = Pose(x=0, y=0, z=0)


def robot_names() -> list[str]:
    """The names of all robots."""
    return list(ROBOTS)


def robot_shape(name: str) -> RobotShape:
    """The shape of a robot, its joints at rest."""
    robot = ROBOTS[name]
    parts = (
        RobotPart(_sizes(part.solid), _transform(link.pose) @ _transform(part.pose), part.colour)
        for link in robot.links
        for part in link.parts
    )
    return RobotShape(tuple(parts), robot.size)


def _sizes(solid: Solid) -> tuple[float, ...]:
    if isinstance(solid, Box):
        return tuple(solid.size)
    return (solid.radius, solid.length) if isinstance(solid, Cylinder) else (solid.radius,)


def _transform(pose: SdfPose) -> Array:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation(*pose[3:]), pose[:3]
    return found


def reach(field: StepField, name: str, seed: int) -> Reach:
    """What a robot can do on a field; its spots are a seed's."""
    body = ROBOTS[name].body
    found = reached(field, body)
    crossings = {"west to east": found.west_east, "south to north": found.south_north}
    across = [way for way, crossing in crossings.items() if crossing.crosses]
    return Reach(
        text=f"crosses {' and '.join(across)}"
        if across
        else f"does not cross; largest area {found.cover:.0%} of the map",
        region=found.region,
        ways=_ways(field, body, found),
        spots=_spots(field, body, seed),
        outline=Outline.of(body),
    )


def _ways(field: StepField, body: Body, found: Places) -> tuple[Way, ...]:
    """The ways across; if there is none, the one that `drive --route way` tries."""
    ways = tuple(
        Way(crossing.points, is_eastward)
        for crossing, is_eastward in ((found.west_east, True), (found.south_north, False))
        if crossing.crosses
    )
    return ways or (Way(followed(field, body, found.west_east).points, is_eastward=True, is_too_steep=True),)


def _spots(field: StepField, body: Body, seed: int) -> tuple[Spot, ...]:
    try:
        return spots_on_map(field, body, 2, spot_generator(seed))
    except ParameterError:  # there are none
        return ()


def route_names() -> tuple[str, ...]:
    """The names of the routes that robots drive."""
    return ROUTES


def drive_map(recipe: Recipe, **options: Any) -> list[str]:
    """Drive over the first map of a recipe, with the options of `rsegen.drive`; gives the lines of its report."""
    return list(drive(recipe, **options).report())


class PlanSummary(NamedTuple):
    """A plan of an experiment: its name, how many trials it has, and the seconds that each measures."""

    name: str
    trials: int
    seconds: float


def experiment_plans() -> dict[str, str]:
    """What each included plan measures, by its name: the comment at the head of its file."""
    return {name: file.read_text("utf-8").splitlines()[0].lstrip("# ") for name, file in sorted(PLANS.items())}


def plan_summary(plan: str, simulators: tuple[str, ...]) -> PlanSummary:
    """An included plan, or one in a YAML file, in these simulators; a UserError if there is none, or it is wrong."""
    found = load_plan(plan)
    found = found.in_simulators(simulators) if simulators else found
    return PlanSummary(found.name, len(found.cells) * found.repeats, found.seconds)


def run_experiment(
    plan: str,
    folder: Path,
    simulators: tuple[str, ...],
    *,
    force: bool,
    progress: Callable[[int], None],
    watch: Callable[[], None],
) -> None:
    """Run the missing trials of a plan; `progress` is called with the number of trials that are done."""
    chosen = simulators or None
    experiment(plan, folder, simulator=chosen, force=force, progress=lambda done, _: progress(done), watch=watch)


def simulator_titles() -> dict[str, str]:
    """The title of every simulator by its name, the newest first."""
    return {name: simulator.title for name, simulator in SIMULATORS.items()}


def installed() -> Installed:
    """Return the installed simulators; this runs their programs, so it takes a moment."""
    return {name: simulator.installation() for name, simulator in SIMULATORS.items()}


def how_to_install(name: str) -> str:
    """The lines that say how a simulator is installed."""
    return "\n".join(SIMULATORS[name].how_to_install)


def why_it_cannot_open(here: Installation | None) -> str:
    """Return why a simulator cannot open maps in its window; empty if it can."""
    if here is None:
        return "not found on this machine"
    can_open = here.simulator.with_gui(here, OpenRequest(world=Path("any.world")))
    return "" if can_open else "installed without its window"


def launch_of(here: Installation, recipe: Recipe, folder: Path) -> tuple[LaunchCommand, Path]:
    """Write the world of a recipe's one map into a folder; gives the command that opens it, and the world file."""
    world = generate(recipe, folder, force=True).maps[0].world
    launch = here.simulator.with_gui(here, OpenRequest(world=world, shared=True))
    if launch is None:
        raise RuntimeError(f"{here} was offered, though it is installed without its window")
    return launch, world


class Spawning(NamedTuple):
    """A map that was spawned, and the name of the one that it replaced, if any."""

    spawned: SpawnedMap
    replaced: str


def spawn(recipe: Recipe, folder: Path, number: int, before: SpawnedMap | None) -> Spawning:
    """Spawn the one map of a recipe in the running simulation: in place of the map spawned before if that is still
    there, else at the free place nearest to the origin.
    """
    one = map_model(recipe, recipe.first_map, folder)
    with connected(None, SECONDS) as (_, live):
        one.check_spawnable()
        poses = live.poses()
        old = replace(before, at=poses[before.name]) if before and before.name in poses else None
        new = SpawnedMap(name=f"{one.name}-{number}", field=one.field, at=old.at if old else _ORIGIN)
        new = new if old else at_free_place(new, poses, [])
        spawn_map(live, one.sdf(new.name), new, old)
    return Spawning(new, old.name if old else "")
