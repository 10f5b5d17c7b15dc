"""rsegen metrics: how rough maps are, and what a robot can do on them; a page for one map, a line each for many."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import chain
from math import radians
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.flags import add_target_flags, add_target_recipe_flags, maps_of_flags
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, share_bar
from rsegen.errors import ParameterError
from rsegen.field.crossing import CrossingModel, StepLimits, predictions, robot_kinds, robot_that_crosses
from rsegen.params.command import Shell, add_flags, given
from rsegen.params.numbers import Lengths, counted, lengths_in, whole_degrees
from rsegen.params.sorts import Flag, Float, Reference
from rsegen.pictures.flags import PictureName, picture_of

if TYPE_CHECKING:
    from rsegen.field.steps import Steps
    from rsegen.measuring.catalogue import Metrics
    from rsegen.measuring.roughness import Scale
    from rsegen.measuring.spectrum import Spectrum
    from rsegen.scene.scene import Scene

    Measured = tuple[Scene, Metrics, Mapping[str, Any]]

_KINDS = Reference(
    "a kind of robot, or a file of one", help="kind of robot, or SDF, URDF, Xacro or MJCF file of a model"
)
_NO_ROBOT = "choose a robot, as in --robot burger, or limits of steps, as in --climb-cm 10"


@dataclass(frozen=True, kw_only=True, slots=True)
class _Options:
    """The robot that the shell can name, and the picture that it can ask for."""

    robot: Annotated[str | None, _KINDS, Shell(metavar="KIND|FILE")] = None
    verify: Annotated[
        bool, Flag(help="drive the robot across in MuJoCo, again and again, and report how surely it gets across")
    ] = False
    output: Annotated[
        PictureName, Shell(help="draw the ways of the robot across the first map, and the area that it can reach")
    ] = None
    heading: Annotated[
        float | None,
        Float(
            -360, 360, unit="degrees", help="draw maps of the robot's tilt, margin and reason at this heading instead"
        ),
        Shell(metavar="DEG"),
    ] = None
    force: Force = False


def add_metrics(command: Parser) -> None:
    """Add the flags of `rsegen metrics`."""
    text = (
        "Measure how rough maps are: heights, steps, scale, ruggedness, and the smallest step with which they can be "
        "crossed. With a robot, also the area that it can reach, and its ways across, judged by its poses; with limits "
        "of steps, judged by cells."
    )
    command.explain(text, "docs/metrics.md has every formula.", robot_kinds)
    add_target_flags(command, "all")
    group = command.group("robot", "a robot, judged pose by pose: where it stands, tips over or gets stuck")
    add_flags(group, _Options, only=["robot", "verify"])
    group = command.group("limits of steps", "instead of a robot: paths from cell to cell")
    add_flags(group, StepLimits)
    output = command.group("output")
    output.add_argument("--csv", action="store_true", help="print a table as CSV, lengths in metres")
    add_flags(output, _Options, without=["robot", "verify"])
    add_target_recipe_flags(command)


def run_metrics(arguments: argparse.Namespace) -> Report:
    """Measure maps, and draw the first one if a picture is asked for."""
    # All that may be refused comes before the first map, whose metrics may take minutes with a robot.
    if arguments.json and arguments.csv:
        raise ParameterError("--csv", "--json and --csv exclude each other")
    robot = _crosser(arguments)
    picture = picture_of(arguments.output, force=arguments.force)
    if picture and robot is None:
        raise ParameterError("-o/--output", f"there is nothing to draw without a robot; {_NO_ROBOT}")
    heading = given(_Options, arguments).get("heading")
    if heading is not None and picture is None:
        raise ParameterError("--heading", "is for a picture; use -o too")
    if heading is not None and isinstance(robot, StepLimits):
        raise ParameterError("--heading", "limits of steps have no poses; use --robot")
    verify = given(_Options, arguments).get("verify", False)
    if verify and (robot is None or isinstance(robot, StepLimits)):
        raise ParameterError("--verify", "drives a robot; choose one, as in --robot burger")
    scenes = _scenes(arguments)
    first = next(scenes)
    measured = _measured(first, robot, verify=verify)
    if picture and robot:
        picture.write(partial(_picture, first, robot, measured[1], heading))
    rows: Iterable[Measured] = chain([measured], (_measured(scene, robot, verify=verify) for scene in scenes))
    if arguments.json:
        rows = list(rows)  # JSON needs all of them at once anyway, and then its report may too
    lines = _csv(rows) if arguments.csv else _report(rows, robot, first.units)
    return Report(lines=lines, content=lambda: [_entry(*row) for row in rows])


def _scenes(arguments: argparse.Namespace) -> Iterator[Scene]:
    """Yield the maps to measure, each when it is asked for."""
    from rsegen.scene.scene import compose
    from rsegen.writing.resources import refuse_too_large

    for recipe in maps_of_flags(arguments):
        refuse_too_large(recipe, "measure")
        yield from (compose(recipe, index) for index in recipe.indices)


def _crosser(arguments: argparse.Namespace) -> CrossingModel | None:
    """Return the robot or the limits of steps that the flags give, if any."""
    given_limits = given(StepLimits, arguments)
    if arguments.robot is not None:
        if given_limits:
            raise ParameterError("--climb-cm", "excludes --robot, which has its own limits")
        return robot_that_crosses(arguments.robot, "--robot")
    if given_limits and "climb_cm" not in given_limits:
        raise ParameterError("--climb-cm", _NO_ROBOT)
    return StepLimits(**given_limits) if given_limits else None


def _measured(scene: Scene, crosser: CrossingModel | None, *, verify: bool) -> Measured:
    """Return a map, its metrics, and how surely a robot gets across; a search that may take a minute is shown as a bar.

    verify: whether the robot is driven across
    """
    from rsegen.measuring.catalogue import metrics

    if crosser is None or not crosser.search:
        return scene, metrics(scene.field, crosser), {}
    with share_bar(scene.name) as watch:
        measured = metrics(scene.field, crosser.watched(watch))
    return scene, measured, predictions(crosser, scene) if verify else {}


def _picture(scene: Scene, crosser: CrossingModel, measured: Metrics, heading: float | None, form: str) -> bytes:
    """Draw the ways across a map, or maps of a robot's poses at a heading in degrees."""
    if heading is not None:
        return crosser.pose_maps(scene, radians(heading), form)
    from rsegen.measuring.plots import path_plot

    return path_plot(scene, measured.reach, crosser.in_words(scene.units), form)


