"""Meshes of fields as drawing programs and phones make them: what a camera above sees gives their levels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints
from rsegen.recipe.examples import EXAMPLES
from rsegen.scanning.meshes import _Raster, _spread, seen_from_above
from tests.support.long import long_unless

LEVELS = np.random.default_rng(11).integers(0, 5, (8, 7))


def blocks(levels: Ints = LEVELS, width: float = 0.1) -> trimesh.Trimesh:
    """A closed box for each raised block, as a drawing program has them."""
    boxes = []
    for i, j in np.argwhere(levels > 0):
        height = levels[i, j] * 0.1
        boxes.append(trimesh.creation.box((width, width, height)))
        boxes[-1].apply_translation(((i + 0.5) * width, (j + 0.5) * width, height / 2))
    return joined(*boxes)


def joined(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    together = trimesh.util.concatenate(meshes)
    assert isinstance(together, trimesh.Trimesh)
    return together


def slab(thickness: float) -> trimesh.Trimesh:
    box = trimesh.creation.box((1.6, 1.5, thickness))
    box.apply_translation((0.4, 0.35, -thickness / 2))
    return joined(blocks(), box)


def turned(mesh: trimesh.Trimesh, seed: int) -> trimesh.Trimesh:
    mesh.apply_transform(trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3)))
    return mesh


def of_phone(seed: int) -> trimesh.Trimesh:
    """One surface of small uneven triangles, wound the wrong way, y up, as scanning apps write it."""
    rng, step = np.random.default_rng(seed), 0.012
    x, y = np.meshgrid(np.arange(-0.3, 1.1, step), np.arange(-0.3, 1.0, step), indexing="ij")
    i, j = np.floor(x / 0.1).astype(int), np.floor(y / 0.1).astype(int)
    inside = (i >= 0) & (i < 8) & (j >= 0) & (j < 7)
    z = np.where(inside, LEVELS[i.clip(0, 7), j.clip(0, 6)] * 0.1, 0) + rng.normal(0, 0.003, x.shape)
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (corner.ravel() for corner in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([a, d, c], axis=1)])
    places = np.stack([x, z, -y], axis=-1).reshape(-1, 3)
    return trimesh.Trimesh(places, faces, process=False)


def framed() -> trimesh.Trimesh:
    """Blocks that are all raised, in a frame, without a floor: nothing but their undersides is at level 0."""
    return blocks(np.pad(1 + LEVELS[:6, :6] % 4, 1, constant_values=1))


MESHES: Mapping[str, tuple[Callable[[], trimesh.Trimesh], Ints]] = {
    "alone.stl": (blocks, LEVELS),
    "on_a_thick_floor.ply": (lambda: slab(0.04), LEVELS),
    "upside_down.obj": (lambda: turned(slab(0.01), 8), LEVELS),
    "phone.ply": (lambda: of_phone(1), LEVELS),
    "framed.stl": (framed, 1 + LEVELS[:6, :6] % 4),
}


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("name", MESHES)
def test_the_levels_of_a_mesh_come_back(name: str, tmp_path: Path) -> None:
    make, levels = MESHES[name]
    make().export(tmp_path / name)
    scan = rsegen.scan(tmp_path / name).scan
    assert scan.unit == 0.1
    assert scan.block_width == 0.1
    assert scan.frame.any() == (name == "framed.stl")
    found = scan.blocks
    assert any(np.array_equal(np.rot90(found, turns), levels) for turns in range(4))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind"),
    long_unless(
        lambda case: case[0] == "nist-patterns",
        [("figure-7", "merged"), ("nist-patterns", "merged"), ("five-pallet-dash", "watertight")],
        reason="another example",
    ),
)
def test_a_mesh_of_an_example_is_scanned_as_what_it_was_made_of(name: str, kind: str, tmp_path: Path) -> None:
    recipe = rsegen.load(EXAMPLES[name])
    field = rsegen.build(recipe, recipe.first_map)
    mesh = rsegen.mesh(field, kind)
    trimesh.Trimesh(mesh.vertices, mesh.triangles).export(tmp_path / "map.stl")
    scan = rsegen.scan(tmp_path / "map.stl").scan
    wanted = np.where(field.frame, 0, field.levels)
    assert scan.frame.sum() == field.frame.sum() > 0
    assert any(np.array_equal(np.rot90(scan.levels, turns), wanted) for turns in range(4))


def collada(path: Path, mesh: trimesh.Trimesh, up: str = "") -> Path:
    """Write a mesh as COLLADA, with an axis up if one is given."""
    places, corners = (" ".join(map(str, np.ravel(values).tolist())) for values in (mesh.vertices, mesh.faces))
    path.write_text(
        f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{up}</asset>
        <library_geometries><geometry id="g"><mesh><source id="s"><float_array id="a">{places}</float_array>
          <technique_common><accessor source="#a" stride="3"/></technique_common></source>
          <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
          <triangles><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles></mesh></geometry>
        </library_geometries><library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"/></node>
        </visual_scene></library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>"""
    )
    return path


