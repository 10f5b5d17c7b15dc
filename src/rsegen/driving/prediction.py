"""Prediction of a crossing: its probability, as the share of a spread of drives, and where and why others end.

    scene, run --spread_run, drive--> outcomes, batch by batch --> Prediction: probability, interval, most likely end

A drive has no certain outcome: by half a millimetre to the side some end otherwise. So the same drive is done several
times in the embedded simulator, each time with other errors (spread.py), until the outcome is plain: a few drives that
all end alike, or up to `drives` of them. From k of n that cross, and the Jeffreys-like prior Beta(a, a) for which most
drives are nearly certain, follows the probability

    p = (k + a) / (n + 2 a)

A drive ends as soon as it is decided: the robot is across, has tipped over, or has neither come on nor turned for some
seconds. One that turns on the spot may get free: casters that stand behind an edge come over it aslant.

Cost: a drive simulates some 20 seconds per second, so an answer on 10 x 10 blocks takes one to eight seconds. What
breaks it: what the simulator does not know, and errors that are not in the spread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import hypot, inf, radians
from typing import NamedTuple

import numpy as np

from rsegen.driving.drive_metrics import SLOW, TIPPED, Course, Incident, drive_metrics
from rsegen.driving.recording import PERIOD, RobotRun, drive_in_steps, trajectories
from rsegen.driving.robot_runs import finish_x
from rsegen.driving.routes import Motion, PlannedWay, Route
from rsegen.driving.spread import FIRST, MOST, spread_run
from rsegen.errors import SimulatorFailed
from rsegen.field.stepfield import Array
from rsegen.params.command import Reported
from rsegen.params.watch import report_share
from rsegen.robots.files.sdf_elements import part_name
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import EmbeddedSimulator
from rsegen.simulators.poses import Pose, wrapped
from rsegen.writing.execute import Execution, execute

PRIOR = 0.25
"""Weight a of the prior Beta(a, a): of fresh lanes, most cross always or never (benchmarks/certainty)."""

LEAVES = "leaves the map,"
"""The reason of a drive that ends next to the map, before its side."""

_HELD = {"reaction": 3.0, "classic": 6.0}
"""Seconds in which a robot that does not come on is held for good, by its motors: flippers swing in two. Wheels whose
motors do not act back spin at an edge, and some of TurtleBot3's come over it after four to ten seconds."""

_WITHIN, _TURNED = 0.01, radians(2.5)
"""Metres by which a held robot comes on in that time at most, and radians by which it turns. A robot that comes on by
more than SLOW of its speed is not held either. Held robots come on by a millimetre; small wheels creep over edges by a
centimetre or two, and half of them get free."""

_TOGETHER = 7
"""Drives that are done together: half of the 14 drives of a spread after the first six."""

DRIVE_SECONDS = 0.5
"""CPU seconds that a drive takes, about."""

_BAR = "drives"
"""Label of the progress bar."""

_SEEN = 0.25
"""Seconds between the places in the path of an outcome."""

_LONG, _MORE = 3.0, 15.0
"""Times the length of its way at full speed, and seconds more, after which a robot has not crossed."""


def _probability(crossed: int, drives: int) -> float:
    """Return the probability of crossing if `crossed` of `drives` drives cross."""
    return (crossed + PRIOR) / (drives + 2 * PRIOR)


def _middle(places: Sequence[Array]) -> tuple[float, float]:
    """Return the place with the least sum of distances to the others; their mean may be one at which no drive ended."""
    every = np.array(places)
    x, y = every[np.linalg.norm(every[:, None] - every, axis=-1).sum(axis=1).argmin()].tolist()
    return x, y