def _entry(scene: Scene, measured: Metrics, predicted: Mapping[str, Any]) -> dict[str, Any]:
    from rsegen.measuring.catalogue import custom, nested

    whole: dict[str, Any] = {"map": scene.name, "seed": scene.recipe.seed, **nested(measured)}
    if predicted:
        whole["predictions"] = {side: prediction.as_json() for side, prediction in predicted.items()}
    return {name: value for name, value in whole.items() if value is not None} | custom(scene.field)


def _csv(measured: Iterable[Measured]) -> Iterator[str]:
    """Yield the lines of a table with a column for each metric of the first map."""
    from rsegen.measuring.catalogue import flattened

    columns: list[str] = []
    for row in measured:
        values = dict(flattened(_entry(*row)))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns or list(values), lineterminator="\n")
        if not columns:
            columns = list(values)
            writer.writeheader()
        writer.writerow(values)
        yield text.getvalue()[:-1]


def _report(measured: Iterable[Measured], crosser: CrossingModel | None, units: str) -> Iterator[str]:
    """Yield the lines of a page for one map, of a table for more of them."""
    maps = iter(measured)
    first, second = next(maps), next(maps, None)
    yield from _table(chain([first, second], maps), crosser) if second else _page(*first, crosser)


def _table(measured: Iterable[Measured], crosser: CrossingModel | None) -> Iterator[str]:
    from rsegen.measuring.catalogue import METRICS, custom

    # Row by row, as maps are measured: the first one decides the columns, and the legend below.
    legend, maps, crossed = dict(_LEGEND), 0, dict.fromkeys(_SIDES, 0)
    for maps, (scene, measures, predicted) in enumerate(measured, 1):
        own = {(name, METRICS[name].unit): _plain(value) for name, value in custom(scene.field).items()}
        cells = _cells(measures, predicted, lengths_in(scene.recipe.units)) | own
        if maps == 1:
            legend |= _LEGEND_OF_REACH if measures.reach else {}
            legend |= _LEGEND_OF_PREDICTIONS if predicted else {}
            yield f"{'map':<24}" + "".join(f"{name:>{_width(name, unit)}}" for name, unit in cells)
            yield f"{'':<24}" + "".join(f"{unit:>{_width(name, unit)}}" for name, unit in cells)
        yield f"{scene.name:<24}" + "".join(f"{text:>{_width(*head)}}" for head, text in cells.items())
        for side in crossed if measures.reach else ():
            crossed[side] += getattr(measures.reach, side).length is not None
    yield ""
    if crosser:
        can = "can cross" if crosser.search else "leads across"
        of_sides = " and ".join(f"{crossed[side]} {name}" for side, name in _SIDES.items())
        yield f"Predicted: of {maps} maps, {_subject(crosser, scene.units)} {can} {of_sides}."
        if crosser.search and not predicted:
            yield _HOW_SURELY
        yield ""
    yield from (f"{name:<11}{text}" for name, text in legend.items())
    yield "details of one map: rsegen metrics --map INDEX; all formulas: docs/metrics.md"


