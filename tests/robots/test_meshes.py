"""Meshes of robots: what is read of binary STL without trimesh is what trimesh reads, and a file is read once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from rsegen.errors import FileError
from rsegen.robots import body, sdf_shapes
from rsegen.robots.meshes import mesh_bounds, read_mesh
from rsegen.robots.sdf_file import from_file

SOLIDS = {
    "box": trimesh.creation.box((0.4, 0.2, 0.1)),
    "ball": trimesh.creation.icosphere(subdivisions=2, radius=0.07),
    "wheel": trimesh.creation.cylinder(0.1, 0.05, sections=24),
}


@pytest.mark.parametrize("form", ["stl", "stl_ascii", "obj", "ply", "glb"])
@pytest.mark.parametrize("name", SOLIDS)
def test_bounds_are_those_of_the_triangles(name: str, form: str, tmp_path: Path) -> None:
    path = tmp_path / f"part.{form.removesuffix('_ascii')}"
    solid = SOLIDS[name].copy().apply_translation((0.3, -0.1, 2.0))
    solid.export(path, file_type=form)
    low, high = mesh_bounds(path)
    np.testing.assert_allclose((low, high), solid.bounds, atol=1e-6)
    points, corners = read_mesh(path)
    assert np.array_equal(low, points[corners].min(axis=(0, 1)))
    assert np.array_equal(high, points[corners].max(axis=(0, 1)))


@pytest.mark.parametrize("name", SOLIDS)
def test_a_binary_stl_is_read_as_trimesh_reads_it(name: str, tmp_path: Path) -> None:
    path = tmp_path / "part.STL"
    SOLIDS[name].export(path, file_type="stl")
    theirs = trimesh.load(path, force="mesh")
    assert isinstance(theirs, trimesh.Trimesh)
    points, corners = read_mesh(path)
    assert np.array_equal(points, theirs.vertices)
    assert np.array_equal(corners, theirs.faces)
    assert len(points) < 3 * len(corners)  # equal corners are one point


def test_an_stl_cut_short_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    SOLIDS["ball"].export(path)
    path.write_bytes(path.read_bytes()[:-20])
    for read in (mesh_bounds, read_mesh):
        with pytest.raises(FileError, match=r"part\.stl: "):
            read(path)


def test_a_corner_that_is_no_number_does_not_count(tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    SOLIDS["box"].export(path)
    content = bytearray(path.read_bytes())
    content[84 + 12 : 84 + 16] = np.float32(np.nan).tobytes()
    path.write_bytes(content)
    low, high = mesh_bounds(path)
    assert np.isfinite([low, high]).all()
    np.testing.assert_allclose(high - low, (0.4, 0.2, 0.1))


def test_a_mesh_of_many_shapes_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("box", "wheel"):
        SOLIDS[name].export(tmp_path / f"{name}.stl")
    uses = [("box", 1), ("wheel", 1), ("box", 2)]
    links = "".join(
        f'<link name="l{place}"><pose>0 {place - 7} 1 0 0 0</pose><collision name="c"><geometry><mesh>'
        f"<uri>{name}.stl</uri><scale>{scale} 1 1</scale></mesh></geometry></collision></link>"
        for place, (name, scale) in enumerate(uses * 5)
    )
    path = tmp_path / "many.sdf"
    path.write_text(f'<sdf version="1.9"><model name="many">{links}</model></sdf>')
    read: list[str] = []
    for module, reader in ((sdf_shapes, mesh_bounds), (body, read_mesh)):

        def counted(path: Path, reader=reader):  # type: ignore[no-untyped-def]
            read.append(path.name)
            return reader(path)

        monkeypatch.setattr(module, reader.__name__, counted)
    robot = from_file(path)
    assert sorted(set(read)) == ["box.stl", "wheel.stl"]
    assert len(read) % 3 == 0
    assert len(read) <= 6  # once per form: also where a model is read anew for its sizes
    assert robot.size[:2] == pytest.approx((0.8, 14.2))
    read.clear()
    parts = robot.body
    assert sorted(read) == ["box.stl", "box.stl", "wheel.stl"]
    assert len(parts.parts) == 15
    assert parts.high[0] - parts.low[0] == pytest.approx(0.8)
