"""Heights from elsewhere become the levels that they are, or are refused with their place."""

from __future__ import annotations

import struct
import zlib
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from rsegen import Matrix, Recipe, build, generate, imported
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.heights.array import Saved
from rsegen.heights.base import IMPORTERS, importer_for
from rsegen.heights.image import OccupancyImage, Picture, brightness
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


def test_the_end_of_a_name_says_how_a_file_is_read(tmp_path: Path) -> None:
    np.save(tmp_path / "heights.npy", np.array([[0, 10], [20, 0]]))
    path, reading = tmp_path / "heights.npy", Saved()
    assert imported(str(path)) == imported(path, reading)
    assert imported(str(path), unit_cm=5) == imported(path, reading, 5)
    for wrong in ("csv", Saved):
        with pytest.raises(ParameterError, match=r"reading: .* is not an Importer of rsegen\.heights\.base"):
            imported(path, wrong)  # type: ignore[arg-type]  # what is tested
    with pytest.raises(ParameterError, match="path: 3 is not a path"):
        imported(3)  # type: ignore[arg-type]  # what is tested


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
    with pytest.raises(FileError, match=r"heights\.xlsx: heights are read from files named \*\.asc, \*\.bag, "):
        importer_for(Path("heights.xlsx"))


def test_the_folder_of_a_bag_is_refused_with_the_file_to_use(tmp_path: Path) -> None:
    for name in ("metadata.yaml", "walk_0.mcap"):
        (tmp_path / name).touch()
    with pytest.raises(FileError, match=r"a folder; use a file in it, such as .*walk_0\.mcap"):
        importer_for(tmp_path)


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


ODD_ARRAYS = [np.zeros(3), np.array([["a"]]), np.zeros((2, 2), dtype=complex), np.zeros((0, 2)), np.zeros((4, 3, 1))]


@pytest.mark.parametrize("array", ODD_ARRAYS)
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


def rows_in(recipe: Recipe) -> list[list[str]]:
    """The words of the matrix of an imported map, the upper row first."""
    (matrix,) = recipe.obstacles
    assert isinstance(matrix, Matrix)
    return [row.split() for row in matrix.rows]


@pytest.mark.parametrize("invert", [False, True])
def test_colours_count_by_brightness_and_transparent_parts_are_unknown(tmp_path: Path, invert: bool) -> None:
    """As (red, green, blue, opacity): white, clear white, black, clear black, half clear white, mostly clear white."""
    pixels = [(255, 255, 255, 255), (255, 255, 255, 0), (0, 0, 0, 255), (0, 0, 0, 0), (255,) * 3 + (128,)]
    colours = np.array([[*pixels, (255, 255, 255, 127)]], dtype=np.uint8)
    recipe = imported(drawn(tmp_path, colours), Picture(levels=5, invert=invert))
    white, black = ("0", "4") if invert else ("4", "0")
    assert rows_in(recipe) == [[white, ".", black, ".", white, "."]]
    assert levels_of(recipe).ravel().tolist() == [int(white), 0, int(black), 0, int(white), 0]


def saved_with_clear(folder: Path, mode: str) -> Path:
    """An image of two pixels, white and clear, in a mode of its own."""
    path = folder / f"{mode.replace(';', '')}.png"
    if mode == "P":
        image = Image.new("P", (2, 1))
        image.putpalette([255, 255, 255, 0, 0, 0])
        image.putdata([0, 1])
        image.save(path, transparency=1)
    elif mode == "LA":
        Image.fromarray(np.array([[[255, 255], [255, 0]]], dtype=np.uint8), "LA").save(path)
    elif mode == "I;16":
        Image.fromarray(np.array([[65535, 7]], dtype=np.uint16)).save(path, transparency=7)
    else:
        Image.fromarray(np.array([[255, 7]], dtype=np.uint8)).save(path, transparency=7)
    return path


@pytest.mark.parametrize("mode", ["P", "LA", "L", "I;16"])
@pytest.mark.parametrize("options", [{}, {"threshold": 50.0}, {"size": (2, 1)}, {"size": (4, 3)}])
def test_what_is_clear_in_images_of_every_mode_is_unknown(tmp_path: Path, mode: str, options: dict[str, Any]) -> None:
    found = rows_in(imported(saved_with_clear(tmp_path, mode), Picture(levels=3, invert=mode == "L", **options)))
    half = len(found[0]) // 2
    white = "0" if mode == "L" else "2"
    assert found == [[white] * half + ["."] * half] * len(found)