_LEGEND = {
    "height, sd": "mean height of the blocks, and its standard deviation",
    "step, max": "height difference of neighbouring blocks: the mean, the largest",
    "TRI": "terrain ruggedness index: root mean square height difference of a block from its 8 neighbours",
    "surface": "area of tops and sides, divided by that of the plan",
    "climb w-e": "smallest step with which some path leads across from west to east; s-n: from south to north",
}
_LEGEND_OF_REACH = {
    "region": "share of the blocks in the largest region of mutually reachable blocks",
    "way w-e": "length of its way from west to east, divided by that of a straight one; empty: no way",
}
_LEGEND_OF_PREDICTIONS = {"p w-e": "probability that it gets across, by drives with errors in MuJoCo"}
"""The words below a table, for readers who do not know docs/metrics.md."""


def _width(name: str, unit: str) -> int:
    """Return the width of a column; a metric of a plug-in may have a long name, and a long unit."""
    return max(_WIDTH, len(name) + 2, len(unit) + 2)


_WIDTH = 7
_SIZES = 24
"""The largest number of step sizes that a page lists."""


def _cells(measures: Metrics, predicted: Mapping[str, Any], written: Lengths) -> dict[tuple[str, str], str]:
    """Return the cells of one map in a table, by the heads of its columns and their units; empty without a value."""
    lengths = {
        "height": measures.spread.mean,
        "sd": measures.spread.deviation,
        "step": measures.steps.mean,
        "max": measures.steps.highest,
        "TRI": measures.ruggedness.tri,
        "climb w-e": measures.opening.west_east,
        "climb s-n": measures.opening.south_north,
    }
    cells = {
        (name, written.unit): "" if length is None else written.measured(length) for name, length in lengths.items()
    }
    # Ratios have no unit of length; those of a robot are columns only if one is given.
    cells["surface", "x"] = f"{measures.ruggedness.surface_ratio:.2f}"
    if measures.reach is not None:
        cells["region", "%"] = f"{measures.reach.coverage:.0%}".rstrip("%")
        cells["way w-e", "x"] = _ratio(measures.reach.west_east)
        cells["way s-n", "x"] = _ratio(measures.reach.south_north)
    for side, prediction in predicted.items():
        first, second = side.split("_")
        cells[f"p {first[0]}-{second[0]}", ""] = f"{prediction.probability:.2f}"
    return cells


def _ratio(way: Any) -> str:
    ratio = getattr(way, "cost_ratio", way.length_ratio)
    return "" if ratio is None else f"{ratio:.2f}"


