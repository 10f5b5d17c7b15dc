"""Meshes of robots: what is read of binary STL without trimesh is what trimesh reads, and a file is read once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen.errors import FileError
from rsegen.geometry.mesh_files import Triangles
from rsegen.robots.files import body, meshes, sdf_file, sdf_shapes
from rsegen.robots.files.meshes import bounds, collision_mesh, mesh_corners, read_mesh, simplified
from rsegen.robots.files.sdf_file import from_file
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import has_stood
from rsegen.standing.settling import outer_radius, settle

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
    low, high = bounds(mesh_corners(path))
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
    for read in (mesh_corners, read_mesh):
        with pytest.raises(FileError, match=r"part\.stl: "):
            read(path)


def test_a_corner_that_is_no_number_does_not_count(tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    SOLIDS["box"].export(path)
    content = bytearray(path.read_bytes())
    content[84 + 12 : 84 + 16] = np.float32(np.nan).tobytes()
    path.write_bytes(content)
    low, high = bounds(mesh_corners(path))
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
    for module, reader in ((sdf_shapes, mesh_corners), (body, collision_mesh)):

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


def test_a_turned_mesh_reaches_as_far_as_its_corners(tmp_path: Path) -> None:
    SOLIDS["wheel"].export(tmp_path / "wheel.stl")  # along z, of radius 0.1 and width 0.05
    links, joints = "<link name='base'/>", ""
    for name, y in (("left", 0.3), ("right", -0.3)):
        pose = "<pose>0 0 0 1.5707963267948966 0.6 0</pose>"  # about its axle too
        mesh = f"<collision name='c'>{pose}<geometry><mesh><uri>wheel.stl</uri></mesh></geometry></collision>"
        links += f"<link name='{name}'><pose>0 {y} 0.1 0 0 0</pose>{mesh}</link>"
        ends = f"<parent>base</parent><child>{name}</child>"
        joints += f"<joint name='{name}_hub' type='revolute'>{ends}<axis><xyz>0 1 0</xyz></axis></joint>"
    path = tmp_path / "turned.sdf"
    path.write_text(f"<sdf version='1.9'><model name='turned'>{links}{joints}</model></sdf>")
    robot = from_file(path)
    assert robot.drive.radius == pytest.approx(0.1, rel=0.01)  # the box around its turned box has 0.139
    assert robot.lift == pytest.approx(0.0, abs=1e-3)
    assert robot.size == pytest.approx((0.2, 0.65, 0.2), abs=2e-3)


def test_a_part_of_a_mesh_is_refused(tmp_path: Path) -> None:
    SOLIDS["box"].export(tmp_path / "box.stl")
    path = tmp_path / "part.sdf"
    path.write_text(
        "<sdf version='1.9'><model name='m'><link name='l'><collision name='c'><geometry><mesh><uri>box.stl</uri>"
        "<submesh><name>lid</name></submesh></mesh></geometry></collision></link></model></sdf>"
    )
    with pytest.raises(FileError, match="link 'l': collision shape 'c' is a <submesh>, which is not read; write it"):
        from_file(path)


@pytest.mark.filterwarnings("error")
def test_triangles_of_no_area_are_no_surface(tmp_path: Path) -> None:
    solid = SOLIDS["ball"].copy()
    flat = np.concatenate([solid.faces, solid.faces[:, [0, 1, 1]]])
    trimesh.Trimesh(solid.vertices, flat, process=False).export(tmp_path / "ball.stl")
    path = tmp_path / "ball.sdf"
    path.write_text(
        "<sdf version='1.9'><model name='ball'><link name='l'><collision name='c'><geometry><mesh><uri>ball.stl</uri>"
        "</mesh></geometry></collision></link></model></sdf>"
    )
    normals = from_file(path).body.normals
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


SIDE = 0.01


def rod() -> trimesh.Trimesh:
    """A plate with a rod that is thinner than a cube, and a screw that is smaller than one."""
    plate = trimesh.creation.box((0.4, 0.3, 0.05))
    while len(plate.faces) < 20_000:
        plate = plate.subdivide()
    antenna = trimesh.creation.cylinder(0.001, 0.3, sections=8).apply_translation((0.105, 0.0333, 0.2))
    screw = trimesh.creation.icosphere(radius=0.001).apply_translation((0.1333, 0.1333, 0.3333))
    parts = plate, antenna, screw
    return trimesh.Trimesh(
        *trimesh.util.append_faces([part.vertices for part in parts], [part.faces for part in parts])
    )


@pytest.mark.slow
@pytest.mark.parametrize("is_sorted", [False, True])
def test_a_mesh_of_many_faces_is_simplified_and_nothing_of_it_is_lost(
    is_sorted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(meshes, "MANY_FACES", 1000)
    if is_sorted:
        monkeypatch.setattr(meshes, "_CUBES_PER_POINT", 0)
    solid = trimesh.creation.icosphere(subdivisions=5, radius=0.2)
    for mesh, most in ((solid, 0.7), (rod(), 0.5)):
        points, corners = np.asarray(mesh.vertices)[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces))
        few = simplified(Triangles(points, corners.reshape(-1, 3)), SIDE)
        assert len(few.corners) < most * len(mesh.faces)
        assert {*map(tuple, few.points.tolist())} <= {*map(tuple, points.tolist())}
        off = np.abs(np.subtract(few.points[few.corners].min(axis=(0, 1)), mesh.bounds[0]))
        assert (off <= SIDE).all()
        away = np.linalg.norm(mesh.vertices[::7, None] - few.points[np.unique(few.corners)], axis=2).min(axis=1)
        assert away.max() <= SIDE * 3**0.5
    drawn = few.points[few.corners]
    assert ((drawn[:, :, 2] > 0.332) & (drawn[:, :, 0] > 0.12)).all(axis=1).sum() == len(
        trimesh.creation.icosphere().faces
    )  # of the screw
    wanted = trimesh.creation.cylinder(0.001, 0.3, sections=8)  # the rod
    assert ((drawn[:, :, 2] > 0.03) & (drawn[:, :, 0] < 0.11)).all(axis=1).sum() == len(wanted.faces)


def test_what_is_outermost_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "MANY_FACES", 1000)
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=0.2)
    few = simplified(Triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces)), SIDE)
    assert len(few.corners) < len(mesh.faces)
    directions = np.random.default_rng(1).normal(size=(20, 3))
    for direction in directions / np.linalg.norm(directions, axis=1, keepdims=True):
        assert (mesh.vertices @ direction).max() - (few.points @ direction).max() < SIDE / 10


@pytest.mark.parametrize("place", [np.nan, np.inf, 1e300, None])
def test_a_mesh_that_cannot_be_simplified_stays(place: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    points, faces = np.array(SOLIDS["ball"].vertices), np.asarray(SOLIDS["ball"].faces)
    mesh = Triangles(points, faces)
    assert simplified(mesh, SIDE) is mesh  # it has few faces
    monkeypatch.setattr(meshes, "MANY_FACES", 10)
    assert simplified(mesh, 0.0) is mesh
    assert simplified(mesh, SIDE) is not mesh
    if place is not None:
        points[3, 1] = place
        assert simplified(mesh, SIDE) is mesh


def test_corners_of_many_faces_are_not_merged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "part.stl"
    SOLIDS["ball"].export(path)
    content = bytearray(path.read_bytes())
    content[84 + 12 : 84 + 16] = np.float32(np.nan).tobytes()  # a face that has no place
    path.write_bytes(content)
    merged = read_mesh(path)
    monkeypatch.setattr(meshes, "MANY_FACES", 10)
    separate = read_mesh(path)
    assert len(separate.points) == 3 * len(separate.corners)
    np.testing.assert_array_equal(separate.points[separate.corners], merged.points[merged.corners])
    np.testing.assert_array_equal(
        bounds(mesh_corners(path)), (separate.points.min(axis=0), separate.points.max(axis=0))
    )


@pytest.mark.slow
def test_a_robot_of_many_faces_rests_where_one_of_all_its_faces_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hull with an uneven underside, on which it stands."""
    hull = trimesh.creation.icosphere(subdivisions=7)
    assert len(hull.faces) > meshes.MANY_FACES
    places = np.sign(hull.vertices) * np.sqrt(np.abs(hull.vertices)) * (0.3, 0.2, 0.08)
    hull.vertices = places + np.random.default_rng(0).normal(0, 2e-4, places.shape)
    hull.export(tmp_path / "hull.stl")
    shape = '<collision name="c"><geometry><mesh><uri>hull.stl</uri></mesh></geometry></collision>'
    path = tmp_path / "hull.sdf"
    path.write_text(f'<sdf version="1.9"><model name="hull"><link name="l">{shape}</link></model></sdf>')
    few = sdf_file._body_of.__wrapped__(from_file(path))
    monkeypatch.setattr(meshes, "MANY_FACES", len(hull.faces))
    exact = sdf_file._body_of.__wrapped__(from_file(path))
    assert len(few.surface) < len(exact.surface) / 2
    field = rsegen.build(rsegen.Recipe(seed=3, boundary="none", unit_cm=3, obstacles=[rsegen.Random(levels=3)]))
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-0.4, 0.4, (2, 100))
    yaw = rng.uniform(-np.pi, np.pi, 100)
    ground = PaddedGround.of(field, max(map(outer_radius, (exact, few))))
    wanted, found = (settle(ground, each, x, y, yaw) for each in (exact, few))
    stood = has_stood(wanted) & has_stood(found)
    assert stood.mean() > 0.9
    assert np.quantile(np.abs(found.z - wanted.z)[stood], 0.95) < 0.0005  # metres