class DriveEnd(NamedTuple):
    """An end of drives that do not cross: the reason, in words after "the robot", a place, and their number.

    x, y: where the drive in their middle ended, metres
    """

    reason: str
    x: float
    y: float
    drives: int

    def __str__(self) -> str:
        return f"{self.reason} at {self.x + 0:.2f}, {self.y + 0:.2f} m"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Outcome:
    """Outcome of one drive of a prediction.

    Attributes
    ----------
    seconds : float or None
        Until the robot was across; None if it did not cross.
    path : ndarray, shape (n, 2)
        Where its origin was, metres, from the start to the end.
    reason : str
        Why it did not cross, in words that follow "the robot"; empty if it did.
    """

    seconds: float | None
    path: Array
    reason: str = ""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Prediction(Reported):
    """Prediction of whether a robot gets across, with its probability.

    Attributes
    ----------
    outcomes : tuple of Outcome
        The drives of the spread.
    simulator, motors : str
        Where and with which model of motors they were simulated.
    way : PlannedWay or None
        The way that the robot followed; None for a straight drive.
    next_drive : int
        The number of the first drive that was not done.
    """

    outcomes: tuple[Outcome, ...]
    simulator: str
    motors: str
    way: PlannedWay | None = None
    next_drive: int = 0

    @property
    def drives(self) -> int:
        """The number of drives."""
        return len(self.outcomes)

    @property
    def crossed(self) -> int:
        """Number of drives that crossed."""
        return sum(outcome.seconds is not None for outcome in self.outcomes)

    @property
    def failed(self) -> int:
        """The number of drives that did not cross."""
        return self.drives - self.crossed

    @property
    def probability(self) -> float:
        """Probability of crossing, 0..1."""
        return _probability(self.crossed, self.drives)

    @property
    def seconds(self) -> float | None:
        """Median time of crossing; None if no drive crossed."""
        times = [outcome.seconds for outcome in self.outcomes if outcome.seconds is not None]
        return float(np.median(times)) if times else None

    @property
    def ends(self) -> tuple[DriveEnd, ...]:
        """The ends of drives that did not cross, by their reason, the most frequent first."""
        by_reason: dict[str, list[Array]] = {}
        for outcome in self.outcomes:
            if outcome.reason:
                by_reason.setdefault(outcome.reason, []).append(outcome.path[-1])
        ends = (DriveEnd(reason, *_middle(places), len(places)) for reason, places in by_reason.items())
        return tuple(sorted(ends, key=lambda end: -end.drives))

    def report(self) -> Iterator[str]:
        """Yield the probability, and where the robot mostly ends, in one line."""
        counts = f"{self.crossed} of {self.drives} drives in {self.simulator}, {self.motors} motors"
        if self.crossed in (0, self.drives):  # the probability is an estimate of theirs, by a prior
            counts += f"; so few cannot prove {self.crossed / self.drives:.2f}"
        subject = "otherwise it mostly" if self.crossed else "it mostly"
        end = f"; {subject} {self.ends[0]}" if self.ends else ""
        yield f"crosses with probability {self.probability:.2f} ({counts}){end}"

    def as_json(self) -> dict[str, object]:
        """Return the prediction for JSON."""
        names = ("crossed", "drives", "simulator", "motors", "seconds")
        return {
            "probability": round(self.probability, 4),
            **{name: getattr(self, name) for name in names},
            "ends": [end._asdict() for end in self.ends],
            **({"way": self.way.as_json()} if self.way else {}),
        }


@dataclass(frozen=True, kw_only=True, slots=True)
class Predictor:
    """A predictor of crossings, by drives in the embedded simulator.

    motors: the model of motors; drives: how many decide at most
    workers: processes for the drives that follow if the first ones do not all end alike
    """

    simulator: EmbeddedSimulator
    motors: str = MOTORS[0]
    drives: int = MOST
    workers: int = 1

    def tried(self, scene: Scene, run: RobotRun, failures: float = inf, known: Prediction | None = None) -> Prediction:
        """Return the prediction from the first drives, until `failures` do not cross; SimulatorFailed without a result.

        known: the prediction from some of them, which are not done again
        """
        outcomes, next_drive = (list(known.outcomes), known.next_drive) if known else ([], 0)
        while next_drive < min(FIRST, self.drives):
            outcomes += self._outcomes(scene, run, [next_drive])
            next_drive += 1
            report_share(_BAR, next_drive / self.drives)
            if sum(outcome.seconds is None for outcome in outcomes) >= failures:
                break
        return self._prediction(outcomes, run, next_drive)

    def predict(
        self,
        scene: Scene,
        run: RobotRun,
        known: Prediction | None = None,
        *,
        failures: float = inf,
        is_chosen: bool = False,
    ) -> Prediction:
        """Return whether a robot crosses on its run; SimulatorFailed if no drive has a result.

        known: the prediction from drives already done
        failures: end after about as many drives that do not cross
        is_chosen: do all drives even if the first ones all cross, as the run was chosen from several
        """
        # The first drives decide alone if they all end alike.
        prediction, work = self.tried(scene, run, failures, known), partial(self._outcomes, scene, run)
        is_enough = not prediction.crossed or (not prediction.failed and not is_chosen)
        together = self.drives if failures == inf else _TOGETHER  # for any number of workers
        while prediction.next_drive < self.drives and prediction.failed < failures and not is_enough:
            drives = range(prediction.next_drive, min(prediction.next_drive + together, self.drives))
            outcomes = list(prediction.outcomes)
            for batch in execute(work, drives, DRIVE_SECONDS, Execution(workers=self.workers)):
                outcomes += batch
                report_share(_BAR, len(outcomes) / self.drives)
            prediction = self._prediction(outcomes, run, drives.stop)
        report_share(_BAR, 1)
        return prediction

    def _outcomes(self, scene: Scene, run: RobotRun, numbers: Sequence[int]) -> list[Outcome]:
        """Return the outcomes of drives; one whose physics fails counts neither way."""
        outcomes = []
        for drive in numbers:
            with suppress(SimulatorFailed):
                outcomes.append(spread_drive(self.simulator, scene, run, drive, self.motors))
        return outcomes

    def _prediction(self, outcomes: Sequence[Outcome], run: RobotRun, next_drive: int) -> Prediction:
        if not outcomes:
            raise SimulatorFailed(f"{self.simulator}: none of {next_drive} drives has a result, as its physics failed")
        return Prediction(
            outcomes=tuple(outcomes),
            simulator=str(self.simulator),
            motors=self.motors,
            way=run.way,
            next_drive=next_drive,
        )


