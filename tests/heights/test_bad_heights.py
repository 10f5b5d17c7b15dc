"""Files of heights from strangers: one line for each that is not what it should be, and none from a library."""

from __future__ import annotations

import io
import os
import tracemalloc
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rsegen.cli.edge import main
from rsegen.heights.table import COLUMNS
from tests.support.complaints import Refused

HEADER = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }"


def saved(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npy(header: str = HEADER, version: int = 1, length: int | None = None) -> bytes:
    text = f"{header}\n".encode("latin-1")
    size = (len(text) if length is None else length).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + size + text + bytes(32)


def npz() -> bytes:
    file = io.BytesIO()
    np.savez(file, np.ones((2, 2)))
    return file.getvalue()


ARRAYS: Mapping[str, tuple[bytes, str]] = {
    "an open bracket": (npy(HEADER.replace("(2, 2)", "(2, 2")), "its header is damaged"),
    "many open brackets": (npy(HEADER.replace("(2, 2)", "(" * 3000)), "its header is damaged"),
    "no dictionary": (npy("[1]"), "its header is damaged"),
    "more than the file has": (npy(HEADER.replace("(2, 2)", "(2, 3)")), "promises 48 bytes, 32 are there"),
    "2 GB": (npy(HEADER.replace("(2, 2)", "(16384, 16384)")), "promises 2147483648 bytes, 32 are there"),
    "more than any file has": (npy(HEADER.replace("(2, 2)", f"({'9' * 99}, 2)")), "its header promises 1599999"),
    "a side below nothing": (npy(HEADER.replace("(2, 2)", "(-2, -2)")), "a shape of (-2, -2)"),
    "a header of 2 GB": (npy(version=2, length=2**31), "a header of 2147483648 bytes"),
    "a header of the third version": (npy(version=3), "version 3.0"),
    "objects": (npy(HEADER.replace("<f8", "O")), "its values are object"),
    "a type unknown": (npy(HEADER.replace("<f8", "<f7")), "its header is damaged"),
    "values of no size": (npy(HEADER.replace("<f8", "S0")), "its values are |S0"),
    "records": (npy(HEADER.replace("'<f8'", "[('a', '<f4'), ('b', '<f4')]")), "2 axes of [('a', '<f4'), ('b', '<f4')]"),
    "strings": (npy(HEADER.replace("<f8", "<U2")), "2 axes of <U2"),
    "dates": (npy(HEADER.replace("<f8", "<M8[s]")), "2 axes of datetime64[s]"),
    "complex numbers": (npy(HEADER.replace("<f8", "<c8")), "2 axes of complex64"),
    "a hundred names": (
        npy(HEADER.replace("'<f8'", str([(f"{'n' * 20}{number}", "u1") for number in range(8)]))),
        "2 axes of [('nnn",
    ),
    "no axis": (npy(HEADER.replace("(2, 2)", "()")), "0 axes of float64"),
    "no cell": (npy(HEADER.replace("(2, 2)", "(0, 2)")), "0 x 2 cells"),
    "an archive of arrays": (npz(), "not an array of numbers that numpy saved (.npy)"),
    "half a file": (saved(np.ones((20, 20)))[:2000], "promises 3200 bytes, 1872 are there"),
    "half a header": (saved(np.ones((2, 2)))[:60], "its header is damaged"),
    "heights beyond every number": (
        saved(np.array([[1e308, 1]])),
        "column 1: 1 cm is not 0..32766 whole units of 10 cm",
    ),
    "numbers of 80 bits": (saved(np.array([[np.longdouble("1e4000")]])), "inf cm is not"),
}


@pytest.mark.parametrize(("content", "words"), ARRAYS.values(), ids=ARRAYS)
def test_an_array(refused: Refused, content: bytes, words: str) -> None:
    Path("a.npy").write_bytes(content)
    line = refused("import", "a.npy", "-o", "out")
    assert "a.npy: " in line
    assert words in line


def test_a_header_is_believed_only_as_far_as_the_file_goes(refused: Refused) -> None:
    Path("a.npy").write_bytes(npy(version=2, length=2**31))
    tracemalloc.start()
    refused("import", "a.npy", "-o", "out")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2**25


SHEET = ",".join(COLUMNS)

TABLES: Mapping[str, tuple[str, str]] = {
    "a unit of two points": ("# block levels in units of 1.2.3 cm\n1,2\n", "line 1: unit_cm: '1.2.3' is not a number"),
    "a unit of points": ("# block levels in units of ... cm\n1,2\n", "line 1: unit_cm: '...' is not a number"),
    "a unit of nothing": (
        "# block levels in units of 0.0 cm\n1,2\n",
        "line 1: unit_cm: 0.0 is outside 0.001..1000",
    ),
    "no line": ("", "0 x 0 cells"),
    "a height beyond every number": ("1e400,1\n", "row 1 from the top, column 1: inf cm is not"),
    "a height of many digits": (f"{'9' * 100_000},1\n", "row 1 from the top, column 1: inf cm is not"),
    "another row of many cells": (f"1,2\n{'1,' * 100_000}\n", "line 2: 100001 cells, and 2 in line 1"),
    "another row of many words": (f"1 2\n{'1 ' * 100_000}\n", "line 2: 100000 cells, and 2 in line 1"),
    "rows of many lengths, and a word": ("1,x\n1\n", "line 2: 1 cells, and 2 in line 1"),
    "two words": ("1,x\ny,1\n1,1\n", "line 1, column 2: 'x' is not a number (1 more such cell)"),
    "more cells than there may be": (f"{'1,' * 2**12}1\n" * 2**12, "4097 x 4096 cells; from 1 up to 16,777,216"),
    "a row of more cells than there may be": (f"{',' * 2**24}\n", "16777217 x 1 cells; from 1 up to 16,777,216"),
    "lines of nothing": ("\n" * (2**24 + 1), "more lines than the 16,777,216 cells that can be read"),
    "a build sheet with a hole": (
        f"{SHEET}\n0,0,9999999,9999999,10,10\n",
        "the cell x 0, y 0 of 10000000 x 10000000 is missing",
    ),
    "a build sheet of many rows": (
        f"{SHEET}\n" + "\n" * 1_000_001,
        "1,000,001 rows; up to 1,000,000 can be read",
    ),
}


@pytest.mark.parametrize(("content", "words"), TABLES.values(), ids=TABLES)
def test_a_table(refused: Refused, content: str, words: str) -> None:
    Path("a.csv").write_text(content, "utf-8")
    line = refused("import", "a.csv", "-o", "out")
    assert "a.csv: " in line
    assert words in line


def picture(form: str, mode: str = "L", **options: str) -> bytes:
    file = io.BytesIO()
    Image.linear_gradient("L").resize((16, 16)).convert(mode).save(file, form, **options)
    return file.getvalue()


@pytest.mark.parametrize("form", ["DDS", "GIF", "ICO", "PCX", "TGA", "WEBP", "PDF", "JPEG2000"])
@pytest.mark.parametrize("name", ["a.png", "a.tif"])
def test_a_picture_of_another_form_under_the_name_of_one(refused: Refused, form: str, name: str) -> None:
    Path(name).write_bytes(picture(form, "RGB"))
    assert f"{name}: not an image (PNG, JPEG, PPM, TIFF, BMP)" in refused("import", name, "-o", "out")


@pytest.mark.parametrize("start", [b"II*\0", b"MM\0*", b"II+\0\b\0\0\0"])
def test_a_tiff_that_is_not_read_says_how_to_make_one(refused: Refused, start: bytes) -> None:
    """As of several bands of numbers, which maps of satellites have."""
    Path("a.tif").write_bytes(start + bytes(100))
    line = refused("import", "a.tif", "-o", "out")
    assert "a.tif: a TIFF whose bands or numbers are not read" in line
    assert "gdal_translate -b 1" in line


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"0" * 64 + b"\nsize 1495484\n"


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.csv", "a.yaml", "a.npy"])
def test_a_pointer_of_git_lfs_is_named(refused: Refused, name: str) -> None:
    Path(name).write_bytes(POINTER)
    assert f"{name}: a pointer of Git LFS, and not the file itself; run `git lfs pull`" in refused(
        "import", name, "-o", "out"
    )


@pytest.mark.parametrize("name", ["a.ply", "a.pcd", "a.laz", "a.e57", "a.glb", "a.obj", "a.dae", "a.xyz", "a.mcap"])
def test_a_pointer_of_git_lfs_in_place_of_a_cloud_is_named(refused: Refused, name: str) -> None:
    Path(name).write_bytes(POINTER)
    assert f"{name}: a pointer of Git LFS, and not the file itself" in refused("scan", name, "-o", "out")


@pytest.mark.parametrize("mesh", ["a.stl", "a.dae", "a.obj"])
def test_a_pointer_of_git_lfs_in_place_of_a_robots_mesh_is_named(refused: Refused, mesh: str) -> None:
    Path(mesh).write_bytes(POINTER)
    shape = f"<collision name='c'><geometry><mesh><uri>{mesh}</uri></mesh></geometry></collision>"
    Path("a.sdf").write_text(f"<sdf version='1.6'><model name='m'><link name='l'>{shape}</link></model></sdf>")
    assert f"{mesh}: a pointer of Git LFS, and not the file itself" in refused("robot", "a.sdf")


@pytest.mark.parametrize("mesh", ["a.stl", "a.obj"])
def test_a_pointer_of_git_lfs_in_place_of_a_mesh_of_mujoco_is_named(refused: Refused, mesh: str) -> None:
    Path(mesh).write_bytes(POINTER)
    body = "<worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody>"
    Path("a.xml").write_text(f"<mujoco><asset><mesh name='m' file='{mesh}'/></asset>{body}</mujoco>")
    assert f"{mesh}: a pointer of Git LFS, and not the file itself" in refused("robot", "a.xml")


def test_a_picture_of_more_than_16_bits(refused: Refused) -> None:
    Image.fromarray(np.array([[0, 70_000]], dtype=np.int32)).save("a.tif")
    assert "a.tif: grey values of 0..70000; use an image of 8 or 16 bits" in refused("import", "a.tif", "-o", "out")


@pytest.mark.parametrize("compression", ["tiff_lzw", "tiff_adobe_deflate", "jpeg", "packbits", "group4"])
def test_a_damaged_tiff_is_one_line_also_on_the_descriptor_of_a_library(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], compression: str
) -> None:
    whole = picture("TIFF", "1" if compression == "group4" else "RGB", compression=compression)
    path = tmp_path / "a.tif"
    refusals = 0
    for at in range(8, len(whole), max(1, len(whole) // 5)):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        made = tmp_path / f"out{at}"
        code, err = main(["import", str(path), "-o", str(made)]), capfd.readouterr().err
        assert code in (0, 2), err
        assert err.count("\n") == (code == 2), err
        assert "internal error" not in err
        refusals += code == 2
    assert refusals


MAP = "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("m.pgm", "[m.pgm]"), "image: invalid value ['m.pgm']"),
        (("m.pgm", "no.pgm"), "no.pgm: No such file"),
        (("m.pgm", "."), "Is a directory"),
        (("m.pgm", "/dev/zero"), "/dev/zero: not a regular file"),
        (("m.pgm", "m.yaml"), "m.yaml: not an image"),
        (("0.05", "0"), "resolution: 0 is outside"),
        (("0.05", ".nan"), "resolution: nan is not a finite number"),
        (("0.05", "{a: 1}"), "resolution: {'a': 1} is not a number"),
        (("negate: 0", "negate: perhaps"), "negate: 'perhaps' is not a whole number"),
        ((MAP, "[1, 2]"), "not an occupancy grid of ROS"),
        ((MAP, "rosbag2_bagfile_information: {version: 9}"), "m.yaml: not an occupancy grid of ROS"),
        ((MAP, "obstacles: [{kind: peak}]"), "m.yaml: a recipe, not an occupancy grid of ROS; generate makes"),
        ((MAP, "image: m.pgm"), "resolution: an empty value is not a number"),
    ],
)
def test_a_map_of_ros(refused: Refused, change: tuple[str, str], words: str) -> None:
    Path("m.pgm").write_bytes(picture("PPM"))
    Path("m.yaml").write_text(MAP.replace(*change))
    assert words in refused("import", "m.yaml", "-o", "out")


