"""A reliability test as in standards for robots: a number of repetitions, and how many of them may fail.

A robot that crosses with probability R fails in k of n independent repetitions with binomial probability. The test has
confidence C if a robot of the reliability R, or a worse one, passes with a probability of 1 - C at most, which
sets the number of failures allowed. The reliability that a test shows is the lower end of the one-sided interval of
Clopper and Pearson (Biometrika 26, 1934). What breaks it: repetitions that are not independent, as on one field.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from math import comb, exp, floor, lgamma, log
from pathlib import Path, PurePosixPath

from rsegen.driving.many import ManyDrives
from rsegen.params.command import Reported
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Float, Integer
from rsegen.recipe.codec import to_json
from rsegen.writing.store import write_folder

_SHARE, _REPETITIONS = Float(0, 1), Integer(1, 100_000)

_ROUNDING = 1e-12
"""Relative error by which a probability may exceed the allowed one and still count as equal: 0.1 has no exact float."""

_HALVINGS = 60
"""Halvings of the interval 0..1: down to the last digit of a float."""


def failures_allowed(reliability: float, confidence: float, repetitions: int) -> int | None:
    """Return how many of some repetitions may fail in a test of reliability; None if they are too few to show it.

    Parameters
    ----------
    reliability : float
        The share of successes to be shown.
    confidence : float
        The probability that a robot no better than this fails the test.
    repetitions : int
        Repetitions of the test.

    Returns
    -------
    int or None
        The largest number of failures.

    Raises
    ------
    ParameterError
        If a value is outside its bounds.
    """
    share, sure = _SHARE.check("reliability", reliability), _SHARE.check("confidence", confidence)
    count = _REPETITIONS.check("repetitions", repetitions)
    # The probability that a robot of just this reliability passes, as more and more failures are allowed.
    passed, allowed = 0.0, None
    for failures in range(count + 1):
        passed += _binomial(count, failures, 1 - share)
        if passed > (1 - sure) * (1 + _ROUNDING):
            break
        allowed = failures
    return allowed


def shown_reliability(failures: int, repetitions: int, confidence: float) -> float:
    """Return the reliability that some failures show, with a confidence: the lower end of Clopper and Pearson."""
    if failures >= repetitions:
        return 0.0
    # By bisection: the reliability with which so few failures have the probability 1 - confidence.
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        chance = sum(_binomial(repetitions, count, 1 - middle) for count in range(failures + 1))
        low, high = (middle, high) if chance < 1 - confidence else (low, middle)
    return low


def _binomial(count: int, failures: int, share: float) -> float:
    if not 0 < share < 1:
        return float(failures == (count if share >= 1 else 0))
    if count < 1000:  # exact to the last digits, and quick
        return float(comb(count, failures) * share**failures * (1 - share) ** (count - failures))
    ways = lgamma(count + 1) - lgamma(failures + 1) - lgamma(count - failures + 1)
    return exp(ways + failures * log(share) + (count - failures) * log(1 - share))


def _percent(share: float) -> str:
    """Return a share with all its digits: 99.95%."""
    return f"{decimal(100 * share)}%"


@dataclass(frozen=True, kw_only=True, slots=True)
class ReliabilityTest(Reported):
    """The result of `rsegen.rate` with a reliability to be shown.

    Attributes
    ----------
    drives : ManyDrives
        One for each repetition.
    reliability : float
        The share of successes to be shown.
    confidence : float
        The confidence with which it is to be shown.
    """

    drives: ManyDrives
    reliability: float
    confidence: float

    @property
    def repetitions(self) -> int:
        """Number of drives that have a result."""
        return self.drives.counted

    @property
    def failures(self) -> int:
        """Number of drives that did not cross."""
        return self.drives.counted - self.drives.crossed

    @property
    def allowed(self) -> int | None:
        """Number of drives that may fail; None if there are too few drives."""
        return failures_allowed(self.reliability, self.confidence, self.repetitions)

    @property
    def has_passed(self) -> bool:
        """Return whether the robot has passed."""
        return self.allowed is not None and self.failures <= self.allowed

    @property
    def shown(self) -> float:
        """The reliability that is shown with this confidence."""
        return shown_reliability(self.failures, self.repetitions, self.confidence)

    def as_json(self) -> dict[str, object]:
        """Return the content of test.json, which `rsegen rate --reliability --json` prints."""
        return {
            "reliability": self.reliability,
            "confidence": self.confidence,
            "repetitions": self.repetitions,
            "failures": self.failures,
            "allowed": self.allowed,
            "passed": self.has_passed,
            "shown": round(self.shown, 6),
            **self.drives.as_json(),
        }

    def report(self) -> Iterator[str]:
        """Yield the lines that `rsegen rate --reliability` prints."""
        drives, verdict = self.drives, "passed" if self.has_passed else "not passed"
        claim = f"a reliability of {_percent(self.reliability)} with a confidence of {_percent(self.confidence)}"
        yield f"{drives.recipe.name} in {drives.simulator}, {drives.route}, seed {drives.recipe.seed}:"
        yield f"  {drives.robot} failed in {self.failures} of {self.repetitions} repetitions: {verdict}"
        if self.allowed is None:
            yield f"  {self.repetitions} repetitions are too few to show {claim}, whatever their outcome"
        else:
            # Rounded down: no more is shown than that.
            shown = _percent(floor(self.shown * 1e4) / 1e4)
            yield f"  {claim} allows {self.allowed} failure{'s'[: self.allowed != 1]}; {shown} is shown"
        if failed := [drive for drive in drives.drives if drive.failed]:
            yield f"  {len(failed)} more have no result, and are not counted; the first: {failed[0].failed}"

    def write(self, folder: str | Path, *, force: bool = False) -> None:
        """Write test.json, drives.csv and the recipe into a folder; `force` replaces earlier ones."""
        files = {
            "test.json": [json.dumps(self.as_json(), indent=1).encode() + b"\n"],
            "drives.csv": list(self.drives.csv()),
            "recipe.json": [to_json(self.drives.recipe).encode()],
        }
        paths = {PurePosixPath(name): content for name, content in files.items()}
        write_folder(paths, Path(folder), "files", force=force)
