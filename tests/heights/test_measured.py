"""Measured heights: rounded and resampled, with holes filled on request; refused if they are no blocks."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.figure import Figure
from PIL import Image

from rsegen import Matrix, Random, Recipe, build, compose, imported
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError
from rsegen.heights import pictures
from rsegen.heights.array import Saved
from rsegen.heights.base import filled, heights_in
from rsegen.heights.image import Picture
from rsegen.heights.measured import sampled
from rsegen.heights.table import Table

LEVELS = np.random.default_rng(1).integers(0, 5, (10, 8))
NOISE = np.random.default_rng(2).normal(0, 1, LEVELS.shape).clip(-3, 3)


def table(folder: Path, heights: np.ndarray, name: str = "heights.csv") -> Path:
    """As a person types it: north up, a blank for nan."""
    rows = (",".join("" if np.isnan(height) else f"{height:.2f}" for height in row) for row in heights.T[::-1])
    (folder / name).write_text("\n".join(rows), "utf-8")
    return folder / name


def test_measured_heights_are_rounded_and_the_residual_is_reported(tmp_path: Path) -> None:
    heights = heights_in(table(tmp_path, LEVELS * 10 + np.abs(NOISE)), Table(rounded=True))
    assert (heights.levels == LEVELS).all()
    assert heights.rounding is not None
    assert heights.rounding.mean_cm == pytest.approx(np.abs(NOISE).mean(), abs=0.01)
    assert heights.rounding.largest_cm == pytest.approx(np.abs(NOISE).max(), abs=0.01)
    x, y = heights.rounding.cell
    assert abs(NOISE[x, y]) == np.abs(NOISE).max()
    assert str(heights.rounding).startswith(f"rounded by {np.abs(NOISE).mean():.2g} cm on average, by ")


@pytest.mark.parametrize("values", ["cm", "mm", "m", "in", "ft"])
def test_heights_may_have_any_given_unit(values: str, tmp_path: Path) -> None:
    factor = {"cm": 1, "mm": 0.1, "m": 100, "in": 2.54, "ft": 30.48}[values]
    np.save(tmp_path / "heights.npy", LEVELS * 8.89 / factor)
    assert (build(imported(tmp_path / "heights.npy", Saved(values=values), 8.89)).levels == LEVELS).all()


@pytest.mark.parametrize("rounded", [True, False])
@pytest.mark.parametrize(
    ("heights", "said"),
    [
        (LEVELS * 5, "whole multiples of 5: set values cm and unit_cm 5, or values in and unit_cm 12.7"),
        (LEVELS * 3.5, "whole multiples of 3.5: set values cm and unit_cm 3.5, or values in and unit_cm 8.89"),
        (np.where(LEVELS, LEVELS * 10 + 5, 0), "whole multiples of 5: set values cm and unit_cm 5, or"),
        (LEVELS * 10 + 35, "whole units above 35 cm: set datum_cm 35 if that is the ground"),
        (LEVELS * 1.0, "whole multiples of 1: set values levels, or values cm and unit_cm 1, "),
        (LEVELS * 0.1, "values m and unit_cm 10"),
        (np.random.default_rng(3).random((10, 8)) * 50, "set another unit_cm, other values"),
    ],
    ids=["half-cubic", "inches", "on the ground", "datum", "levels", "metres", "no blocks"],
)
def test_heights_that_no_block_has_are_refused_with_the_possible_ones(
    heights: np.ndarray, said: str, rounded: bool, tmp_path: Path
) -> None:
    with pytest.raises(FileError, match=r"heights\.csv: ") as refused:
        imported(table(tmp_path, heights), Table(rounded=rounded))
    assert said in str(refused.value)
    levels = build(imported(tmp_path / "heights.csv", Table(any_heights=True))).levels
    assert (levels == np.floor(heights / 10 + 0.5)).all()


def test_the_advised_options_read_measured_heights(tmp_path: Path) -> None:
    noisy = NOISE / 4
    assert (
        build(imported(table(tmp_path, LEVELS * 3.5 + noisy.clip(0)), Table(rounded=True), 3.5)).levels == LEVELS
    ).all()
    above = table(tmp_path, LEVELS * 10 + 35 + noisy)
    assert (build(imported(above, Table(rounded=True, datum_cm=35))).levels == LEVELS).all()


@pytest.mark.parametrize(
    ("lowest", "highest", "said"),
    [
        (-474.2, 921.0, "heights are -475 to 921 cm: set datum_cm -475 if the lowest is the ground"),
        (
            1_660_00.5,
            5_000_00,
            "heights are 166000 to 500000 cm: set datum_cm 166000 if the lowest is the ground, and unit",
        ),
        (
            -999_900,
            170,
            "heights are -999900 to 170 cm: set other values (cm, m, in, ...), or write into the file which",
        ),
    ],
    ids=["below 0", "high ground", "no data"],
)
def test_ground_below_0_or_too_high_is_refused_with_the_datum_that_reads_it(
    lowest: float, highest: float, said: str, tmp_path: Path
) -> None:
    path = table(tmp_path, np.linspace(lowest, highest, 12).reshape(3, 4))
    with pytest.raises(FileError) as refused:
        imported(path, Table(any_heights=True))
    assert said in str(refused.value)
    advised = dict(re.findall(r"(datum_cm|unit_cm) (-?\d+)", str(refused.value)))
    if advised:
        reading = Table(any_heights=True, datum_cm=float(advised["datum_cm"]))
        levels = build(imported(path, reading, float(advised.get("unit_cm", 10)))).levels
        assert levels.min() == 0
        assert levels.max() == round((highest - int(advised["datum_cm"])) / int(advised.get("unit_cm", 10)))


@given(st.integers(0, 3), st.integers(1, 4), arrays(np.int64, (3, 2), elements=st.integers(0, 9)))
def test_a_finer_table_has_the_heights_of_its_blocks(quarters: int, finer: int, levels: np.ndarray) -> None:
    """Sampled from a table that is turned and several times as fine, the blocks are those of the table that is not."""
    file = np.kron(np.rot90(levels, quarters), np.ones((finer, finer)))
    reading = Saved(size=levels.shape, rotation=90 * quarters)
    assert (reading._resampled(file) == levels).all()
    if finer == 1:
        assert (Saved(rotation=90 * quarters)._resampled(file) == levels).all()


def test_a_map_that_is_turned_and_shifted_in_a_fine_table_is_found(tmp_path: Path) -> None:
    """A table of cells of 1 cm in which a pallet of blocks of 10 cm stands 20 degrees askew."""
    angle, corner = np.radians(20), np.array([60.0, 25.0])
    x, y = np.indices((200, 200)) + 0.5
    u = (x - corner[0]) * np.cos(angle) + (y - corner[1]) * np.sin(angle)
    v = -(x - corner[0]) * np.sin(angle) + (y - corner[1]) * np.cos(angle)
    i, j = (np.floor(each / 10).astype(int) for each in (u, v))
    inside = (i >= 0) & (i < 10) & (j >= 0) & (j < 8)
    np.save(tmp_path / "fine.npy", np.where(inside, LEVELS[i.clip(0, 9), j.clip(0, 7)] * 10, 0))
    reading = Saved(size=(10, 8), cells_per_block=10, origin=(60, 25), rotation=20)
    assert (build(imported(tmp_path / "fine.npy", reading)).levels == LEVELS).all()
    with pytest.raises(ParameterError, match=r"size: missing; .* need the number of blocks"):
        imported(tmp_path / "fine.npy", Saved(rotation=20))


def test_with_an_origin_or_a_turn_alone_a_cell_of_the_file_is_a_block(tmp_path: Path) -> None:
    np.save(tmp_path / "cells.npy", LEVELS * 10)
    shifted = imported(tmp_path / "cells.npy", Saved(size=(4, 3), origin=(5, 2)))
    assert (build(shifted).levels == LEVELS[5:9, 2:5]).all()
    turned = imported(tmp_path / "cells.npy", Saved(size=(4, 2), rotation=0.001))  # in the middle of the file
    assert (build(turned).levels == LEVELS[3:7, 3:5]).all()


def test_blocks_outside_the_file_are_holes() -> None:
    found = sampled(np.ones((4, 4)), (3, 1), (2, 2), (0.0, 0.0), 0.0)
    assert np.isnan(found).tolist() == [[False], [False], [True]]


def test_holes_are_filled_on_request_and_listed_apart(tmp_path: Path) -> None:
    heights = LEVELS * 10.0
    heights[2:4, 3] = np.nan
    path = table(tmp_path, heights)
    with pytest.raises(FileError, match="line 5, column 3: is blank: fill_holes gives it the height of its neighbours"):
        imported(path, Table())
    recipe = imported(path, Table(fill_holes=True))
    levels = build(recipe).levels
    assert (levels[~np.isnan(heights)] == LEVELS[~np.isnan(heights)]).all()
    assert [each.key for each in recipe.obstacles] == ["heights", "filled-holes"]
    apart = recipe.obstacles[1]
    assert isinstance(apart, Matrix)
    assert np.argwhere(apart.cell_levels() >= 0).tolist() == [[2, 3], [3, 3]]
    assert str(heights_in(path, Table(fill_holes=True)).rounding) == "2 holes filled from the neighbours"


def test_a_hole_has_the_lower_median_of_its_neighbours() -> None:
    heights = np.array([[0.0, 10, 20], [30, 99, 30], [30, 30, 20]])
    assert filled(heights, heights == 99)[1, 1] == 20
    wide = np.full((5, 5), 7.0)
    assert (filled(wide, np.pad(np.ones((3, 3), dtype=bool), 1)) == wide).all()


def test_more_holes_than_heights_are_refused(tmp_path: Path) -> None:
    heights = np.where(np.arange(80).reshape(10, 8) % 8 < 5, np.nan, 10.0)
    with pytest.raises(FileError, match="50 of 80 cells are holes; at most half are filled"):
        imported(table(tmp_path, heights), Table(fill_holes=True))


def test_a_depth_image_is_read_below_its_camera(tmp_path: Path) -> None:
    depths = np.kron(1500 - LEVELS.T[::-1] * 100, np.ones((6, 6))).astype(np.uint16)
    depths[10:14, 20:22] = 0
    Image.fromarray(depths).save(tmp_path / "depth.png")
    reading = Picture(values="depth", camera_cm=150, size=(10, 8))
    assert (build(imported(tmp_path / "depth.png", reading)).levels == LEVELS).all()
    Image.fromarray((LEVELS.T[::-1] * 100).astype(np.uint16)).save(tmp_path / "heights.png")
    assert (build(imported(tmp_path / "heights.png", Picture(values="mm"))).levels == LEVELS).all()


def test_a_depth_image_needs_its_camera_and_16_bits(tmp_path: Path) -> None:
    for values in ({"values": "depth"}, {"camera_cm": 100}):
        with pytest.raises(ParameterError, match="camera_cm: the height of the camera is needed with values: depth"):
            Picture(**values)
    with pytest.raises(ParameterError, match="datum_cm: is for heights and depths"):
        Picture(datum_cm=3)
    Image.fromarray(np.zeros((2, 2), dtype=np.uint8)).save(tmp_path / "grey.png")
    with pytest.raises(FileError, match=r"grey\.png: L pixels; heights and depths need a greyscale image of 16 bits"):
        imported(tmp_path / "grey.png", Picture(values="mm"))


def test_the_command_says_and_draws_how_far_it_rounded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = LEVELS * 10 + NOISE.clip(0)
    heights[0, 0] = np.nan
    path, picture = table(tmp_path, heights), tmp_path / "errors.png"
    words = ["import", str(path), "-o", str(tmp_path / "out"), "--rounded", "--fill-holes", "--errors", str(picture)]
    assert main(words) == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("; 1 hole filled from the neighbours")
    with Image.open(picture) as drawn:
        carried = json.loads(drawn.info["Description"])
        assert drawn.width == 800
    assert [each["key"] for each in carried["obstacles"]] == ["heights", "filled-holes"]
    assert main([*words, "--force"]) == 0
    assert main([*words[:3], str(tmp_path / "other"), *words[4:]]) == 2
    assert "errors.png" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()


def test_the_picture_of_rounding_counts_cells_and_its_colours_end_at_half_a_unit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(pictures, "figure_bytes", lambda figure, *_: figures.append(figure))
    scene = compose(Recipe(seed=1, chunk_size=4, boundary="none", obstacles=(Random(levels=3),)))
    pictures.rounding_plot(scene, np.zeros((4, 4)), np.zeros((4, 4), dtype=bool))
    axes = figures[0].axes[0]
    for axis in (axes.xaxis, axes.yaxis):
        assert all(tick.is_integer() for tick in axis.get_majorticklocs())
    assert axes.images[0].get_clim() == (-5, 5)  # cm


def test_the_first_wrong_height_is_the_first_in_reading_order(tmp_path: Path) -> None:
    """Row by row from the top, not column by column."""
    (tmp_path / "heights.csv").write_text("10,20,13\n14,20,30\n")
    with pytest.raises(FileError, match=r"row 1 from the top, column 3: 13 cm is not .* \(1 more such cell\)"):
        imported(tmp_path / "heights.csv")
