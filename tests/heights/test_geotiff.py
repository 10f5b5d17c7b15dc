"""Tags of images, and what they say of pixels: which way up they are, their heights, and which have no data."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from rsegen.cli.edge import main
from rsegen.errors import FileError
from rsegen.heights.base import heights_in
from rsegen.heights.image import Picture, brightness

ROWS = np.array([[0, 10, 20, 30], [10, 0, 30, 50], [20, 0, 0, 10]], dtype=np.int16)
"""Heights, cm, the northern row first."""

LEVELS = ROWS[::-1].T // 10

NORTH_UP = ((1, 0), (0, -1))
UTM = (1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 32633, 3076, 0, 1, 9001)


def geotiff(path: Path, rows: np.ndarray, tags: Mapping[int, Any]) -> Path:
    own: Any = ImageFileDirectory_v2()
    own.tagtype.update({33550: 12, 33922: 12, 34264: 12, 34735: 3, 42112: 2, 42113: 2})
    for tag, value in tags.items():
        own[tag] = value
    Image.fromarray(rows).save(path, tiffinfo=own)
    return path


def matrix(rows: Sequence[Sequence[float]], sides: tuple[float, float] = (0.25, 0.25)) -> tuple[float, ...]:
    (a, b), (d, e) = (np.array(rows) * sides).tolist()
    return (a, b, 0, 5e5, d, e, 0, 4e6, 0, 0, 0, 0, 0, 0, 0, 1)


@pytest.mark.parametrize(
    ("stored", "places"),
    [
        (ROWS, NORTH_UP),
        (ROWS[::-1], ((1, 0), (0, 1))),
        (ROWS[:, ::-1], ((-1, 0), (0, -1))),
        (ROWS[::-1, ::-1], ((-1, 0), (0, 1))),
        (ROWS.T, ((0, 1), (-1, 0))),
        (np.rot90(ROWS), ((0, -1), (-1, 0))),
        (np.rot90(ROWS, -1), ((0, 1), (1, 0))),
        (ROWS, ((0.9, 0.4), (0.4, -0.9))),
    ],
)
@pytest.mark.parametrize("values", ["cm", "grey"])
def test_north_is_up_whatever_the_order_of_rows_and_columns(
    tmp_path: Path, stored: np.ndarray, places: Sequence[Sequence[float]], values: str
) -> None:
    path = geotiff(tmp_path / "a.tif", np.ascontiguousarray(stored), {34264: matrix(places), 34735: UTM})
    if values == "grey":
        assert (np.rint(brightness(path) * 65535) == LEVELS * 10).all()
    else:
        assert (heights_in(path, Picture(values="cm"), 10).levels == LEVELS).all()


def test_white_of_a_tiff_of_12_bits_is_4095(tmp_path: Path) -> None:
    tags = {256: 4, 257: 1, 258: 12, 259: 1, 262: 1, 273: 8, 277: 1, 278: 1, 279: 6}
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
    pixels = bytes.fromhex("000555aaafff")
    path = tmp_path / "a.tif"
    path.write_bytes(struct.pack("<2sHI6s2xH", b"II", 42, 16, pixels, len(tags)) + entries + bytes(4))
    assert brightness(path).ravel() == pytest.approx([0, 1 / 3, 2 / 3, 1])
    assert heights_in(path, Picture(levels=4), 10).levels.ravel().tolist() == [0, 1, 2, 3]


def test_columns_from_east_to_west_are_reversed_and_sides_are_lengths(tmp_path: Path) -> None:
    tags = {33550: (-0.25, 0.25, 0.0), 33922: (0.0, 0.0, 0.0, 5e5, 4e6, 0.0), 34735: UTM}
    read = heights_in(geotiff(tmp_path / "a.tif", np.ascontiguousarray(ROWS[:, ::-1]), tags), Picture(values="cm"), 10)
    assert (read.levels == LEVELS).all()
    assert read.recipe_values["block_width_cm"] == 25


def test_sides_of_swapped_rows_and_columns_are_swapped(tmp_path: Path) -> None:
    tags = {34264: matrix(((0, 1), (-1, 0)), (2, 1)), 34735: UTM}
    read = heights_in(geotiff(tmp_path / "a.tif", np.ascontiguousarray(ROWS.T), tags), Picture(values="cm"), 10)
    assert read.sides is not None
    assert read.sides[:2] == (1, 2)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif"])
def test_a_picture_is_read_as_viewers_show_it(tmp_path: Path, name: str, orientation: int) -> None:
    rows = np.kron(ROWS // 10 * 40, np.ones((16, 16))).astype(np.uint8)  # squares that JPEG keeps
    image = Image.fromarray(rows)
    exif = image.getexif()
    exif[0x0112] = orientation
    image.save(tmp_path / name, exif=exif, quality=100)
    shown = {
        2: rows[:, ::-1],
        3: rows[::-1, ::-1],
        4: rows[::-1],
        5: rows.T,
        6: np.rot90(rows, -1),
        7: np.rot90(rows, 2).T,
        8: np.rot90(rows),
    }.get(orientation, rows)
    read = brightness(tmp_path / name)
    assert read.shape == shown.T.shape
    assert np.abs(read * 255 - shown[::-1].T).max() < 2


@pytest.mark.parametrize("kind", ["P2", "P5"])
@pytest.mark.parametrize("largest", [100, 255, 500, 4095, 65535])
def test_the_numbers_of_a_pgm_are_those_in_it_whatever_its_largest_is(tmp_path: Path, kind: str, largest: int) -> None:
    numbers = np.array([[0, 50, 100, 1], [10, 20, 99, 2]], dtype=">u2" if largest > 255 else "u1")
    text = "\n".join(" ".join(map(str, row)) for row in numbers.tolist()).encode()
    path = tmp_path / "heights.pgm"
    path.write_bytes(f"{kind}\n4 2\n{largest}\n".encode() + (text if kind == "P2" else numbers.tobytes()))
    if largest > 255:  # of 8 bits no heights are read
        levels = heights_in(path, Picture(values="cm"), 1).levels
        assert (levels == numbers[::-1].T).all()
    assert brightness(path)[1, 1] == pytest.approx(50 / largest, abs=0.003)  # and of grey the largest is white


def test_32_bits_without_a_sign_have_none(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    rows = ROWS.astype("<u4")
    rows[1, 3] = 2**32 - 1
    tags = {42113: (2, b"4294967295\0")}
    path.write_bytes(tiff([(rows, {258: (3, 32), 262: (3, 1), 339: (3, 1), **tags})]))
    read = heights_in(path, Picture(values="cm", fill_holes=True), 10)
    assert read.holes is not None
    assert np.argwhere(read.holes).tolist() == [[3, 1]]
    assert (read.levels[~read.holes] == LEVELS[~read.holes]).all()


def metadata(*items: str) -> str:
    return f"<GDALMetadata>\n{''.join(items)}</GDALMetadata>\n"


SCALE = '  <Item name="SCALE" sample="0" role="scale">0.1</Item>\n'
OFFSET = '  <Item name="OFFSET" sample="0" role="offset">-30</Item>\n'
OF_ANOTHER_BAND = '  <Item name="SCALE" sample="1" role="scale">7</Item>\n  <Item name="A">1</Item>\n'


def test_numbers_become_heights_by_the_factor_and_the_sum_that_the_file_says(tmp_path: Path) -> None:
    for rows, items in (
        (ROWS * 10, (SCALE,)),
        (ROWS + 30, (OFFSET,)),
        ((ROWS + 30) * 10, (OF_ANOTHER_BAND, OFFSET, SCALE)),
        (ROWS, (OF_ANOTHER_BAND,)),
    ):
        path = geotiff(tmp_path / "a.tif", rows.astype(np.int16), {42112: metadata(*items)})
        assert (heights_in(path, Picture(values="cm"), 10).levels == LEVELS).all()


def test_no_data_is_a_number_before_it_becomes_a_height(tmp_path: Path) -> None:
    rows = np.where(ROWS == 50, -9999, ROWS * 10).astype(np.int16)
    path = geotiff(tmp_path / "a.tif", rows, {42112: metadata(SCALE), 42113: "-9999"})
    read = heights_in(path, Picture(values="cm", fill_holes=True), 10)
    assert read.holes is not None
    assert np.argwhere(read.holes).tolist() == [[3, 1]]


UNIT = '  <Item name="UNITTYPE" sample="0" role="unittype">{}</Item>\n'


@pytest.mark.parametrize(
    ("tags", "values", "said"),
    [
        ({42112: metadata(UNIT.format("ft"))}, "cm", "ft"),
        ({42112: metadata(UNIT.format("metre"))}, "cm", "m"),
        ({42112: metadata(UNIT.format("US survey foot"))}, "m", "ft"),
        ({42112: metadata(UNIT.format("US survey foot"))}, "ft", ""),
        ({42112: metadata(UNIT.format("cm"))}, "cm", ""),
        ({42112: metadata(UNIT.format("fathom"))}, "cm", ""),
        ({34735: (1, 1, 0, 1, 4099, 0, 1, 9002)}, "cm", "ft"),
        ({34735: (1, 1, 0, 1, 4099, 0, 1, 9001)}, "m", ""),
        ({}, "cm", ""),
    ],
)
def test_another_unit_of_heights_than_the_files_is_said(
    tmp_path: Path, tags: Mapping[int, Any], values: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = geotiff(tmp_path / "a.tif", ROWS, tags)
    arguments = ["import", str(path), "--values", values, "--any-heights", "-o", str(tmp_path / "worlds")]
    assert main(arguments) == 0
    printed = capsys.readouterr()
    line = f"warning: heights are read in {values}, and by the file their unit is {said} (--values)"
    assert (line in printed.out + printed.err) == bool(said)
    assert ("by the file their unit is" in printed.out + printed.err) == bool(said)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (metadata(SCALE.replace("0.1", "much")), "its scale of heights, in GDAL_METADATA, is not a number"),
        ("<GDALMetadata>", "a.tif: GDAL_METADATA: not XML"),
    ],
)
def test_a_factor_that_is_none_is_one_line(tmp_path: Path, content: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        heights_in(geotiff(tmp_path / "a.tif", ROWS, {42112: content}), Picture(values="cm"), 10)


def tiff(images: Sequence[tuple[np.ndarray, Mapping[int, tuple[int, Any]]]]) -> bytes:
    """Return a TIFF of images with tags, each with its type (2, 3 or 4: text, short, long) and value."""
    content = struct.pack("<2sHI", b"II", 42, 0)
    link = 4
    for rows, tags in images:
        strip, height, width = rows.tobytes(), len(rows), rows.shape[1]
        start = len(content)
        content += strip + b"\0" * (len(strip) % 2)
        listed: dict[int, tuple[int, Any]] = {256: (4, width), 257: (4, height), 273: (4, start), 278: (4, height)}
        entries = b""
        for tag, (kind, value) in sorted({**listed, 279: (4, len(strip)), **tags}.items()):
            if kind == 2:
                entries += struct.pack("<HHII", tag, kind, len(value), len(content))
                content += value + b"\0" * (len(value) % 2)
            else:
                entries += struct.pack("<HHII", tag, kind, 1, value)
        content = content[:link] + struct.pack("<I", len(content)) + content[link + 4 :]
        content += struct.pack("<H", len(entries) // 12) + entries
        link = len(content)
        content += bytes(4)
    return content


def test_a_mask_is_refused_with_the_command_that_writes_a_value_in_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    of_heights = {258: (3, 16), 262: (3, 1), 339: (3, 2)}
    smaller = ROWS[::2, ::2].copy(), {**of_heights, 254: (4, 1)}
    mask = np.array([[0b11110000], [0b11100000], [0b11110000]], dtype=np.uint8)
    path = tmp_path / "a.tif"
    path.write_bytes(tiff([(ROWS, of_heights), smaller]))
    assert (heights_in(path, Picture(values="cm"), 10).levels == LEVELS).all()
    path.write_bytes(tiff([(ROWS, of_heights), smaller, (mask, {254: (4, 4), 258: (3, 1), 262: (3, 4)})]))
    for options in (["--values", "cm"], []):
        assert main(["import", str(path), "-o", str(tmp_path / "worlds"), *options]) == 2
        said = "has a mask of the pixels without data; write a value in their place with "
        assert said + "`gdalwarp -ot Float32 -dstnodata -9999 FILE NEW.tif`" in capsys.readouterr().err
    assert not (tmp_path / "worlds").exists()


def test_depths_of_floating_point_numbers_are_metres(tmp_path: Path) -> None:
    above = ROWS.astype("f4") / 100
    depth = np.where(ROWS == 50, 0, 1.5 - above).astype("f4")
    path = geotiff(tmp_path / "a.tif", depth, {})
    read = heights_in(path, Picture(values="depth", camera_cm=150, fill_holes=True), 10)
    assert read.holes is not None
    assert np.argwhere(read.holes).tolist() == [[3, 1]]
    assert (read.levels[~read.holes] == LEVELS[~read.holes]).all()
