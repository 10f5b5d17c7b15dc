"""Ways that robots drive: planned by poses, tried in the embedded simulator, and planned anew from these drives.

    Planner --way--> drives --held at a place--> evidence --way--> drives --crossed--> spread of drives --> way
       ^                                            |
       +---- where robots got on, and were held ----+

Poses find ways in a second, but show neither swing, nor slip, nor what a robot does after it has fallen. So a way is
driven with the errors of a spread (prediction.py). Once a drive has failed, the next way is planned: it prefers moves
that drives passed to untried ones, and leads around places that held a robot (standing/evidence.py). It may be the same
way again; after two failed drives a way is given up. The first sure way is taken, or else the best way that was tried.
Of several ways that are crossed by chance, some are crossed in all of their first drives: so a later way is sure only
after all drives of a spread.

If the first way is not sure, straight lanes that poses drive to the end come next, before ways are planned anew: they
are easier to follow, and bends hold some robots by their casters. On 15 fresh fields, with both models of motors, a
maker's TurtleBot3 had a sure way in 15 of 30 cases in place of nine, for 20 s of CPU each as before. If poses find no
way at all, the lanes on which they get farthest are tried.

Cost: up to sixteen plans of a fifth of a second, and a drive or two for each; of ways that are crossed by chance some
sixty drives. What breaks it: a map whose ways all lead through one place that is crossed by chance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import cast

import numpy as np

from rsegen.driving.prediction import LEAVES, Outcome, Prediction, Predictor
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
from rsegen.standing.body import Body
from rsegen.standing.lanes import across, straight
from rsegen.standing.lattice import BEST, Lattice
from rsegen.standing.planner import Planner
from rsegen.standing.ways import Way, lane_way
from rsegen.writing.execute import cores

SURE = 0.9
"""Probability from which on a way is taken at once."""

_FAILURES = 2
"""Drives that fail, after which a way is given up."""

_PLANS, _LANES = 16, 4
"""Times that a way is planned, and straight lanes that are tried at most: some ten seconds, and up to forty of a robot
that crosses everything by chance."""


@dataclass(kw_only=True, slots=True)
class _Tried:
    """A way that is tried, with the prediction from its drives so far, and the error if none has a result."""

    run: RobotRun
    prediction: Prediction | None = None
    error: SimulatorFailed | None = None

    @property
    def failures(self) -> int:
        """The number of its drives that have failed."""
        return self.prediction.failed if self.prediction else 0

    @property
    def has_crossed(self) -> bool:
        """Return whether one of its drives has crossed."""
        return bool(self.prediction and self.prediction.crossed)

    @property
    def probability(self) -> float:
        """The probability of crossing as far as it is known; -1, below all others, without a drive."""
        return self.prediction.probability if self.prediction else -1.0

    def drive(self, predictor: Predictor, scene: Scene, failures: int, *, is_first: bool) -> Sequence[Outcome]:
        """Drive until that many drives have failed, or all of a prediction are done; return the new outcomes.

        is_first: whether this is the first way, for which few drives are enough; out of several ways, one may do well
        in few drives by chance
        """
        known = self.prediction
        try:
            self.prediction = predictor.tried(scene, self.run, failures, known)
        except SimulatorFailed as error:
            self.error = error
            return ()
        if self.failures < failures:
            chosen = not is_first
            self.prediction = predictor.predict(scene, self.run, self.prediction, failures=_FAILURES, is_chosen=chosen)
        return self.prediction.outcomes[known.drives if known else 0 :]

    def is_done(self, predictor: Predictor) -> bool:
        """Return whether it is given up, or all of its drives are done."""
        return self.failures >= _FAILURES or bool(self.prediction and self.prediction.next_drive >= predictor.drives)

    def close(self, planner: Planner) -> None:
        """Close the places that held its drives: the way is given up, but would else be planned again."""
        if self.prediction and self.run.way:
            for end in self.prediction.ends:
                planner.learn(self.run.way.points, (end.x, end.y), held=inf)


def predict_way(predictor: Predictor, scene: Scene, robot: DrivableRobot, best: str) -> Prediction:
    """Return how surely a robot gets from west to east, on the surest of the ways that were tried.

    best: criterion of the planned ways, one of rsegen.standing.lattice.BEST. SimulatorFailed if no drive has a result.
    """
    search = _Search(predictor, scene, robot)
    search.try_ways(robot.body, best)
    if not search.tried and predictor.motors != MOTORS[0]:  # motors that do not act back lift casters over more edges
        search.try_ways(replace(robot.body, reaction=False), best)
    if not search.tried:
        search.try_lanes(robot.body, passed=False)
    return search.surest()


class _Search:
    """A search for a way that a robot surely drives.

    tried: the ways and lanes that were tried, by the bytes of their points
    """

    def __init__(self, predictor: Predictor, scene: Scene, robot: DrivableRobot) -> None:
        self.predictor, self.scene, self.robot = predictor, scene, robot
        self.tried = dict[bytes, _Tried]()

    @property
    def is_sure(self) -> bool:
        """Return whether one of the ways is crossed surely enough."""
        return any(tried.probability >= SURE for tried in self.tried.values())

    def surest(self) -> Prediction:
        """Return the prediction of the surest way; SimulatorFailed if no drive has a result.

        Ways were given up after few drives. So the best one is driven on until it fails once more, and then the way
        that is best now, until all drives of the best one are done.
        """
        while True:
            best = max(self.tried.values(), key=lambda tried: (tried.has_crossed, tried.probability))
            if best.prediction is None:
                raise best.error or SimulatorFailed("no way could be driven")
            known, failures = best.prediction.next_drive, best.failures + 1 if best.has_crossed else inf
            best.prediction = self.predictor.predict(self.scene, best.run, best.prediction, failures=failures)
            if not best.has_crossed or best.prediction.next_drive == known:
                return best.prediction

    def try_ways(self, body: Body, best: str) -> None:
        """Try ways of a body, each planned from the drives before, and lanes, until one is sure."""
        planner = Planner(Lattice(self.scene.field, body, best, partial(report_share, "a way across")))
        for plan in range(_PLANS):
            way = planner.way(0, checked=False)  # drives check it
            if way is None:
                break
            tried = self._tried(way)
            # Planned again although no more drives of it are to be done: without a failure it stays the best way.
            if tried.is_done(self.predictor):
                if not tried.failures:
                    break
                tried.close(planner)
                continue
            for outcome in self._drive(tried, tried.failures + 1):
                x, y = outcome.path[-1].tolist()
                planner.learn(way.points, (x, y) if outcome.reason else None)
            if not plan and (tried.failures or tried.error):
                self.try_lanes(body, passed=True)
            if tried.error or self.is_sure:
                break
        report_share("a way across", 1)

    def try_lanes(self, body: Body, *, passed: bool) -> None:
        """Try the straight lanes on which poses get farthest, of equal ones the middle ones first, until one is sure.

        passed: True to try only lanes that poses drive to their ends
        """
        field = self.scene.field
        lanes, aside = straight(field, body, 0), np.abs(across(field, 0))
        order = np.lexsort([aside, -lanes.last])
        for lane in order[lanes.passed[order] | (not passed)][:_LANES].tolist():
            self._drive(self._tried(lane_way(lanes, lane, field, body)), _FAILURES)
            if self.is_sure:
                break

    def _tried(self, way: Way) -> _Tried:
        """Return the drives of a way: the known ones, or none so far."""
        scene, robot = self.scene, self.robot
        planned = followed(scene.field, robot.body, way)
        key = planned.points.tobytes()
        if key not in self.tried:
            (run,) = runs_along(scene.field, robot, planned)
            self.tried[key] = _Tried(run=run)
        return self.tried[key]

    def _drive(self, tried: _Tried, failures: int) -> Sequence[Outcome]:
        """Drive along a way until that many drives have failed; few drives are enough for the first way alone."""
        return tried.drive(self.predictor, self.scene, failures, is_first=len(self.tried) == 1)


def required_simulator(purpose: str) -> EmbeddedSimulator:
    """Return the embedded simulator; NoSimulator, which begins with a purpose like "many drives need", without one."""
    simulator = embedded_simulator(None)
    if simulator is None or simulator.version() is None:
        hint = "; ".join(simulator.how_to_install) if simulator else "this rsegen has no embedded simulator"
        raise NoSimulator(f"{purpose} MuJoCo; to install it: {hint}")
    return simulator


def predictor_for(backend: str | None, motors: str | None = None, workers: int = 1) -> Predictor | None:
    """Return the predictor of drives in a simulator; None if no embedded simulator is installed.

    motors: their model, by default as in that simulator: in Gazebo Classic motors do not act back on the chassis
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
    """Return the runs of robots on a route, and the prediction of a crossing; None on a random route, or for several.

    Without a predictor ways are planned by poses alone.
    """
    if predictor is None or route not in (AlongWay.name, Straight.name) or (route == Straight.name and count > 1):
        return robot_runs(scene.field, robot, route, count=count, seed=seed, best=best), None
    if route == AlongWay.name:
        prediction = predict_way(predictor, scene, robot, best)
        return runs_along(scene.field, robot, cast("PlannedWay", prediction.way), count), prediction
    runs = robot_runs(scene.field, robot, route, count=count, seed=seed)
    return runs, predictor.predict(scene, runs[0])


