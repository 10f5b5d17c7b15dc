"""Kinds of plug-ins give levels of a map, or are refused in a line."""

from __future__ import annotations

import re

import numpy as np
import pytest

from rsegen import Obstacle, Recipe, build, build_many
from rsegen.errors import PluginError
from tests.plugins.installed import module_of

DUNE = '''
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from rsegen import Obstacle
from rsegen.obstacles.base import Layout, Patch, Shaped, elementwise


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(BASE):
    """Sand."""

    kind: ClassVar[str] = "dune"

    def overhang(self, grid):
        return OVERHANG

    MARK
    def METHOD
        return GIVEN
'''
METHODS = {
    "Shaped": "profile(self, x, y, first, last, grid):",
    "Layout": "laid_out(self, shape, drawn):",
    "Obstacle": "patch(self, grid, first, last, rng):",
}


def dune(
    monkeypatch: pytest.MonkeyPatch, given: str, *, base: str = "Shaped", overhang: str = "0.0", mark: str = ""
) -> Recipe:
    """A map with a kind whose method gives this, from the first to the last of ten cells."""
    words = {"BASE": base, "METHOD": METHODS[base], "OVERHANG": overhang, "MARK": mark, "GIVEN": given}
    module = module_of(re.sub("|".join(words), lambda word: words[word[0]], DUNE), monkeypatch)
    obstacle: Obstacle = module.Dune(levels=3, first=(0, 0), last=(9, 9))
    return Recipe(seed=1, boundary="none", obstacles=[obstacle])


def refuse(recipe: Recipe, complaint: str) -> None:
    """Check that a map and many maps are refused alike."""
    with pytest.raises(PluginError, match=re.escape(f"obstacle kind dune: {complaint}")):
        build(recipe)
    with pytest.raises(PluginError, match=re.escape(f"obstacle kind dune: {complaint}")):
        build_many(recipe, range(3))


FLOATS = "expected an array of floats of shape"


@pytest.mark.parametrize("mark", ["", "@elementwise"])
@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ("None", f"profile() gave an empty value; {FLOATS}"),
        ("'sand'", f"profile() gave 'sand'; {FLOATS}"),
        ("np.ones((3, 3))", "profile() gave array(["),
        ("(0 * x + 0 * y).astype(complex)", "profile() gave array("),
        ("0 * x + 0 * y + np.nan", "profile() is not a number (nan) somewhere; use 0 to 1"),
        ("0 * x + 0 * y + np.inf", "profile() makes levels of up to inf; a map has up to 32767"),
        ("0 * x + 0 * y + 32768.0", "profile() makes levels of up to 65536; a map has up to 32767"),
        ("0 * x + 0 * y - 32768.0", "profile() makes levels of up to 65536; a map has up to 32767"),
    ],
)
def test_a_profile_is_an_array_of_numbers_from_0_to_1(
    given: str, complaint: str, mark: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    refuse(dune(monkeypatch, given, mark=mark), complaint)


@pytest.mark.parametrize(("given", "row"), [("1", [2] * 10), ("[[1.0]]", [2] * 10), ("(y > 4) * 1", [0] * 5 + [2] * 5)])
def test_a_profile_is_spread_over_the_cells(given: str, row: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    assert build(dune(monkeypatch, given)).levels.tolist() == [row] * 10


@pytest.mark.parametrize("overhang", ["'wide'", "float('nan')", "float('inf')", "None"])
def test_an_overhang_is_a_number(overhang: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = {"None": "an empty value"}.get(overhang, overhang.removeprefix("float('").removesuffix("')"))
    complaint = f"overhang() gave {given}; expected a number of cells"
    refuse(dune(monkeypatch, "0 * x + 0 * y", overhang=overhang), complaint)


ALL = "np.ones(shape, bool)"


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        (f"np.ones((2, 2), int), {ALL}", "laid_out() must return two arrays of shape (10, 10)"),
        ("np.ones(shape, int), np.ones((2, 2), bool)", "laid_out() must return two arrays of shape (10, 10)"),
        (f"np.full(shape, 65537), {ALL}", "laid_out() makes levels of up to 65537; a map has up to 32767"),
        (f"np.full(shape, np.nan), {ALL}", "laid_out() makes levels of up to nan; a map has up to 32767"),
    ],
)
def test_a_layout_has_the_shape_of_its_rectangle(given: str, complaint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    refuse(dune(monkeypatch, given, base="Layout"), complaint)


WINDOW = "(slice(0, 3), slice(0, 3))"


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ("None", "patch() gave an empty value; expected a rsegen.obstacles.base.Patch"),
        (f"Patch({WINDOW}, [[1] * 3] * 3, np.ones((3, 3), bool))", "levels of list; expected integers"),
        (
            f"Patch({WINDOW}, np.ones((2, 2), int), np.ones((3, 3), bool))",
            "levels and footprint of the shapes (2, 2) and (3, 3); its window has (3, 3)",
        ),
        (
            f"Patch({WINDOW}, np.ones((3, 3), int), np.ones((4, 4), bool))",
            "levels and footprint of the shapes (3, 3) and (4, 4); its window has (3, 3)",
        ),
    ],
)
def test_a_patch_fits_into_its_window(given: str, complaint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    refuse(dune(monkeypatch, given, base="Obstacle"), complaint)


def test_a_patch_that_fits_is_imposed(monkeypatch: pytest.MonkeyPatch) -> None:
    given = f"Patch({WINDOW}, np.full((3, 3), 2), np.eye(3, dtype=bool))"
    levels = build(dune(monkeypatch, given, base="Obstacle")).levels
    assert np.argwhere(levels).tolist() == [[0, 0], [1, 1], [2, 2]]
    assert levels.sum() == 6
