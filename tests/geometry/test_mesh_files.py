"""Files of meshes that trimesh does not read as they are: corners counted backwards, and text that is no UTF-8."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
import trimesh

from rsegen.geometry.mesh_files import _counted_forwards, loaded_by_trimesh

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


def test_corners_are_counted_from_the_first_point() -> None:
    found = _counted_forwards(BACKWARDS).decode().splitlines()
    lines = BACKWARDS.decode().splitlines()
    assert len(found) == len(lines)
    changed = [new for new, old in zip(found, lines, strict=True) if new != old]
    assert changed == FORWARDS


def test_files_that_count_forwards_stay() -> None:
    content = b"v 0 0 -1\nf 1 2 3 # -1\n#f -1 -2 -3\n"
    assert _counted_forwards(content) == content


def test_a_corner_that_is_no_number_is_a_value_error() -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        _counted_forwards(b"f -1 -x -2\n")


OBJ = """# für Gazebo
mtllib größe.mtl
o Würfel
v 0 0 0
v 1 0 0
v 0 1 0
f -3 -2 -1
"""
PLY = """ply
format ascii 1.0
comment für Gazebo
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""
STL = """solid Würfel
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid Würfel
"""
_FLAT: Any = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
GLTF = _FLAT.export(file_type="gltf", merge_buffers=True, embed_buffers=True)["model.gltf"].decode()


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize(
    ("name", "text"),
    [("a.obj", OBJ), ("a.ply", PLY), ("a.stl", STL), ("a.gltf", GLTF.replace("https://", "für https://"))],
)
def test_letters_of_other_languages_need_no_other_library(
    name: str, text: str, encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part of rsegen that a robot's file needs is never a reason to leave out its shapes."""
    assert "ü" in text
    monkeypatch.setitem(sys.modules, "charset_normalizer", None)
    (tmp_path / name).write_bytes(text.encode(encoding))
    with open(tmp_path / name, "rb") as file:
        found = loaded_by_trimesh(tmp_path / name, file, force="mesh")
    assert found.triangles.tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def test_a_file_that_trimesh_cannot_guess_is_a_value_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "charset_normalizer", None)
    (tmp_path / "a.off").write_bytes(b"OFF \xff\xfe\n")
    with open(tmp_path / "a.off", "rb") as file, pytest.raises(ValueError, match="charset_normalizer"):
        loaded_by_trimesh(tmp_path / "a.off", file)
