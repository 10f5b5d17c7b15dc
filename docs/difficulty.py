"""The figures of docs/difficulty.md: how near eased maps come to what is asked, and what is left of their shapes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from rsegen import KINDS, Recipe, build, load
from rsegen.field.stepfield import Levels
from rsegen.field.steps import steps
from rsegen.params.streams import generator
from rsegen.recipe.difficulty import nearest_field, parts_of, roughness, scaled
from rsegen.recipe.examples import EXAMPLES

SHARES = [number / 20 for number in range(1, 21)]
EXAMPLE = replace(load(EXAMPLES["mixed-course"]), maps=20)
"""The recipe of the series that are shown."""

_KINDS: Mapping[str, tuple[str, int, float]] = {
    "`random`, 5 levels": ("random", 5, 0),
    "`random`, 40 levels": ("random", 40, 0),
    "`random`, 2 levels": ("random", 2, 0),
    "`normal_random`": ("normal_random", 5, 0),
    "`pallet`": ("pallet", 5, 0),
    "`peak`, softness 0": ("peak", 5, 0),
    "`peak`, softness 100": ("peak", 5, 100),
    "`horizontal_barrier`, softness 0": ("horizontal_barrier", 5, 0),
    "`horizontal_barrier`, softness 50": ("horizontal_barrier", 5, 50),
    "`diagonal_barrier`, softness 0": ("diagonal_barrier", 5, 0),
}


def table() -> Iterator[str]:
    """A row for every recipe."""
    yield "| recipe | blocks | rms step at 1, cm | largest error | mean | changed pairs | random rounding |"
    yield "|---|---|---|---|---|---|---|"
    for chunks in (1, 4):
        yield from (_row(name, recipe) for name, recipe in _alone(chunks).items())
    for name, path in EXAMPLES.items():
        if name != "large-random":
            yield _row(f"example `{name}`", load(path))


def _alone(chunks: int) -> dict[str, Recipe]:
    """Recipes of one obstacle each; a peak is as wide as the map."""
    found = {}
    for name, (kind, levels, softness) in _KINDS.items():
        ends = ((0, 0), (10 * chunks - 1, 10 * chunks - 1)) if kind == "peak" else (None, None)
        obstacle = KINDS[kind](levels=levels, softness=softness)
        placed = replace(obstacle, first=ends[0], last=ends[1])
        found[name] = Recipe(seed=5, boundary="none", chunks=(chunks, chunks), obstacles=(placed,))
    return found


def _row(name: str, recipe: Recipe) -> str:
    whole = build(recipe)
    eased = [build(replace(recipe, difficulty=share)) for share in SHARES]
    full = steps(whole).rms or 1.0
    off = [abs((steps(field).rms or 0.0) / full - share) for share, field in zip(SHARES, eased, strict=True)]
    apart = max(_apart(whole.blocks, field.blocks) for field in eased)
    chance = max(_apart(whole.blocks, _by_chance(recipe, share)) for share in SHARES[:-1])
    n_x, n_y = whole.blocks.shape
    figures = f"{full * 100:.2f} | {max(off):.3f} | {np.mean(off):.3f} | {apart:.0%} | {chance:.0%}"
    return f"| {name} | {n_x} x {n_y} | {figures} |".replace("%", " %")


def _apart(whole: Levels, eased: Levels) -> float:
    """The share of neighbours that were of one level, or one higher than the other, and are now the other way."""
    spoilt, pairs = 0, 0
    for axis in (0, 1):
        before, after = (np.sign(np.diff(levels, axis=axis)) for levels in (whole, eased))
        spoilt += int(((after != 0) & (after != before)).sum())
        pairs += before.size
    return spoilt / pairs


def _by_chance(recipe: Recipe, share: float) -> Levels:
    """The blocks where each is rounded by a number of its own, as likely up as its rest says."""
    whole = build(replace(recipe, boundary="none")).levels
    drawn = generator(recipe.seed, 0, "by chance").random(whole.shape)
    measure = partial(roughness, parts=parts_of(whole.shape, recipe))
    found: Levels = nearest_field(partial(scaled, whole, drawn), measure, measure(whole), share, 40)
    return found