def predictions(robot: object, scene: Scene) -> Mapping[str, Prediction]:
    """Return how surely a robot gets across a map, by the names of sides; empty if no embedded simulator is installed.

    (`Capability.predictor`)
    """
    predictor = predictor_for(None, workers=cores())
    if predictor is None or not isinstance(robot, DrivableRobot):
        return {}
    # Drives lead from west to east: for south to north the map is turned, and the prediction is turned back.
    by_side = {}
    for side, turned in {"west_east": scene, "south_north": northward(scene)}.items():
        with suppress(SimulatorFailed):
            by_side[side] = predict_way(predictor, turned, robot, BEST[0])
    if "south_north" in by_side:
        by_side["south_north"] = _turned_back(by_side["south_north"])
    return by_side


def northward(scene: Scene) -> Scene:
    """Return a scene turned by 90 degrees clockwise, so that its north is east."""
    field = scene.field
    turned = replace(field, levels=field.levels[::-1].T.copy(), frame=field.frame[::-1].T.copy())
    return replace(scene, field=turned)


_SIDES = {
    f"{LEAVES} {turned} of it": f"{LEAVES} {side} of it"
    for turned, side in {"north": "west", "south": "east", "east": "north", "west": "south"}.items()
}
"""Reason of an end in a turned scene -> in the scene itself."""


def _turned_back(prediction: Prediction) -> Prediction:
    """Return a prediction for a scene, made for that scene turned by `northward`."""
    outcomes = tuple(
        replace(outcome, path=_back(outcome.path), reason=_SIDES.get(outcome.reason, outcome.reason))
        for outcome in prediction.outcomes
    )
    return replace(prediction, outcomes=outcomes, way=prediction.way and _way_back(prediction.way))


def _way_back(way: PlannedWay) -> PlannedWay:
    """Return a way in a scene, found in that scene turned by `northward`, with the places that it names."""

    def places(known: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        return tuple((x, y) for x, y in _back(np.reshape(known, (-1, 2))).tolist())

    at, margin_at = (known and places((known,))[0] for known in (way.at, way.margin_at))
    drops, slips = places(way.drops), places(way.slips)
    return replace(way, points=_back(way.points), drops=drops, slips=slips, at=at, margin_at=margin_at)


def _back(points: Array) -> Array:
    """Return points (n, 2) in a scene, found in that scene turned by `northward`."""
    return points[:, ::-1] * (-1.0, 1.0)
