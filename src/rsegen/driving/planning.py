"""Ways that are driven: planned by poses, tried in the embedded simulator, and planned anew around what held the robot.

    Planner --way--> drive --held at a place--> close that place --way--> drive --crossed--> spread of drives --> way

Poses find ways in a second, but know neither swing, nor slip, nor what a robot does after it has fallen. So a way is
driven with the errors of a spread (prediction.py). Once two drives have failed, its moves about the places at which
they failed are closed, and the next way is planned. One that is sure is taken, or else the best of those that were
tried. Of several ways that are crossed by chance some cross in all of their first drives: so a later way is sure only
by all drives of a spread. If poses find no way, the straight lanes are tried on which the robot gets farthest.

Cost: up to eight tries of one to three seconds. What breaks it: a map whose ways all lead through one place that is
crossed by chance.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from rsegen.driving.prediction import LEAVES, DriveEnd, Prediction, Predictor
from rsegen.driving.recording import RobotRun
from rsegen.driving.robot_runs import robot_runs, runs_along
from rsegen.driving.routes import AlongWay, PlannedWay, Straight, followed
from rsegen.errors import NoSimulator, SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.params.watch import report_share
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import EmbeddedSimulator, embedded_simulator
from rsegen.standing.lanes import straight
from rsegen.standing.lattice import BEST, Lattice
from rsegen.standing.planner import Planner
from rsegen.standing.ways import Way, no_way
from rsegen.writing.execute import cores

SURE = 0.9
"""Probability from which on a way is taken at once."""

_FAILURES = 2
"""Drives that fail, after which a way is left for the next one."""

_TRIES, _LANES = 8, 4
"""Ways that are tried, and straight lanes if poses find no way: some ten seconds."""


def predict_way(predictor: Predictor, scene: Scene, robot: DrivableRobot, best: str) -> Prediction:
    """Return how surely a robot gets from west to east, on the surest of the ways that were tried.

    best: of which sort ways are, one of rsegen.standing.lattice.BEST. SimulatorFailed if no drive has a result.
    """
    tried: list[tuple[Prediction, RobotRun]] = []
    failure: SimulatorFailed | None = None
    planner = Planner(Lattice(scene.field, robot.body, best, partial(report_share, "a way across")))
    for way in _ways(planner, scene, robot):
        (run,) = runs_along(scene.field, robot, way)
        surest = max((one.probability for one, _ in tried), default=0.0)
        try:
            found = predictor.tried(scene, run, predictor.failures_below(surest, _FAILURES))
            if tried and found.probability >= SURE:  # of some ways one does well by chance
                found = predictor.predict(scene, run, found, is_chosen=True)
        except SimulatorFailed as error:
            failure = error
            continue
        tried.append((found, run))
        if found.probability >= SURE:
            break
        for end in found.ends:
            _close(planner, way, end)
    if not tried:
        raise failure or SimulatorFailed("no way could be driven")
    found, run = max(tried, key=lambda one: one[0].probability)
    return predictor.predict(scene, run, found)


def _ways(planner: Planner, scene: Scene, robot: DrivableRobot) -> Iterator[PlannedWay]:
    """Yield ways to try, each planned once it is asked for; without any, the straight lanes that get farthest."""
    field, body, count = scene.field, robot.body, 0
    while count < _TRIES and (way := planner.way(0, checked=False)) is not None:  # drives check it
        count += 1
        yield followed(field, body, way)
    report_share("a way across", 1)
    if not count:
        lanes = straight(field, body, 0)
        for number in np.argsort(-lanes.last, kind="stable")[:_LANES]:
            yield followed(field, body, no_way(lanes, body, int(number)))


def _close(planner: Planner, way: Way, end: DriveEnd) -> None:
    """Close the moves of a way about the place at which a robot stayed."""
    begins, ends = way.points[:-1], way.points[1:]
    along = ends - begins
    share = ((np.array([end.x, end.y]) - begins) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
    nearest = begins + np.clip(share, 0, 1)[:, None] * along
    number = int(np.hypot(*(nearest - (end.x, end.y)).T).argmin())
    heading = round(float(np.arctan2(along[number, 1], along[number, 0])) / (np.pi / 4)) % 8
    x, y = nearest[number].tolist()
    planner.close(x, y, heading)


def required_simulator(purpose: str) -> EmbeddedSimulator:
    """Return the simulator in the box; NoSimulator, after a purpose such as "many drives need", if there is none."""
    here = embedded_simulator(None)
    if here is None or here.version() is None:
        hint = "; ".join(here.how_to_install) if here else "this rsegen has no embedded simulator"
        raise NoSimulator(f"{purpose} MuJoCo; to install it: {hint}")
    return here


def predictor_for(backend: str | None, motors: str | None = None, workers: int = 1) -> Predictor | None:
    """Return what predicts drives in a simulator; None without a simulator in the box.

    Motors are those that are given, else as in the simulator: those of Gazebo Classic do not act back on the chassis.
    """
    simulator = embedded_simulator(None)
    if simulator is None or simulator.version() is None:
        return None
    real, classic = MOTORS
    motors = motors or (classic if backend == "classic" else real)
    return Predictor(simulator=simulator, motors=motors, workers=workers)


def planned_runs(  # noqa: PLR0913  # as robot_runs
    predictor: Predictor | None,
    scene: Scene,
    robot: DrivableRobot,
    route: str,
    *,
    count: int,
    seed: int,
    best: str,
) -> tuple[Sequence[RobotRun], Prediction | None]:
    """Return the runs of robots on a route, and how surely one gets across; None on a random route, or of several.

    Without a predictor ways are those of poses alone.
    """
    if predictor is None or route not in (AlongWay.name, Straight.name) or (route == Straight.name and count > 1):
        return robot_runs(scene.field, robot, route, count=count, seed=seed, best=best), None
    if route == AlongWay.name:
        found = predict_way(predictor, scene, robot, best)
        return runs_along(scene.field, robot, cast("PlannedWay", found.way), count), found
    runs = robot_runs(scene.field, robot, route, count=count, seed=seed)
    return runs, predictor.predict(scene, runs[0])


def predictions(robot: object, scene: Scene) -> Mapping[str, Prediction]:
    """Return how surely a robot gets across a map, by the names of sides; nothing without a simulator in the box.

    (`Capability.predictor`)
    """
    predictor = predictor_for(None, workers=cores())
    if predictor is None or not isinstance(robot, DrivableRobot):
        return {}
    found = {}
    for side, turned in {"west_east": scene, "south_north": northward(scene)}.items():
        with suppress(SimulatorFailed):
            found[side] = predict_way(predictor, turned, robot, BEST[0])
    if "south_north" in found:
        found["south_north"] = _turned_back(found["south_north"])
    return found


def northward(scene: Scene) -> Scene:
    """Return a scene turned by 90 degrees clockwise, so that what was north is east."""
    field = scene.field
    turned = replace(field, levels=field.levels[::-1].T.copy(), frame=field.frame[::-1].T.copy())
    return replace(scene, field=turned)


_SIDES = {
    f"{LEAVES} {turned} of it": f"{LEAVES} {side} of it"
    for turned, side in {"north": "west", "south": "east", "east": "north", "west": "south"}.items()
}
"""The reason of an end in a scene that was turned, and in the scene."""


def _turned_back(found: Prediction) -> Prediction:
    """Return a prediction about a scene that was turned by `northward`, with places of the scene."""
    outcomes = tuple(
        replace(one, path=_back(one.path), reason=_SIDES.get(one.reason, one.reason)) for one in found.outcomes
    )
    return replace(found, outcomes=outcomes, way=found.way and _way_back(found.way))


def _way_back(way: PlannedWay) -> PlannedWay:
    """Return a way of a scene that was turned by `northward` in the scene, with the places that it names."""

    def places(known: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        return tuple((x, y) for x, y in _back(np.reshape(known, (-1, 2))).tolist())

    at, margin_at = (known and places((known,))[0] for known in (way.at, way.margin_at))
    drops, slips = places(way.drops), places(way.slips)
    return replace(way, points=_back(way.points), drops=drops, slips=slips, at=at, margin_at=margin_at)


def _back(points: Array) -> Array:
    """Return points (n, 2) of a scene that was turned by `northward` in the scene."""
    return points[:, ::-1] * (-1.0, 1.0)
