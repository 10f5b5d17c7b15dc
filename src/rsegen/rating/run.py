"""The run of a rating: batches of trials until the interval is narrow enough, kept in a journal as they end.

    trials so far --posterior--> next levels --judge, on all cores--> outcomes --journal--> trials so far

The size of a batch depends on the number of trials alone, and its levels on the trials before it. So a rating is the
same wherever its trials are made, and a stopped one continues as if it had not been stopped. Cost: its trials; while
the last trial of a batch runs, other workers wait. What breaks it: a simulator that does not repeat itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, UserError, refuse_unknown
from rsegen.input_files import JOURNAL
from rsegen.params.sorts import Flag, Float, Integer, Json, Text
from rsegen.params.streams import generator
from rsegen.rating.axes import Axis
from rsegen.rating.judges import Asked, Judge, Trial, trials
from rsegen.rating.psychometric import next_places
from rsegen.rating.rating import FILES, HOLDS, Curve
from rsegen.recipe.recipe import Recipe
from rsegen.writing.execute import Execution, executor_of
from rsegen.writing.journal import Journal
from rsegen.writing.store import Store, continued

_BATCH, _MOST_IN_BATCH, _SHARE = 8, 64, 8
"""Trials of a batch: at least, at most, and one per `_SHARE` trials before it. They are chosen without each other's
outcomes, so they are few at first, when each outcome tells much, and more later, for machines of many cores."""

_LEAST = 48
"""Trials of a rating at least: a third of them find where the curve is, and after fewer an interval that is too narrow
by chance would end it."""

_MOST = 2000
"""Trials of a rating at most, if it ends by its precision: a curve that is nearly level takes for ever."""

Progress = Callable[[int, float], None]
"""Called with the number of finished trials, and an estimate of their share of all."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RatingPlan:
    """Plan of a rating: fields at levels of an axis, until `trials` are made or half is known to `precision`.

    precision: half the width of the 95 % interval, as a factor less 1
    """

    recipe: Recipe
    axis: Axis
    trials: int | None
    precision: float


def batch_size(done: int) -> int:
    """Return the number of trials in the batch that begins after `done` trials."""
    return min(max(_BATCH, done // _SHARE), _MOST_IN_BATCH)


def make_curve(
    plan: RatingPlan,
    judge: Judge,
    begun: Sequence[Trial],
    execution: Execution,
    keep: Callable[[Trial], None],
    progress: Progress,
) -> Curve:
    """Return the curve of a judge from earlier trials and new ones; `keep` is called with each new trial.

    UserError if no trial of the first batch has a result.
    """
    # `first` is where the batch begins that is not complete: its trials were chosen from those before it alone.
    done, first = list(begun), 0
    while first + batch_size(first) <= len(done):
        first += batch_size(first)
    work = partial(trials, judge, plan.axis, plan.recipe)
    with executor_of(work, judge.cost, execution) as made:
        while len(done) < (plan.trials or _MOST):
            known = _curve(plan, judge, done[:first])
            if len(done) <= first and plan.trials is None and _is_precise(plan, known):
                break
            batch, expected = _batch(plan, known), _expected(plan, known)
            for trial in chain.from_iterable(made(batch[len(done) - first :])):
                keep(trial)
                done.append(trial)
                progress(len(done), min(len(done) / expected, 1.0))
            if all(trial.crossed is None for trial in done):
                raise UserError(f"none of {len(done)} trials has a result; the first: {done[0].failed}")
            first += len(batch)
    return _curve(plan, judge, done)


def _curve(plan: RatingPlan, judge: Judge, done: Sequence[Trial]) -> Curve:
    return Curve(by=judge.name, title=judge.title, axis=plan.axis, trials=tuple(done))


def _is_precise(plan: RatingPlan, known: Curve) -> bool:
    """Return whether a rating by its precision ends with these trials."""
    return len(known.trials) >= _LEAST and (known.precision <= plan.precision or bool(known.outside))


def _expected(plan: RatingPlan, known: Curve) -> float:
    """Return an estimate of the trials that a rating takes: its interval narrows with the root of their number."""
    so_far = len(known.trials)
    if plan.trials is not None:
        return plan.trials
    return max(so_far * (known.precision / plan.precision) ** 2, so_far + batch_size(so_far), 1.5 * _LEAST)


def _batch(plan: RatingPlan, known: Curve) -> list[Asked]:
    """Return the trials of the batch that follows the trials of a curve."""
    first = len(known.trials)
    rng = generator(plan.recipe.seed, first, "next trials of a rating")
    places = next_places(known.posterior, plan.axis.candidates, batch_size(first), rng)
    asked = [Asked(first + offset, plan.axis.tried(place)) for offset, place in enumerate(places)]
    return asked if plan.trials is None else asked[: plan.trials - first]


# The folder of a rating.


def opened(folder: Path, of: Json, *, force: bool) -> AbstractContextManager[Store]:
    """Open the folder of a new or begun rating, or with force of its replacement; OutputError if it has other files."""
    problem = "another rating; use another folder, or force=True, or the seed, options and plug-ins of that one"
    return continued(folder, HOLDS, of, FILES, force=force, other=problem)


def entry(judge: Judge, trial: Trial) -> dict[str, Json]:
    """Return the journal's entry of a trial, with the title of its judge, as another version may judge otherwise."""
    return {"judge": judge.title, **asdict(trial)}


_SORTS: dict[str, Any] = {
    "judge": Text(r".{1,500}", "the title of a judge"),
    "map": Integer(0),
    "level": Float(0),
    "crossed": Flag(),
    "seconds": Float(0),
    "x": Float(),
    "tipped": Integer(0),
    "duration": Float(0),
    "failed": Text(r".*", "a line"),
}
_OPTIONAL = {"crossed", "seconds", "x", "tipped", "duration"}


def read_entries(folder: Path, journal: Journal | None) -> dict[str, list[Trial]]:
    """Return the trials in a folder's journal by the titles of their judges; FileError if an entry was changed."""
    begun: dict[str, list[Trial]] = {}
    for line, result in enumerate(journal.results if journal else (), 1):
        try:
            refuse_unknown("key", result, _SORTS)
            values: dict[str, Any] = {
                name: None if result.get(name) is None and name in _OPTIONAL else sort.check(name, result.get(name))
                for name, sort in _SORTS.items()
            }
            known = begun.setdefault(values.pop("judge"), [])
            if values["map"] != len(known):
                raise ParameterError("map", f"{values['map']} is not {len(known)}, the next one")
        except ParameterError as error:
            advice = "use another folder, or force=True"
            raise FileError(f"{folder / JOURNAL}: result {line}: {error}; {advice}") from None
        known.append(Trial(**values))
    return begun
