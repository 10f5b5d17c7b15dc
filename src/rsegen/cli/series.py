"""rsegen series: maps of difficulty that rises evenly."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from rsegen.cli.flags import add_format_rows, add_input, add_recipe_flags, recipe_from
from rsegen.cli.generate import going_on, run_options
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, counting
from rsegen.commands.maps import generate, series
from rsegen.params.command import add_flags, declared

if TYPE_CHECKING:
    from rsegen.run.series import Series
    from rsegen.run.series_rows import SeriesRow

_LINES = 12
"""Rows of a series that are printed."""


def add_series(command: Parser) -> None:
    """Add the flags of `rsegen series`."""
    epilog = "docs/difficulty.md defines difficulty, and shows how near the maps come to it."
    command.explain(series.__doc__, epilog)
    add_input(command.add_argument_group("input"))
    add_flags(command.add_argument_group("output"), series, only=declared(generate))
    add_format_rows(command)
    add_flags(command.add_argument_group("difficulty"), series, without=declared(generate))
    add_recipe_flags(command)


def run_series(arguments: argparse.Namespace) -> Report:
    """Make the series, and say how it rises."""
    recipe = recipe_from(arguments)
    options = run_options(series, arguments)
    with going_on(arguments, recipe), counting(recipe.maps) as progress:
        made = call(series, arguments, recipe, **options, progress=progress)
    return Report(lines=_lines(made), content=lambda: _content(made))


def _content(made: Series) -> dict[str, object]:
    rows = [asdict(row) | {"folder": str(made.folder / row.map)} for row in made.rows]
    files = {"table": str(made.table), "picture": str(made.picture)}
    return {"folder": str(made.folder), "seed": made.plan.recipe.seed, **files, "maps": rows}


def _lines(made: Series) -> Iterator[str]:
    from rsegen.exporters.numbers import decimal, lengths_in

    rows, there, written = made.rows, len(made.rows) - len(made.maps), lengths_in(made.plan.recipe.units)
    already = f", {there} there already" if there else ""
    yield f"{len(rows)} maps in {made.folder}, seed {made.plan.recipe.seed}{already}; lengths in {written.name}:"
    width, by_default = max(len(row.map) for row in rows), made.plan.by == declared(series)["by"].default
    names, unit = ("rms asked", "rms step") if by_default else ("asked", "measured"), made.plan.metric.unit
    yield f"  {'map':<{width}}" + "".join(f"{name:>12}" for name in ("difficulty", *names, "highest"))
    for row in _some(rows):
        values = (row.asked, unit), (row.measured, unit), (row.highest_step, "m")
        lengths = (_shown(*value, written.per_metre) for value in values)
        yield f"  {row.map:<{width}}{decimal(row.difficulty):>12}" + "".join(f"{text:>12}" for text in lengths)
    if len(rows) > _LINES:
        yield f"  ({len(rows) - len(_some(rows))} rows between them are left out)"
    for text in dict.fromkeys(text for each in made.maps for text in each.warnings):
        yield f"warning: {text}"
    yield f"all of it: {made.table}"
    yield f"a picture: {made.picture}"


def _some(rows: tuple[SeriesRow, ...]) -> list[SeriesRow]:
    """Return all rows, or some that are evenly spaced, with the last."""
    apart = -(-len(rows) // _LINES)
    return [*rows[:-1:apart], rows[-1]]


def _shown(value: float | None, unit: str, per_metre: float) -> str:
    """Lengths in the units of the recipe."""
    return "-" if value is None else f"{value * per_metre if unit == 'm' else value:.2f}"
