"""rsegen series: maps of difficulty that rises evenly."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict

from rsegen.cli.bar import counting
from rsegen.cli.by_metric import add_by_flags, by_from
from rsegen.cli.flags import RECIPE_HELP, Subparsers, add_recipe_flags, describe_flag, recipe_from
from rsegen.cli.formats import formats_of
from rsegen.cli.generate import add_output_flags, going_on, workers_from
from rsegen.exporters.numbers import decimal
from rsegen.field.metrics.catalogue import RMS
from rsegen.params.sorts import parameters
from rsegen.run.series import Series, series
from rsegen.run.series_rows import SeriesPlan, SeriesRow

_LINES = 12


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "series",
        description="Write the maps of a recipe at a difficulty that rises evenly from the first to the last, a table "
        "of the measured values (series.csv), and a picture (series.png).",
        epilog="docs/difficulty.md defines difficulty, and shows how near the maps come to it.",
    )
    command.add_argument_group("input").add_argument("recipe", nargs="?", metavar="RECIPE", help=RECIPE_HELP)
    add_output_flags(command)
    group, sorts = command.add_argument_group("difficulty"), parameters(SeriesPlan)
    for name, default in (("from_", 0.1), ("to", 1)):
        _, text = describe_flag(name, sorts[name], default)
        group.add_argument(f"--{name.rstrip('_')}", dest=name, default=str(default), metavar="D", help=text)
    group.add_argument("--same-field", action="store_true", help=sorts["same_field"].help)
    add_by_flags(group)
    add_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make the series, and say how it rises."""
    recipe = recipe_from(arguments)
    formats = formats_of("--formats", arguments.formats)
    from_, to = (_share(name, getattr(arguments, name)) for name in ("from_", "to"))
    with going_on(arguments, recipe), counting(recipe.maps) as progress:
        found = series(
            recipe,
            arguments.output,
            from_=from_,
            to=to,
            same_field=arguments.same_field,
            **by_from(arguments),
            force=arguments.force,
            resume=arguments.resume,
            preview=arguments.preview,
            sheet=arguments.sheet,
            formats=formats,
            workers=workers_from(arguments),
            scheduler=arguments.scheduler,
            sync=not arguments.no_sync,
            progress=progress,
        )
    print(json.dumps(_summary(found), indent=2) if arguments.json else "\n".join(_report(found)))


def _share(name: str, text: str) -> float:
    sort = parameters(SeriesPlan)[name]
    return float(sort.check(f"--{name.rstrip('_')}", sort.parse(text)))


def _summary(found: Series) -> dict[str, object]:
    rows = [asdict(row) | {"folder": str(found.folder / row.map)} for row in found.rows]
    files = {"table": str(found.table), "picture": str(found.picture)}
    return {"folder": str(found.folder), "seed": found.plan.recipe.seed, **files, "maps": rows}


def _report(found: Series) -> Iterator[str]:
    rows, there = found.rows, len(found.rows) - len(found.maps)
    already = f", {there} there already" if there else ""
    yield f"{len(rows)} maps in {found.folder}, seed {found.plan.recipe.seed}{already}; lengths in cm:"
    width = max(len(row.map) for row in rows)
    names, unit = ("rms asked", "rms step") if found.plan.by == RMS else ("asked", "measured"), found.plan.metric.unit
    yield f"  {'map':<{width}}" + "".join(f"{name:>12}" for name in ("difficulty", *names, "highest"))
    for row in _some(rows):
        values = (row.asked, unit), (row.measured, unit), (row.highest_step, "m")
        lengths = (_shown(*value) for value in values)
        yield f"  {row.map:<{width}}{decimal(row.difficulty):>12}" + "".join(f"{text:>12}" for text in lengths)
    for text in dict.fromkeys(text for one in found.maps for text in one.warnings):
        yield f"warning: {text}"
    yield f"all of it: {found.table}"
    yield f"a picture: {found.picture}"


def _some(rows: tuple[SeriesRow, ...]) -> list[SeriesRow]:
    """All of them, or some that are evenly spaced, with the last."""
    apart = -(-len(rows) // _LINES)
    return [*rows[:-1:apart], rows[-1]]


def _shown(value: float | None, unit: str) -> str:
    """Lengths in centimetres."""
    return "-" if value is None else f"{value * 100 if unit == 'm' else value:.2f}"
