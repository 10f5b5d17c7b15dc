"""Heights from elsewhere become the levels that they are, or are refused with their place."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from rsegen import Recipe, build, generate, imported
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.heights.array import Saved
from rsegen.heights.base import IMPORTERS, importer_for
from rsegen.heights.image import OccupancyImage, Picture
from rsegen.heights.table import Table
from rsegen.params.sorts import parameters

FORMAT = pytest.mark.parametrize("suffix", IMPORTERS)
LEVELS = arrays(np.int32, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 30))
PICTURE = np.array([[0, 64, 255], [255, 191, 0]], dtype=np.uint8)
"""As an image has it: two rows of three pixels, the first the upper one."""


def levels_of(recipe: Recipe) -> np.ndarray:
    return build(recipe).levels


def drawn(folder: Path, pixels: np.ndarray, name: str = "grey.png") -> Path:
    Image.fromarray(pixels).save(folder / name)
    return folder / name


def written(folder: Path, text: str, name: str = "heights.csv") -> Path:
    (folder / name).write_text(text, "utf-8")
    return folder / name


@FORMAT
def test_every_format_explains_itself_and_its_options(suffix: str) -> None:
    cls = IMPORTERS[suffix]
    assert (cls.__doc__ or "").splitlines()[0].endswith(".")
    assert all(option.help and option.describe() for option in parameters(cls).values())


@FORMAT
@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff\xfe\x01", b"{}", b"a: [", b"\x89PNG\r\n\x1a\n", b"\x93NUMPY\x01\x00"]
)
def test_an_invalid_file_of_a_format_is_refused_in_one_line(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"strange{suffix}"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"strange") as refused:
        imported(path, IMPORTERS[suffix]())
    assert "\n" not in str(refused.value)


@FORMAT
def test_a_missing_file_and_a_folder_are_refused(suffix: str, tmp_path: Path) -> None:
    for path in (tmp_path / f"none{suffix}", tmp_path / f"folder{suffix}"):
        if path.stem == "folder":
            path.mkdir()
        with pytest.raises(FileError, match=path.name):
            imported(path, IMPORTERS[suffix]())


def test_a_file_of_no_known_format_is_refused_with_the_known_ones() -> None:
    with pytest.raises(FileError, match=r"heights\.xlsx: heights are read from files named \*\.bmp, \*\.csv"):
        importer_for(Path("heights.xlsx"))


@given(levels=LEVELS, unit_cm=st.sampled_from([10, 1, 8.5]))
def test_exported_heights_are_imported_unchanged(
    levels: np.ndarray, unit_cm: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("again")
    np.save(folder / "first.npy", levels)
    first = imported(folder / "first.npy", Saved(values="levels"), unit_cm)
    assert np.array_equal(levels_of(first), levels)
    made = generate(first, folder).maps[0]
    again = imported(made.folder / "levels.csv", Table())
    assert build(again) == build(first)
    assert again.unit_cm == unit_cm


def test_the_top_row_of_a_table_is_the_largest_y(tmp_path: Path) -> None:
    recipe = imported(written(tmp_path, "# a pallet\n0,10,20\n\n30,0,40\n"), Table())
    assert levels_of(recipe).tolist() == [[3, 0], [0, 1], [4, 2]]
    assert (recipe.unit_cm, recipe.boundary, recipe.name) == (10, "none", "heights")


@pytest.mark.parametrize(
    "text", ["0,5,10\n", "0;5;10\n", "0\t5\t10\n", "0 5  10\n", "\ufeff0,5,10\r\n", "0,0;5,0;10,0"]
)
def test_tables_may_be_parted_as_spreadsheets_do_it(text: str, tmp_path: Path) -> None:
    assert levels_of(imported(written(tmp_path, text), Table(), 5)).tolist() == [[0], [1], [2]]


@pytest.mark.parametrize(
    ("text", "reading", "said"),
    [
        ("0,10\n,30\n", Table(), "line 2, column 1: is blank"),
        ("0,x\n,30\n", Table(), r"line 1, column 2: 'x' is not a number \(1 more such cell\)"),
        ("0,10\n20\n", Table(), "line 2: 1 cells, and 2 in line 1"),
        ("0,10\n20,25\n", Table(), "row 2 from the top, column 2: 25 cm is not 0..32766 whole units of 10 cm"),
        ("0,10\n-10,20\n", Table(rounded=True), "row 2 from the top, column 1: -10 cm"),
        ("nan,10\n10,20\n", Table(rounded=True), "row 1 from the top, column 1: nan cm"),
        ("0.5,1\n", Table(values="levels"), "row 1 from the top, column 1: 5 cm"),
        ("# nothing\n", Table(), "0 x 0 cells"),
    ],
)
def test_bad_cells_are_refused_with_their_place(text: str, reading: Table, said: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=rf"heights\.csv: {said}"):
        imported(written(tmp_path, text), reading)


def test_heights_may_be_metres_and_may_be_rounded(tmp_path: Path) -> None:
    path = written(tmp_path, "0.1,0.3,0.26\n")
    assert levels_of(imported(path, Table(values="m", rounded=True))).ravel().tolist() == [1, 3, 3]
    assert levels_of(imported(written(tmp_path, "0.1,0.3,0.7\n"), Table(values="m"))).ravel().tolist() == [1, 3, 7]


@pytest.mark.parametrize("array", [np.zeros(3), np.array([["a"]]), np.zeros((2, 2), dtype=complex), np.zeros((0, 2))])
def test_an_array_without_two_axes_of_numbers_is_refused(array: np.ndarray, tmp_path: Path) -> None:
    np.save(tmp_path / "odd.npy", array)
    with pytest.raises(FileError, match=r"odd\.npy"):
        imported(tmp_path / "odd.npy", Saved())


def test_a_pickle_is_not_opened(tmp_path: Path) -> None:
    np.save(tmp_path / "pickle.npy", np.array([[object()]]), allow_pickle=True)
    with pytest.raises(FileError, match=r"pickle\.npy: not an array of numbers"):
        imported(tmp_path / "pickle.npy", Saved())


def test_white_is_the_highest_and_the_upper_row_the_largest_y(tmp_path: Path) -> None:
    levels = levels_of(imported(drawn(tmp_path, PICTURE), Picture(levels=5)))
    assert levels[:, 1].tolist() == [0, 1, 4]
    assert levels[:, 0].tolist() == [4, 3, 0]
    inverted = levels_of(imported(tmp_path / "grey.png", Picture(levels=5, invert=True)))
    assert (inverted == 4 - levels).all()


@pytest.mark.parametrize("suffix", [".png", ".pgm", ".tif", ".bmp", ".jpg"])
def test_images_of_every_sort_say_the_same(suffix: str, tmp_path: Path) -> None:
    large = np.kron(PICTURE, np.ones((16, 16), dtype=np.uint8))
    found = levels_of(imported(drawn(tmp_path, large, f"grey{suffix}"), Picture(levels=5, size=(3, 2))))
    assert found.tolist() == [[4, 0], [3, 1], [0, 4]]


@given(levels=LEVELS)
def test_levels_painted_in_8_or_16_bits_come_back(levels: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("painted")
    for white, sort in ((255, np.uint8), (65535, np.uint16)):
        pixels = np.floor(levels.T[::-1] * white / 30).astype(sort)
        found = levels_of(imported(drawn(folder, pixels), Picture(levels=31)))
        assert np.array_equal(found, levels)


def test_a_threshold_makes_two_levels(tmp_path: Path) -> None:
    found = levels_of(imported(drawn(tmp_path, PICTURE), Picture(levels=4, threshold=50)))
    assert found.tolist() == [[3, 0], [3, 0], [0, 3]]


def test_colours_count_by_brightness_and_transparent_parts_as_black(tmp_path: Path) -> None:
    colours = np.array([[[255, 255, 255, 255], [255, 255, 255, 0], [0, 0, 0, 255]]], dtype=np.uint8)
    assert levels_of(imported(drawn(tmp_path, colours), Picture(levels=5))).ravel().tolist() == [4, 0, 0]


def test_a_huge_image_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    head = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 0, 0, 0, 0)
    chunk = struct.pack(">I", 13) + b"IHDR" + head + struct.pack(">I", zlib.crc32(b"IHDR" + head))
    (tmp_path / "huge.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk + struct.pack(">I", 9) + b"IDAT")
    with pytest.raises(FileError, match=r"huge\.png: .*(too large|100000 x 100000 cells)"):
        imported(tmp_path / "huge.png", Picture(size=(10, 10)))


def test_an_image_that_breaks_off_is_refused(tmp_path: Path) -> None:
    whole = drawn(tmp_path, np.random.default_rng(1).integers(0, 255, (64, 64), dtype=np.uint8)).read_bytes()
    (tmp_path / "half.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileError, match=r"half\.png: not a whole image"):
        imported(tmp_path / "half.png", Picture())


def test_a_map_of_ros_becomes_walls_of_its_cell_size(tmp_path: Path) -> None:
    drawn(tmp_path, np.array([[0, 205, 254]], dtype=np.uint8), "map.pgm")
    path = written(tmp_path, "image: map.pgm\nresolution: 0.05\norigin: [-1, -1, 0]\nnegate: 0\n", "map.yaml")
    recipe = imported(path, OccupancyImage())
    assert levels_of(recipe).ravel().tolist() == [1, 0, 0]
    assert (recipe.block_width_cm, recipe.unit_cm) == (5, 100)
    path.write_text(path.read_text("utf-8") + "free_thresh: 0.19\n", "utf-8")
    assert levels_of(imported(path, OccupancyImage(unknown=True), 30)).ravel().tolist() == [1, 1, 0]


def test_a_map_of_ros_without_its_image_or_resolution_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"map\.yaml: resolution: "):
        imported(written(tmp_path, "image: map.pgm\n", "map.yaml"), OccupancyImage())
    with pytest.raises(FileError, match=r"map\.pgm: No such file"):
        imported(written(tmp_path, "image: map.pgm\nresolution: 1\n", "map.yaml"), OccupancyImage())


@pytest.mark.parametrize(
    ("cells", "side"), [((20, 30), 10), ((12, 18), 6), ((7, 5), 1), ((1500, 1500), 10), ((1201, 1201), 1)]
)
def test_chunks_are_of_ten_blocks_where_that_divides_the_map(cells: tuple[int, int], side: int, tmp_path: Path) -> None:
    np.save(tmp_path / "flat.npy", np.zeros(cells))
    recipe = imported(tmp_path / "flat.npy", Saved())
    assert recipe.chunk_size == side
    assert recipe.grid.shape == cells


def test_a_chunk_size_that_does_not_divide_the_map_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "flat.npy", np.zeros((20, 30)))
    assert imported(tmp_path / "flat.npy", Saved(), chunk_size=5).chunks == (4, 6)
    with pytest.raises(ParameterError, match="chunk_size: 7 does not divide 20 x 30 cells; 10 does"):
        imported(tmp_path / "flat.npy", Saved(), chunk_size=7)
