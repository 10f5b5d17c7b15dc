"""Terrain in floating-point numbers, and occupancy maps with other modes, transparent parts and spellings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from rsegen.errors import FileError, ParameterError
from rsegen.field.stepfield import Array
from rsegen.heights.base import heights_in, importer_for
from rsegen.heights.image import OccupancyImage, Picture
from rsegen.heights.table import Table

SLOPE = 300.0 + 2 * np.arange(12).reshape(3, 4)  # metres, the top row first
LEVELS = np.arange(12).reshape(3, 4)[::-1].T


def image(path: Path, pixels: Array, no_data: str | None = None) -> Path:
    tags: Any = ImageFileDirectory_v2()
    if no_data is not None:
        tags[42113] = no_data
    Image.fromarray(pixels).save(path, tiffinfo=tags)
    return path


@pytest.mark.parametrize(
    ("dtype", "factor", "values"),
    [("f4", 1, "m"), ("f4", 100, "cm"), ("i4", 1000, "mm"), ("i4", 1, "m"), ("u2", 100, "cm")],
)
def test_heights_of_terrain_are_read_in_their_unit(tmp_path: Path, dtype: str, factor: int, values: str) -> None:
    file = image(tmp_path / "a.tif", (SLOPE * factor).astype(dtype))
    heights = Picture(values=values, datum_cm=30_000).read(file, 200)
    np.testing.assert_array_equal(heights.levels, LEVELS)


@pytest.mark.parametrize(("low", "high"), [(300, 480), (3, 4.8), (-0.5, 0.5)])
def test_floating_point_numbers_have_no_white(tmp_path: Path, low: float, high: float) -> None:
    file = image(tmp_path / "a.tif", np.array([[low, high]], dtype="f4"))
    with pytest.raises(
        FileError, match=rf"a.tif: floating-point numbers of {low:g}..{high:g} have no white; set values m"
    ):
        Picture().read(file, None)


def test_numbers_below_0_are_heights_alone(tmp_path: Path) -> None:
    file = image(tmp_path / "a.tif", np.array([[-200, -20]], dtype="i4"))
    with pytest.raises(FileError, match=r"grey values of -200..-20; use an image of 8 or 16 bits, or set values m"):
        Picture().read(file, None)
    assert Picture(values="cm", datum_cm=-200).read(file, 10).levels.ravel().tolist() == [0, 18]


def test_pixels_without_data_are_holes(tmp_path: Path) -> None:
    pixels = SLOPE.astype("f4")
    pixels[1, 1] = -9999
    named, unnamed = image(tmp_path / "a.tif", pixels, "-9999"), image(tmp_path / "b.tif", pixels)
    with pytest.raises(FileError, match="nan cm is a hole"):
        Picture(values="m", datum_cm=30_000).read(named, 200)
    heights = Picture(values="m", datum_cm=30_000, fill_holes=True).read(named, 200)
    assert heights.holes is not None
    assert np.argwhere(heights.holes).tolist() == [[1, 1]]
    with pytest.raises(FileError, match=r"is not 0\.\.32766 whole units"):
        Picture(values="m", datum_cm=30_000, fill_holes=True).read(unnamed, 200)


@pytest.mark.parametrize(("dtype", "none"), [("u1", 255), ("u1", 0), ("u2", 65535), ("u2", 7)])
def test_grey_pixels_without_data_are_unknown(tmp_path: Path, dtype: str, none: int) -> None:
    pixels = np.array([[none, 40, none]], dtype=dtype)
    assert Picture().read(image(tmp_path / "a.tif", pixels, str(none)), None).levels.ravel().tolist() == [
        -1,
        1 if dtype == "u1" else 0,
        -1,
    ]
    assert -1 not in Picture().read(image(tmp_path / "b.tif", pixels), None).levels


def test_coloured_pixels_without_data_are_those_of_which_no_band_has_any(tmp_path: Path) -> None:
    pixels = np.array([[(255, 255, 255), (255, 255, 0), (0, 0, 0)]], dtype="u1")
    assert Picture().read(image(tmp_path / "a.tif", pixels, "255"), None).levels.ravel().tolist() == [-1, 4, 0]


def test_transparent_pixels_are_unknown_whether_or_not_others_have_no_data(tmp_path: Path) -> None:
    pixels = np.array([[(9, 9, 9, 0), (255, 255, 255, 255)]], dtype="u1")
    for no_data in (None, "7"):
        file = image(tmp_path / "a.tif", pixels, no_data)
        assert Picture().read(file, None).levels.ravel().tolist() == [-1, 4]


MAP = "image: m.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: {}\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{}"


def walls(folder: Path, pixels: Array, negate: str = "0", mode: str = "", *, unknown: bool = False) -> list[int]:
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / "m.png")
    (folder / "m.yaml").write_text(MAP.format(negate, f"mode: {mode}\n" if mode else ""))
    levels: list[int] = OccupancyImage(unknown=unknown).read(folder / "m.yaml", None).levels.ravel().tolist()
    return levels


@pytest.mark.parametrize(("unknown", "wanted"), [(False, [0, 0, 1, 1, 0, 0]), (True, [0, 0, 1, 1, 1, 1])])
def test_pixels_of_a_raw_map_are_per_cent(tmp_path: Path, unknown: bool, wanted: list[int]) -> None:
    assert walls(tmp_path, np.array([[0, 60, 70, 100, 101, 255]]), mode="raw", unknown=unknown) == wanted


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
def test_transparent_pixels_are_unknown(tmp_path: Path, mode: str) -> None:
    full, free = (100, 0) if mode == "raw" else (0, 254)
    pixels = np.array([[[full] * 3 + [255], [full] * 3 + [0], [free] * 3 + [255], [free] * 3 + [0]]])
    assert walls(tmp_path, pixels, mode=mode) == [1, 0, 0, 0]
    assert walls(tmp_path, pixels, mode=mode, unknown=True) == [1, 1, 0, 1]


def test_in_a_scaled_map_nothing_between_the_thresholds_is_unknown(tmp_path: Path) -> None:
    pixels = np.array([[0, 128, 254]])
    assert walls(tmp_path, pixels, mode="scale", unknown=True) == [1, 0, 0]
    assert walls(tmp_path, pixels, mode="trinary", unknown=True) == [1, 1, 0]


@pytest.mark.parametrize(
    ("negate", "wanted"), [("false", [1, 0]), ("no", [1, 0]), ("0", [1, 0]), ("true", [0, 1]), ("1", [0, 1])]
)
def test_negate_is_written_as_yaml_has_it(tmp_path: Path, negate: str, wanted: list[int]) -> None:
    assert walls(tmp_path, np.array([[0, 254]]), negate) == wanted


@pytest.mark.parametrize(("negate", "mode"), [("maybe", ""), ("2", ""), ("0", "grey")])
def test_other_values_are_one_line(tmp_path: Path, negate: str, mode: str) -> None:
    with pytest.raises((FileError, ParameterError), match=r"m\.yaml: (negate|mode)"):
        walls(tmp_path, np.array([[0, 254]]), negate, mode)


GRID = "ncols 4\nnrows 3\nxllcorner 5e5\nyllcorner 4.2e6\ncellsize 10\nNODATA_value -9999\n"


@pytest.mark.parametrize("separator", ["\n", " "], ids=["a row on a line", "all on one line"])
def test_a_grid_of_esri_is_read_in_the_unit_that_is_given(tmp_path: Path, separator: str) -> None:
    rows = [" ".join(f"{height:.3f}" for height in row) for row in SLOPE]
    path = tmp_path / "ground.asc"
    path.write_text(GRID + separator.join(rows), "utf-8")
    reading = Table(values="m", datum_cm=30000)
    assert (heights_in(path, reading, 200).levels == LEVELS).all()
    path.write_text(GRID.upper() + separator.join(rows).replace("302.000", "-9999"), "utf-8")
    with pytest.raises(FileError, match=r"row 1 from the top, column 2: nan cm is a hole; fill_holes"):
        heights_in(path, reading, 200)
    with pytest.raises(ParameterError, match=r"values: .*ground.asc is a grid that does not say its unit; set m, cm"):
        heights_in(path, Table(), 200)


def test_a_grid_of_esri_without_a_number_for_no_data_has_that_of_its_definition(tmp_path: Path) -> None:
    path = tmp_path / "ground.asc"
    path.write_text("nrows 2\nncols 3\ncellsize 10\n0 10 -9999\n20 0 30\n", "utf-8")
    read = heights_in(path, Table(values="cm", fill_holes=True), 10)
    assert read.holes is not None
    assert np.argwhere(read.holes).tolist() == [[2, 1]]
    assert read.levels.tolist() == [[2, 0], [0, 1], [3, 1]]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (GRID + "1 2 3", "3 numbers; 4 x 3 cells have 12"),
        (GRID + "1 2 3 x", "'x'"),
        (GRID.replace("ncols 4", "ncols 99999999") + "1", "99999999 x 3 cells; from 1 up to"),
        ("ncols 4\n1 2 3 4", "no line nrows"),
        ("nrows 4\n1 2 3 4", "no line ncols"),
    ],
)
def test_a_damaged_grid_of_esri_is_one_line(tmp_path: Path, content: str, said: str) -> None:
    path = tmp_path / "ground.asc"
    path.write_text(content, "utf-8")
    with pytest.raises(FileError, match=r"ground\.asc: ") as refused:
        heights_in(path, Table(values="m"), 10)
    assert said in str(refused.value)


@pytest.mark.parametrize("name", ["N46E007.hgt", "ground.dem", "ground.nc"])
def test_ground_that_gdal_reads_says_how_to_make_an_image_of_it(name: str) -> None:
    with pytest.raises(FileError, match=f"{name}: write it as GeoTIFF with `gdal_translate "):
        importer_for(Path(name))


def test_an_image_of_a_map_that_lies_beside_it_is_named(tmp_path: Path) -> None:
    """As in maps that were saved on another machine, with the path there."""
    Image.new("L", (2, 2)).save(tmp_path / "hall.pgm")
    path = tmp_path / "hall.yaml"
    path.write_text("image: /home/someone/maps/hall.pgm\nresolution: 0.05\n", "utf-8")
    with pytest.raises(FileError, match=r"image: /home/.* does not exist; set it to hall.pgm, which is in this folder"):
        heights_in(path, OccupancyImage())


def test_an_ending_of_gdal_is_read_by_a_plug_in_that_knows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FileError, match=r"ground\.dem: write it as GeoTIFF"):
        importer_for(Path("ground.dem"))
    monkeypatch.setattr("rsegen.heights.base.IMPORTERS", {".dem": Table})
    assert importer_for(Path("ground.dem")) is Table


def test_the_colours_of_a_map_count_alike(tmp_path: Path) -> None:
    pure = np.diag([255, 255, 255])  # red, green and blue, as bright to map_server as a grey of 85
    assert walls(tmp_path, pure[None]) == walls(tmp_path, np.array([[85, 85, 85]])) == [1, 1, 1]
