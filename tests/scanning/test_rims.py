"""A rim of blocks of one level looks like a frame: on a deck it is none, and what is assumed is said."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen.cli.edge import main
from rsegen.field.stepfield import Ints, StepField
from rsegen.recipe.examples import EXAMPLES
from tests.support.long import long_unless


def stl(field: StepField, folder: Path) -> Path:
    mesh = rsegen.mesh(field, "merged")
    trimesh.Trimesh(mesh.vertices, mesh.triangles).export(folder / "map.stl")
    return folder / "map.stl"


def example() -> StepField:
    recipe = rsegen.load(EXAMPLES["stairs-and-stones"])
    return rsegen.build(recipe, recipe.first_map)


def of_levels(levels: Ints, boundary: str = "none") -> StepField:
    matrix = rsegen.Matrix.of(levels)
    size = max(levels.shape)
    assert levels.shape == (size, size)
    return rsegen.build(rsegen.Recipe(chunk_size=size, boundary=boundary, unit_cm=10, obstacles=[matrix]))


def deck_with_holes() -> StepField:
    """Holes and towers in a deck of 3 units, none of them at its rim nor beside it."""
    levels = np.full((12, 12), 3)
    levels[2:10, 2:10] = np.random.default_rng(4).integers(0, 6, (8, 8))
    return of_levels(levels)


def deck_with_pits() -> StepField:
    """A deck of one unit in which every other block is missing, but near the rim."""
    levels = np.ones((11, 11), int)
    levels[2:9:2, 2:9] = 0
    levels[5, 5] = 4
    return of_levels(levels)


def two_decks() -> StepField:
    """Two squares of stairs on a deck, side by side: each has a rim of its own."""
    stairs = [rsegen.Stairs(levels=4, first=(2 + x, 2), last=(8 + x, 8)) for x in (0, 11)]
    return rsegen.build(
        rsegen.Recipe(chunk_size=11, chunks=(2, 1), boundary="none", unit_cm=5, ground_level=4, obstacles=stairs)
    )


DECKS: Mapping[str, Callable[[], StepField]] = {
    "example": example,
    "holes": deck_with_holes,
    "pits": deck_with_pits,
    "two": two_decks,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", long_unless("example".__ne__, DECKS, reason="smaller decks are in make test"))
def test_the_rim_of_a_deck_is_no_frame(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    field = DECKS[name]()
    if name != "example":  # which has 1,764 blocks
        request.getfixturevalue("few_points")
    rim = np.unique(np.concatenate([field.levels[[0, -1]].ravel(), field.levels[:, [0, -1]].ravel()]))
    assert len(rim) == 1
    assert rim[0] > 0
    scan = rsegen.scan(stl(field, tmp_path)).scan
    assert scan.boundary == "none"
    assert any(np.array_equal(np.rot90(scan.levels, turns), field.levels) for turns in range(4))


def framed() -> StepField:
    """Random blocks of 0 to 3 units in a frame of one unit."""
    return of_levels(np.random.default_rng(8).integers(0, 4, (8, 8)), "outer")


def half_a_deck() -> StepField:
    """Blocks in a frame, most of which are as high as it beside it."""
    levels = np.random.default_rng(8).integers(0, 4, (8, 8))
    levels[:, [0, -1]] = 1
    levels[0, :5] = 1
    return of_levels(levels, "outer")


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize(
    ("make", "said"),
    [
        (framed, ""),
        (half_a_deck, "assumed: frames, though many blocks next to them are 10 cm high too"),
        (deck_with_holes, "assumed: no frames, as most blocks next to the rim are 30 cm high too"),
    ],
)
def test_a_scan_says_what_it_assumes_of_a_rim(
    make: Callable[[], StepField], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    field = make()
    assert main(["scan", str(stl(field, tmp_path)), "-o", str(tmp_path / "out")]) == 0
    printed = "".join(capsys.readouterr())
    lines = [line for line in printed.splitlines() if "frames, " in line and "assumed" in line]
    assert len(lines) == bool(said)
    assert all(said in line for line in lines)


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
def test_a_rim_is_a_frame_if_one_is_wanted(tmp_path: Path) -> None:
    file = stl(deck_with_holes(), tmp_path)
    scan = rsegen.scan(file, rsegen.ScanOptions(boundary="outer")).scan
    assert scan.boundary == "outer"
    assert scan.frame_height == pytest.approx(0.3)
    assert rsegen.scan(file, rsegen.ScanOptions(size=(10, 10))).scan.boundary == "outer"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("peak", "said"),
    [(True, "those at the sides are lower than the others (--size if there are some)"), (False, "")],
)
def test_a_scan_says_that_a_peak_may_go_on_at_level_0(
    peak: bool, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its rim looks like floor, and as nothing tells them apart, only 8 x 8 of 10 x 10 blocks are found."""
    i, j = np.indices((10, 10))
    rising, rng = np.minimum(np.minimum(i, 9 - i), np.minimum(j, 9 - j)), np.random.default_rng(1)
    levels = rising + (rising > 0) * rng.integers(0, 2, (10, 10)) if peak else rng.integers(0, 4, (10, 10))
    heights = 0.1 * np.pad(levels, 4)
    x, y = rng.uniform(0, 1.75, (2, 40_000))
    z = heights[(x * 10).astype(int), (y * 10).astype(int)] + rng.normal(0, 0.003, x.shape)
    np.savetxt(tmp_path / "peak.xyz", np.column_stack([x, y, z]), fmt="%.4f")
    assert main(["scan", str(tmp_path / "peak.xyz"), "-o", str(tmp_path / "out")]) == 0
    lines = [line for line in "".join(capsys.readouterr()).splitlines() if "are the whole field" in line]
    assert len(lines) == bool(said)
    assert all(said in line for line in lines)