def y_up() -> trimesh.Trimesh:
    """Blocks as glTF has them: their z is y, and their y is -z."""
    mesh = slab(0.01)
    return trimesh.Trimesh(mesh.vertices[:, [0, 2, 1]] * [1, 1, -1], mesh.faces, process=False)


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("name", ["field.glb", "plain.dae", "y_up.dae"])
def test_an_axis_that_is_not_the_one_up_in_the_format_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if path.suffix == ".dae":
        collada(path, y_up(), "<up_axis>Y_UP</up_axis>" if name == "y_up.dae" else "")
    else:
        y_up().export(path)
    for up in ("z", "x", "-y"):
        with pytest.raises(ParameterError, match=rf"up: .*{name} shows less from there than from y, its own axis up"):
            rsegen.scan(path, rsegen.ScanOptions(up=up))
    for right in (None, "y"):
        found = rsegen.scan(path, rsegen.ScanOptions(up=right)).scan.blocks
        assert any(np.array_equal(np.rot90(found, turns), LEVELS) for turns in range(4))


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
def test_a_file_that_is_not_as_its_format_has_it_is_scanned_from_the_axis_that_is_given(tmp_path: Path) -> None:
    slab(0.01).export(tmp_path / "z_up.glb")
    for path in (tmp_path / "z_up.glb", collada(tmp_path / "z_up.dae", slab(0.01))):
        scanned = rsegen.scan(path, rsegen.ScanOptions(up="z"))
        assert scanned.clearer_up is None
        assert any(np.array_equal(np.rot90(scanned.scan.blocks, turns), LEVELS) for turns in range(4))


@pytest.mark.usefixtures("few_points")
def test_the_axis_that_shows_more_than_the_given_one_is_named() -> None:
    for up in ((0, 1, 0), (0, 0, -1)):
        clearer = seen_from_above(slab(0.01), up).clearer
        assert clearer is not None
        assert clearer * np.sign(up[1] * clearer[2] or 1) == pytest.approx((0, 0, 1), abs=1e-6)
    assert seen_from_above(slab(0.01), (0, 0, 1)).clearer is None


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
def test_the_parts_of_a_mesh_are_scanned_as_one(tmp_path: Path) -> None:
    """As `rsegen generate --to urdf` writes them: the open surface of each level in a file of its own."""
    mesh = slab(0.01)
    tops = np.round(mesh.triangles[:, :, 2].max(axis=1), 3)
    parts = []
    for number, height in enumerate(np.unique(tops)):
        part = trimesh.Trimesh(mesh.vertices, mesh.faces[tops == height])
        part.apply_scale(1000)
        part.export(path := tmp_path / f"{number}.obj")
        parts.append(path)
    assert len(parts) == LEVELS.max() + 2  # one has the underside of the slab
    found = rsegen.scan(parts, rsegen.ScanOptions(values="mm")).scan.blocks
    assert any(np.array_equal(np.rot90(found, turns), LEVELS) for turns in range(4))


def heights_over(points: Array, low: float, high: float) -> Array:
    """The heights of the points whose x and y are both between these."""
    return np.asarray(points[((points[:, :2] > low) & (points[:, :2] < high)).all(axis=1), 2])


def test_nothing_that_is_covered_is_seen() -> None:
    table = trimesh.creation.box((1, 1, 0.02))
    table.apply_translation((0, 0, 0.5))
    floor = trimesh.Trimesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    points = seen_from_above(joined(table, floor), (0, 0, 1)).points
    assert len(points) > 100_000
    below = heights_over(points, -0.45, 0.45)
    assert len(below) > 10_000
    assert (below > 0.5).mean() > 0.999
    assert np.allclose(heights_over(points, 0.55, 0.95), 0)


def test_a_box_stands_on_the_ground_around_it() -> None:
    seen = seen_from_above(trimesh.creation.box((2, 2, 0.5)), (0, 0, 1))
    points = seen.points
    assert seen.up is not None
    assert seen.up == pytest.approx((0, 0, 1))
    assert np.unique(np.round(points[:, 2], 6)).tolist() == [-0.25, 0.25]
    on_top = np.abs(points[:, :2]).max(axis=1) < 0.97
    assert (points[on_top, 2] > 0).mean() > 0.999
    assert (points[np.abs(points[:, :2]).max(axis=1) > 1.03, 2] < 0).all()


def test_a_mesh_without_an_area_shows_nothing() -> None:
    assert (
        len(seen_from_above(trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)).points) == 0
    )


@pytest.mark.slow
def test_the_merged_mesh_of_five_pallets_needs_no_direction(tmp_path: Path) -> None:
    """Most of it is on one level; from above and below it differs as much in height, so only its faces tell."""
    recipe = rsegen.load(EXAMPLES["five-pallet-dash"])
    field = rsegen.build(recipe, 0)
    mesh = rsegen.mesh(field)
    merged = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    merged.apply_transform(trimesh.transformations.rotation_matrix(2.5, (1, 0.2, 0)))
    merged.export(tmp_path / "dash.stl")
    scan = rsegen.scan(tmp_path / "dash.stl").scan
    right = np.where(field.frame, 0, field.levels)
    assert any(
        np.array_equal(np.rot90(scan.levels, turns), right) for turns in range(4) if scan.levels.size == right.size
    )


@pytest.mark.parametrize("make", [blocks, framed, lambda: trimesh.creation.icosphere(subdivisions=3)])
def test_points_are_spread_over_faces_as_trimesh_spreads_them(make: Callable[[], trimesh.Trimesh]) -> None:
    mesh = make()
    weights = mesh.area_faces * np.abs(mesh.face_normals[:, 2])
    theirs, of_face = trimesh.sample.sample_surface(mesh, 5_000, face_weight=weights, seed=0)
    points, faces = _spread(mesh, weights, 5_000)
    assert np.array_equal(faces, of_face)
    assert np.allclose(points.T, theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_point_is_covered_by_a_higher_one_of_its_pixel(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places, heights, within = rng.random((2, 600)), rng.random(600), 0.3 * rng.random(600)
    raster = _Raster.of(places, 0.1)
    highest = {key: heights[raster.keys == key].max() for key in np.unique(raster.keys)}
    wanted = [highest[key] - height <= most for key, height, most in zip(raster.keys, heights, within, strict=True)]
    assert 60 < sum(wanted) < 540
    assert raster.uncovered(heights, within).tolist() == wanted
