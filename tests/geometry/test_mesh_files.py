"""OBJ files whose faces count their corners backwards are the same as those that count them forwards."""

from __future__ import annotations

from pathlib import Path

import pytest

from rsegen.geometry.mesh_files import counted_forwards

BACKWARDS = b"""# two faces
v 0 0 -1
v 1 0 0
v 1 1 0
vn 0 0 1
vt 0 -0
f -3//-1 -2//-1 -1//-1
v 2 0 1\r
v 3 0 1
v 3 1 1

vn 0 1 0
  f -3/-1/-1 2/1/-2 -1
l -1 -6
o end-1
"""
FORWARDS = ["f 1//1 2//1 3//1", "f 4/1/2 2/1/1 6", "l 6 1"]


def read(path: Path, content: bytes) -> bytes:
    path.write_bytes(content)
    with open(path, "rb") as file:
        return counted_forwards(path, file).read()


def test_corners_are_counted_from_the_first_point(tmp_path: Path) -> None:
    found = read(tmp_path / "a.obj", BACKWARDS).decode().splitlines()
    lines = BACKWARDS.decode().splitlines()
    assert len(found) == len(lines)
    changed = [new for new, old in zip(found, lines, strict=True) if new != old]
    assert changed == FORWARDS


def test_files_that_count_forwards_and_others_stay(tmp_path: Path) -> None:
    content = b"v 0 0 -1\nf 1 2 3 # -1\n#f -1 -2 -3\n"
    assert read(tmp_path / "a.OBJ", content) == content
    assert read(tmp_path / "a.ply", BACKWARDS) == BACKWARDS


def test_a_corner_that_is_no_number_is_a_value_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        read(tmp_path / "a.obj", b"f -1 -x -2\n")