def _page(
    scene: Scene, measures: Metrics, predicted: Mapping[str, Any], crosser: CrossingModel | None
) -> Iterator[str]:
    blocks, written = sum(measures.spread.level_counts.values()), lengths_in(scene.recipe.units)
    width = written.short(round(scene.field.block_width * 1e9))
    size = f"{width} x {width} {written.unit}"
    yield f"{scene.name}, seed {scene.recipe.seed}: {counted(blocks, 'block')} of {size}; frames are not blocks"
    yield from _verdict(scene, measures, predicted, crosser)
    yield ""
    # From single blocks to their neighbours, to the whole map, and at last to what crosses it.
    spread, plane = measures.spread, measures.plane
    of_mean = "" if spread.variation is None else f" ({spread.variation:.3f} of the mean)"
    heights = f"{written.measured(spread.lowest)}..{written.with_unit(spread.highest)}"
    yield f"heights  {heights}, mean {written.with_unit(spread.mean)}"
    deviation = written.with_unit(spread.deviation)
    yield f"         standard deviation {deviation}{of_mean}, entropy {spread.entropy:.2f} bits"
    yield from _steps(measures.steps, written)
    off = f"heights deviate by {written.with_unit(plane.residual)} (rms) from their plane of least squares"
    yield f"plane    {off}, which rises by {plane.slope:.1%}"
    yield _scale(measures.scale, written)
    yield _spectrum(measures.spectrum)
    rugged, opens = measures.ruggedness, measures.opening
    tri = f"{written.with_unit(rugged.tri)} (root mean square), {written.with_unit(rugged.riley)} (Riley)"
    yield f"rugged   TRI {tri}, of {rugged.cells:,} blocks"
    yield "         TRI: terrain ruggedness index, of the height differences of a block from its 8 neighbours"
    yield f"surface  {rugged.surface_ratio:.2f} times the plan"
    wide = " for its width" if measures.reach else ""
    ways = f"{written.with_unit(opens.west_east)} west to east, {written.with_unit(opens.south_north)} south to north"
    yield f"climb    needed to cross{wide}: {ways}"
    if measures.reach and crosser:
        yield from _reach(measures.reach, crosser, scene.units)
    from rsegen.measuring.catalogue import METRICS, custom

    for name, value in custom(scene.field).items():
        yield f"{name:<8} {_plain(value)} {METRICS[name].unit} ({METRICS[name].help.rstrip('.')})"


_SIDES = {"west_east": "west to east", "south_north": "south to north"}


def _verdict(
    scene: Scene, measures: Metrics, predicted: Mapping[str, Any], crosser: CrossingModel | None
) -> Iterator[str]:
    """Yield what a person came for: how rough the map is, or whether a robot gets across, with its certainty."""
    written = lengths_in(scene.recipe.units)
    if measures.reach is None or crosser is None:
        steps, opens = measures.steps, measures.opening
        heights = f"{written.measured(measures.spread.lowest)} to {written.with_unit(measures.spread.highest)}"
        mean, highest = (written.with_unit(step) for step in (steps.mean, steps.highest))
        differ = (
            f"neighbours differ by {mean} on average, by {highest} at most" if steps.counts else "none has a neighbour"
        )
        climbs = " and ".join(f"{written.with_unit(getattr(opens, side))} {name}" for side, name in _SIDES.items())
        yield f"Blocks are {heights} high; {differ}."
        yield f"To cross it, a robot must climb steps of {climbs}."
        return
    # A way that was driven is told by its drives, any other by its poses or cells.
    subject = _subject(crosser, scene.units)
    can, cannot = ("can cross", "cannot cross") if crosser.search else ("leads", "does not lead")
    ways = {name: getattr(measures.reach, side) for side, name in _SIDES.items() if side not in predicted}
    yield from (f"{_SIDES[side].capitalize()}, the robot {drives}." for side, drives in predicted.items())
    if across := [name for name, way in ways.items() if way.length is not None]:
        yield f"Predicted: {subject} {can} {' and '.join(across)}."
    for name, way in ways.items():
        if way.length is None:
            yield f"Predicted: {subject} {cannot} {name}{f': {why}' if (why := _why_not(way)) else ''}."
    if ways and crosser.search:
        yield _HOW_SURELY


_HOW_SURELY = "To see how surely, drive it: add --verify, or use rsegen predict."


def _subject(crosser: CrossingModel, units: str) -> str:
    """Return a robot or limits of steps as the subject of a sentence."""
    return f"the {crosser.in_words(units)}" if crosser.search else crosser.in_words(units)