def test_the_opaque_part_of_a_cell_counts(tmp_path: Path) -> None:
    grey, clear = (128, 128, 128, 255), (255, 255, 255, 0)
    colours = np.array([[grey, grey, clear, grey, clear, clear]], dtype=np.uint8)
    assert rows_in(imported(drawn(tmp_path, colours), Picture(levels=3, size=(2, 1)))) == [["1", "."]]


def test_unknown_cells_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    colours = np.array([[(255, 255, 255, 255), (255, 255, 255, 0), (0, 0, 0, 0)]], dtype=np.uint8)
    path = str(drawn(tmp_path, colours))
    assert main(["import", path, "--invert", "-o", str(tmp_path / "out")]) == 0
    assert "2 cells transparent or without data, so unknown: no block stands there\n" in capsys.readouterr().out
    assert main(["import", str(drawn(tmp_path, PICTURE)), "-o", str(tmp_path / "grey")]) == 0
    assert "transparent" not in capsys.readouterr().out


def test_transparent_cells_of_a_map_of_ros_are_neither_free_nor_walls(tmp_path: Path) -> None:
    pixels = [(0, 0, 0, 255), (0, 0, 0, 0), (254, 254, 254, 255), (254, 254, 254, 0)]
    drawn(tmp_path, np.array([pixels], dtype=np.uint8), "map.png")
    path = written(tmp_path, "image: map.png\nresolution: 0.05\n", "map.yaml")
    assert levels_of(imported(path, OccupancyImage())).ravel().tolist() == [1, 0, 0, 0]
    assert levels_of(imported(path, OccupancyImage(unknown=True))).ravel().tolist() == [1, 1, 0, 1]


@pytest.mark.parametrize(
    ("pixels", "size"), [((7, 5), (3, 2)), ((10, 10), (3, 7)), ((4, 6), (9, 4)), ((1, 1), (5, 5)), ((97, 64), (10, 10))]
)
def test_a_size_takes_the_exact_mean_of_areas(tmp_path: Path, pixels: tuple[int, int], size: tuple[int, int]) -> None:
    """Judged by fractions, pixel by pixel with its part of the cell."""
    (n_x, n_y), (m_x, m_y) = pixels, size
    greys = np.random.default_rng(n_x).integers(0, 65536, (n_y, n_x), dtype=np.uint16)
    found = brightness(drawn(tmp_path, greys), size)

    def parts(cell: int, n: int, m: int) -> dict[int, Fraction]:
        """Of each pixel along an axis of n how much of it is in a cell of m."""
        low, high = Fraction(cell * n, m), Fraction((cell + 1) * n, m)
        overlaps = {pixel: min(high, Fraction(pixel + 1)) - max(low, Fraction(pixel)) for pixel in range(n)}
        return {pixel: part for pixel, part in overlaps.items() if part > 0}

    for x, y in product(range(m_x), range(m_y)):
        along = parts(x, n_x, m_x), parts(y, n_y, m_y)
        whole = sum(int(greys[n_y - 1 - j, i]) * along[0][i] * along[1][j] for i, j in product(*along))
        mean = whole / (Fraction(n_x, m_x) * Fraction(n_y, m_y) * 65535)
        assert found[x, y] == pytest.approx(float(mean), abs=1e-15)


def test_a_cell_across_a_pixel_has_its_part_of_it(tmp_path: Path) -> None:
    """Three pixels on two cells: the middle one is half in each, so they are 1 and 1/3 of white."""
    path = drawn(tmp_path, np.array([[65535, 65535, 0]], dtype=np.uint16))
    assert brightness(path, (2, 1)).ravel().tolist() == pytest.approx([1, 1 / 3])
    assert levels_of(imported(path, Picture(levels=4, size=(2, 1)))).ravel().tolist() == [3, 1]
    flat = np.full((3, 3), 21_845, dtype=np.uint16)  # a third of white
    assert (brightness(drawn(tmp_path, flat), (7, 2)) == 1 / 3).all()


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
