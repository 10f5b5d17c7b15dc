"""A rating on a page: its curve while trials come in, and a drive of one of them.

    folder of a rating --journal--> trials --rating--> points, curve and band, drawn by a page
    trial --drive_trial--> a job: `rsegen drive` over its field at its level --> a drive, played by a page

The folder may come from anybody, and `rsegen rate` may still write into it.
"""

from __future__ import annotations

import shlex
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

import numpy as np

from rsegen.errors import FileError, ParameterError, UserError
from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.page.jobs import Job, JobRun, JobValues
from rsegen.page.model.texts import recipe_flags
from rsegen.rating.axes import AXES
from rsegen.rating.judges import usual_duration
from rsegen.rating.rate import Rated
from rsegen.rating.rating import HOLDS, Curve, axis_label, points_of, shown_places, ticks_between
from rsegen.rating.run import read_entries
from rsegen.recipe.building import build
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe import Recipe
from rsegen.writing.journal import read_journal

_POINTS = 61
"""Points of a curve: fewer than in a picture, as it is drawn again and again."""


class RatedTrial(TypedDict):
    """A robot on one field."""

    map: int  # the index of its field
    level: float
    crossed: bool | None  # null: it has no result


class RatedCurve(TypedDict):
    """The trials of one judge, and the curve fitted to them."""

    judge: str
    half: str  # in words, with its interval
    points: list[tuple[float, int, int]]  # level, crossed, trials: several trials near to each other
    line: list[tuple[float, float, float, float]]  # level, share that is crossed, and the ends of its 95 % interval
    trials: list[RatedTrial]


class RatingSoFar(TypedDict):
    """A rating, with the trials that have been made."""

    robot: str
    axis: str  # what the levels are
    ticks: list[float]
    is_rising: bool  # whether higher levels are harder
    curves: list[RatedCurve]
    can_drive: bool  # whether a trial can be driven again


class _Begun(NamedTuple):
    """Content of the journal of a rating; rated: None for a function, or a robot made in Python."""

    name: str
    rated: Rated | None
    recipe: Recipe
    curves: list[Curve]


@call_of_host
def rating(host: Host, *, path: str) -> RatingSoFar:
    """Return the rating that a folder holds, also of a command that still runs; a UserError until a trial has ended."""
    begun = _begun(host.places.inside(path))
    curves = [curve for curve in begun.curves if any(trial.crossed is not None for trial in curve.trials)]
    if not curves:
        raise UserError(f"{path}: no trial has a result yet")
    axis, (first, last) = curves[0].axis, shown_places(curves)
    places = np.linspace(first, last, _POINTS)
    low, high = sorted((axis.level(first), axis.level(last)))
    return {
        "robot": begun.name,
        "axis": axis_label(axis),
        "ticks": ticks_between(low, high).tolist(),
        "is_rising": axis.is_rising,
        "curves": [_drawn(curve, places) for curve in curves],
        "can_drive": begun.rated is not None,
    }


@call_of_host
def drive_trial(host: Host, *, doc: str, path: str, judge: str, trial: int) -> JobValues:
    """Drive a trial again in MuJoCo, as a job that writes a drive next to the folder of its rating.

    judge: its title; trial: the index of its field
    """
    begun = _begun(folder := host.places.inside(path))
    host.places.refuse_outside("robot", begun.name)  # the folder may be anybody's
    made = next((curve.trials for curve in begun.curves if curve.title == judge), ())
    if not 0 <= trial < len(made):
        raise ParameterError("trial", f"{trial} is none of the {len(made)} trials of {judge}")
    if begun.rated is None:
        raise ParameterError("trial", f"{begun.name} is no robot that rsegen drives")
    at, axis = made[trial], begun.curves[0].axis
    recipe = axis.recipe_at(begun.recipe, at.level).alone(at.map)
    duration = at.duration or usual_duration(begun.rated.model(), build(recipe, at.map))
    place = host.places.relative(folder.with_name(f"{folder.name}-trials") / f"map_{at.map}_{axis.name}_{at.level:g}")
    flags = [*begun.rated.replay(), f"--duration={duration:g}", "--no-predict", f"--output={place}", "--force"]
    job = Job(
        id=host.jobs.new_id(),
        doc=doc,
        command="drive",
        line=shlex.join(["rsegen", "drive", *recipe_flags(recipe), *flags]),
        output=str(place),
    )
    arguments = ["drive", *flags, "--json", "--progress=json", "--"]
    host.jobs.start(JobRun(job=job, arguments=arguments, recipe=recipe, folder=host.folder.resolve(), output=place))
    return asdict(job)


def _begun(folder: Path) -> _Begun:
    """Return the content of the folder of a rating so far; a FileError if it has none."""
    journal = read_journal(folder)
    if journal is None or journal.holds != HOLDS:
        raise FileError(f"{folder}: contains no rating")
    try:
        of: Any = journal.of
        axis, recipe = AXES[of["axis"]], decode(of["recipe"])
        curves = read_entries(folder, journal).items()
        # A robot made in Python is known by its checksum alone (`Rated.described`), so nobody can drive it again.
        rated = None
        if of.get("robot") and not of["made"]:
            limits = {name: tuple(value) if isinstance(value, list) else value for name, value in of["limits"].items()}
            rated = Rated(robot=of["robot"], limits=limits, motors=of["motors"], duration=of["duration"])
        name = str(of.get("robot") or of["function"])
    except (KeyError, TypeError, AttributeError):
        raise FileError(f"{folder}: its journal is not that of a rating") from None
    return _Begun(
        name=name,
        rated=rated,
        recipe=recipe,
        curves=[Curve(by="", title=title, axis=axis, trials=tuple(trials)) for title, trials in curves],
    )


def _drawn(curve: Curve, places: np.ndarray[Any, Any]) -> RatedCurve:
    """Return a curve for the page, drawn at some places of its axis."""
    known = curve.posterior
    rows = zip(map(curve.axis.level, places), known.expected(places), *known.band(places), strict=True)
    return {
        "judge": curve.title,
        "half": "" if curve.outside else curve.axis.shown(*curve.half),
        "points": list(points_of(curve)),
        "line": [(float(level), float(share), float(low), float(high)) for level, share, low, high in rows],
        "trials": [{"map": trial.map, "level": trial.level, "crossed": trial.crossed} for trial in curve.trials],
    }