def _steps(steps: Steps, written: Lengths) -> Iterator[str]:
    pairs = sum(steps.counts.values())
    mean, rms, highest = map(written.with_unit, (steps.mean, steps.rms, steps.highest))
    yield f"steps    mean {mean}, rms {rms}, highest {highest}"
    if len(steps.counts) > _SIZES:
        yield f"         of {len(steps.counts):,} sizes, which --json lists"
        return
    for size, count in steps.counts.items():
        yield f"         {written.measured(size * steps.unit):>6} {written.unit}  {count:>9,}  {count / pairs:6.1%}"


def _scale(scale: Scale, written: Lengths) -> str:
    if scale.hurst is None:
        return "scale    no exponent: the map is too small, or flat"
    weak = f"; weak, of {len(scale.lags)} lags" if scale.hurst_is_weak else ""
    first, last = ((written.with_unit(scale.rms[at]), written.with_unit(scale.lags[at])) for at in (0, -1))
    grows = f"rms difference {first[0]} at {first[1]}, {last[0]} at {last[1]}"
    return f"scale    {grows} (Hurst exponent {round(scale.hurst, 2) + 0:.2f}{weak})"


def _spectrum(spectrum: Spectrum) -> str:
    sides = {"west to east": spectrum.west_east, "south to north": spectrum.south_north}
    falls = ", ".join(
        f"{name} {'without exponent' if side.exponent is None else f'as f^{round(-side.exponent, 2) + 0:.2f}'}"
        for name, side in sides.items()
    )
    weak = "; weak, of few frequencies f" if any(side.exponent_is_weak for side in sides.values()) else ""
    return f"spectrum falls {falls}{weak}"


def _reach(reach: Any, crosser: CrossingModel, units: str) -> Iterator[str]:
    yield f"\n{crosser.in_words(units)}:"
    written = lengths_in(units)
    climbable, droppable = getattr(reach, "climbable", None), getattr(reach, "droppable", None)
    if climbable is not None and droppable is not None:
        yield f"steps    {climbable:.1%} can be climbed, {droppable:.1%} can be descended"
    if poses := getattr(reach, "poses", None):
        yield from _poses(poses, written)
    yield f"region   {reach.coverage:.1%} of the blocks, all mutually reachable (analogue of coverability)"
    yield f"ways     west to east: {_way(reach.west_east)} (analogue of crossability)"
    yield from (f"           {event}" for event in crosser.events(reach.west_east))
    yield f"         south to north: {_way(reach.south_north)}"
    yield from (f"           {event}" for event in crosser.events(reach.south_north))


def _poses(poses: Any, written: Lengths) -> Iterator[str]:
    yield f"poses    at all blocks, in eight headings: it stands in {poses.stands:.1%} of them"
    if poses.ambiguous:
        yield f"         at about {poses.ambiguous:.0%} of these places it may stand in more than one way"
    if poses.tilt_median is not None and poses.tilt_p90 is not None:
        half, most = (whole_degrees(tilt) for tilt in (poses.tilt_median, poses.tilt_p90))
        yield f"         tilt {half} or less in half of these, {most} or less in 90 %"
    if poses.clearance_median is not None and poses.clearance_least is not None:
        half, least = written.with_unit(poses.clearance_median), written.with_unit(poses.clearance_least)
        yield f"         clearance {half} or more in half of these, {least} at the least"


def _why_not(way: Any) -> str:
    """Return why a robot does not get across, and where; an empty text for paths of cells, which have no reason."""
    reason, at = getattr(way, "reason", None), getattr(way, "at", None)
    return "" if reason is None or at is None else f"it {reason} at x {at[0]:.2f}, y {at[1]:.2f} m"


def _way(way: Any) -> str:
    if way.length is None:
        # Drives may cross where poses find no way, and are reported above.
        return f"none by its poses; {why}" if (why := _why_not(way)) else "none"
    straight = f"{way.length:.2f} m, {way.length_ratio:.2f} x straight"
    if isinstance(cost := getattr(way, "cost", None), float):
        return f"{straight}; with rises {cost:.2f} m, {getattr(way, 'cost_ratio', 0):.2f} x"
    return f"{straight}, tilts up to {whole_degrees(getattr(way, 'tilt', 0.0))}"


def _plain(value: float | None) -> str:
    """Return a metric of a plug-in, in its own unit."""
    return "-" if value is None else f"{value:.4g}"