def spread_drive(
    simulator: EmbeddedSimulator, scene: Scene, run: RobotRun, number: int, motors: str, *, is_whole: bool = False
) -> Outcome:
    """Return the outcome of the drive of a number out of the spread of a run.

    is_whole: True to drive on to the time limit where the robot is held
    """
    erring, built = spread_run(scene, run, number)
    decided = erring if is_whole else until_decided(erring, motors)
    world = simulator.world(scene, [decided], motors=motors, period=PERIOD, built=built)
    drive_in_steps(world, [decided], _time_limit(scene, run), world.step_seconds, contacts=False)
    trajectory = trajectories(world.recorded(), [decided])[run.name]
    course = Course.over(scene.field, finish_x(scene.field, run.robot))
    metrics = drive_metrics(trajectory, run.robot.driving_speed, run.robot.size, course)
    path = trajectory.rows[:: round(_SEEN / PERIOD), 1:3]
    path = np.append(path, trajectory.rows[-1:, 1:3], axis=0)
    # The reason is the first of these that is known; without one, the part in contact while the robot was held.
    if metrics.crossed is not None:
        return Outcome(seconds=metrics.crossed, path=path)
    if metrics.tipped:
        return Outcome(seconds=None, path=path, reason="tips over")
    if off := next((incident for incident in metrics.incidents if incident.kind == Incident.OFF), None):
        return Outcome(seconds=None, path=path, reason=f"{LEAVES} {off.reason}")
    part = world.held_by(run.name)
    return Outcome(
        seconds=None, path=path, reason=f"gets stuck on its {part_name(part)}" if part else "makes no progress"
    )


def until_decided(run: RobotRun, motors: str) -> RobotRun:
    """Return a run that ends as soon as it is decided whether its robot crosses."""
    held = _HELD[motors]
    within = min(_WITHIN, SLOW * held * run.robot.driving_speed)
    return replace(run, route=lambda: _UntilDecided(route=run.route(), held=held, within=within))


def _time_limit(scene: Scene, run: RobotRun) -> float:
    """Return the simulated seconds after which a robot that has not crossed does not cross."""
    length = scene.field.extent[0] / 2 - run.start.x if run.way is None or run.way.length is None else run.way.length
    return _MORE + _LONG * length / run.robot.driving_speed


@dataclass(kw_only=True, slots=True)
class _UntilDecided(Route):
    """A route that ends, besides at its goal, where its robot has tipped over, or has been held for `held` seconds.

    within: metres by which a held robot comes on in that time at most
    """

    route: Route
    held: float
    within: float
    poses: deque[Pose] | None = None

    @property
    def period(self) -> float:  # type: ignore[override]  # not of the class, as its route has it
        return self.route.period

    def motion(self, at: Pose) -> Motion:
        return self.route.motion(at)

    def is_done(self, at: Pose) -> bool:
        if self.poses is None:
            self.poses = deque(maxlen=round(self.held / self.period) + 1)
        self.poses.append(at)
        first, is_full = self.poses[0], len(self.poses) == self.poses.maxlen
        is_held = is_full and all(
            hypot(pose.x - first.x, pose.y - first.y) < self.within and abs(wrapped(pose.yaw - first.yaw)) < _TURNED
            for pose in self.poses
        )
        has_tipped = np.cos(at.roll) * np.cos(at.pitch) < np.cos(TIPPED)
        return is_held or bool(has_tipped) or self.route.is_done(at)