@pytest.mark.parametrize("name", ["a.npy", "a.png", "a.tif", "a.pgm"])
def test_a_pipe_without_a_writer_is_no_file_of_heights(name: str, tmp_path: Path, refused: Refused) -> None:
    os.mkfifo(tmp_path / name)
    assert f"{name}: not a regular file" in refused("import", name, "-o", "out")


@pytest.mark.parametrize("name", ["a.csv", "a.yaml"])
def test_a_pipe_without_a_writer_is_no_text_of_heights(name: str, tmp_path: Path, refused: Refused) -> None:
    os.mkfifo(tmp_path / name)
    assert f"{name}: a pipe to which nobody writes" in refused("import", name, "-o", "out")


INVENTORIES: Mapping[str, tuple[str, str]] = {
    "a field of many letters": (f"height_cm,count\n10,{'1' * 140_000}\n", "line 2: field larger than field limit"),
    "a header of many letters": ("h" * 140_000, "line 1: field larger than field limit"),
    "an open quotation mark": ('height_cm,count\n"10,1\n', "line 2: '10,1' is not a height and a count"),
    "no number": ("height_cm,count\nnan,1\n", "line 2: nan is not a finite number"),
    "too many": ("height_cm,count\n10,1e400\n", "line 2: '1e400' is not a whole number"),
    "nothing": ("", "does not begin with the line height_cm,count"),
}


@pytest.mark.parametrize(("content", "words"), INVENTORIES.values(), ids=INVENTORIES)
def test_an_inventory(refused: Refused, content: str, words: str) -> None:
    Path("i.csv").write_text(content)
    assert words in refused("generate", "--obstacle", "random levels=3", "--inventory", "i.csv", "-o", "out")
