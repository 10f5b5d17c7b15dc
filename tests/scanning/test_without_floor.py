"""Fields without a floor around them: what tells the side up and the size, what is assumed, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.scanning.finding import find_field
from rsegen.scanning.scan import Scan, ScanSettings


def field_of(levels: Ints, boundary: str = "none") -> StepField:
    matrix = rsegen.Matrix.of(levels)
    recipe = rsegen.Recipe(chunk_size=max(levels.shape), boundary=boundary, unit_cm=10, obstacles=[matrix])
    return rsegen.build(recipe, 0)


def random_levels(seed: int, side: int, levels: int) -> Ints:
    return np.random.default_rng(seed).integers(0, levels, (side, side))


def tops(field: StepField, points: int = 200, noise: float = 0.002) -> Array:
    """Points on the tops of all cells, also those at level 0, and nothing else."""
    rng, (n_x, n_y) = np.random.default_rng(1), field.levels.shape
    x, y = rng.uniform(0, 1, (2, points * n_x * n_y)) * np.array([[n_x], [n_y]])
    z = field.heights[x.astype(int), y.astype(int)] + rng.normal(0, noise, x.shape)
    return np.column_stack([(x - n_x / 2) * field.block_width + 3, (y - n_y / 2) * field.block_width, z])


def tilted(points: Array, degrees: float = 9) -> Array:
    turn = trimesh.transformations.rotation_matrix(np.radians(degrees), [0.6, 0.8, 0.1])[:3, :3]
    return np.asarray(points @ turn.T)


def is_that(scan: Scan, field: StepField) -> bool:
    wanted = np.where(field.frame, 0, field.levels)
    levels, frame = np.maximum(scan.levels, 0), scan.frame
    return any(
        np.array_equal(np.rot90(levels, turns), wanted) and np.array_equal(np.rot90(frame, turns), field.frame)
        for turns in range(4)
    )


def written(field: StepField, kind: str, path: Path) -> Path:
    mesh = rsegen.mesh(field, kind)
    trimesh.Trimesh(tilted(mesh.vertices), mesh.triangles, process=False).export(path)
    return path


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("kind", ["watertight", "merged"])
@pytest.mark.parametrize("seed", range(3))
def test_the_side_up_of_a_tilted_mesh_is_no_matter_of_rounding(kind: str, seed: int, tmp_path: Path) -> None:
    """Closed blocks of one height look alike from both sides, and walls around holes go down below all that is seen."""
    field = field_of(random_levels(seed, 8, 2 if kind == "watertight" else 4))
    found = rsegen.scan(written(field, kind, tmp_path / "map.ply")).scan
    assert is_that(found, field)
    assert found.is_up_assumed == (kind == "watertight")


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("kind", ["watertight", "merged"])
def test_high_blocks_of_which_more_is_seen_from_aside_stand_upright(kind: str, tmp_path: Path) -> None:
    levels = np.array([[2, 3, 2], [2, 3, 1], [2, 3, 1], [3, 2, 1], [3, 2, 0], [3, 2, 0]])
    recipe = rsegen.Recipe(chunk_size=3, chunks=(2, 1), boundary="none", obstacles=[rsegen.Matrix.of(levels)])
    field = rsegen.build(recipe, 0)
    found = rsegen.scan(written(field, kind, tmp_path / "map.ply"), rsegen.ScanOptions(block_width_cm=10)).scan
    assert abs(found.rotation[2] @ tilted(np.array([[0.0, 0, 1]]))[0]) > 0.99


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["none", "outer", "divided"])
def test_a_frame_at_the_rim_of_a_cloud_is_no_floor_from_below(boundary: str) -> None:
    field = field_of(random_levels(5, 8, 4), boundary)
    scan = find_field(tilted(tops(field)))
    assert is_that(scan, field)
    assert scan.is_up_assumed


@pytest.mark.slow
def test_a_scan_says_that_the_axes_decided_which_side_is_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.savetxt(tmp_path / "map.xyz", tops(field_of(random_levels(5, 6, 4))), fmt="%.4f")
    assert main(["scan", str(tmp_path / "map.xyz"), "-o", str(tmp_path / "out")]) == 0
    assert "assumed: z is up, and the lowest tops are at level 0, as no floor" in "".join(capsys.readouterr())


@pytest.mark.slow
@pytest.mark.parametrize("lowest", [0, 1])
def test_a_scan_whose_axis_up_is_known_says_that_level_0_is_assumed(
    lowest: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A cloud without floor, and without a block at level 0, is that of lower blocks."""
    np.savetxt(tmp_path / "map.xyz", tops(field_of(random_levels(5, 6, 3) + lowest)), fmt="%.4f")
    assert main(["scan", str(tmp_path / "map.xyz"), "--up=z", "--json", "-o", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    assert err.count("assumed: the lowest tops are at level 0, as no floor around the field tells it (else all") == 1
    assert json.loads(out)["scan"]["level_0_is_assumed"] is True


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["none", "outer"])
@pytest.mark.parametrize("lowest", [1, 2])
def test_a_known_field_tells_where_level_0_is(boundary: str, lowest: int) -> None:
    field = field_of(random_levels(5, 8, 3) + lowest, boundary)
    scan = find_field(tops(field), ScanSettings(up=(0, 0, 1)), field)
    assert is_that(scan, field)
    assert scan.translation[2] == pytest.approx(0, abs=0.002)


@pytest.mark.slow
def test_a_known_field_tells_which_side_is_up() -> None:
    """Its highest level has the most blocks, and looks like the ground."""
    field = field_of(np.minimum(random_levels(5, 8, 8), 4))
    upside_down = tops(field) * (1, -1, -1)
    for points in (tops(field), tilted(tops(field)), upside_down):
        assert is_that(find_field(points, known=field), field)


@pytest.mark.slow
def test_few_cells_that_agree_by_chance_are_no_known_field() -> None:
    field, points = field_of(random_levels(5, 10, 5)), tops(field_of(random_levels(7, 10, 5)))
    corner = points[(points[:, :2] < points[:, :2].min(axis=0) + 0.3).all(axis=1)]
    with pytest.raises(ScanError, match="cells of the map were seen, too few to tell it from others; at least 30 are"):
        find_field(corner, ScanSettings(up=(0, 0, 1)), field)


@pytest.mark.slow
def test_a_cloud_under_whose_field_its_sensor_would_be_is_refused() -> None:
    """A camera that looks down along z has the field in front of it, at z above 0."""
    points = tops(field_of(random_levels(5, 8, 4))) - [3, 0, 0]
    seen = points * [1, -1, -1] + [0, 0, 1.5]
    with pytest.raises(ScanError, match=r"no floor .* set up"):
        find_field(seen)
    assert is_that(find_field(seen, ScanSettings(up=(0, 0, -1))), field_of(random_levels(5, 8, 4)))


@pytest.mark.slow
def test_a_single_block_that_is_lower_than_all_others_is_the_ground() -> None:
    levels = random_levels(6, 10, 3) + 1
    levels[4, 5] = 0
    assert is_that(find_field(tops(field_of(levels, "outer"))), field_of(levels, "outer"))


@pytest.mark.slow
def test_a_side_at_level_0_is_of_the_field_if_the_cloud_ends_with_it() -> None:
    levels = random_levels(3, 7, 4)
    levels[0] = 0
    levels[1, 2] = levels[-1, 3] = levels[2, 0] = levels[4, -1] = 1
    field = field_of(levels)
    assert is_that(rsegen.scan(tops(field)).scan, field)


@pytest.mark.slow
def test_a_rim_at_level_0_all_around_is_refused_without_a_size() -> None:
    levels = np.pad(np.maximum(random_levels(3, 6, 4), 1), 1)
    levels[3, 3] = 0
    field = field_of(levels)
    with pytest.raises(ScanError, match=r"6 x 6 blocks.*may be floor, blocks or a frame; set size"):
        rsegen.scan(tops(field))
    assert is_that(rsegen.scan(tops(field), rsegen.ScanOptions(size=(8, 8), boundary="none")).scan, field)


def peak() -> Ints:
    x = np.arange(11) - 5
    return np.asarray(np.maximum(np.rint(4 - np.hypot(x[:, None], x)), 0).astype(np.int64))


def with_one_apart() -> Ints:
    levels = np.maximum(random_levels(4, 8, 4), 0)
    levels[:, 5:] = 0
    levels[0, 4:7] = 0
    levels[3, 4], levels[0, 7] = 2, 1
    return levels


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize(
    ("levels", "why"),
    [
        (peak(), "those at the sides are lower"),
        (with_one_apart(), "1 of the raised stand apart"),
        (np.array([[1, 0, 2, 0], [0, 1, 0, 2], [2, 0, 1, 0], [0, 2, 0, 1]]), "of fields with as many raised"),
    ],
)
def test_blocks_at_level_0_that_a_mesh_does_not_have_are_asked_for(levels: Ints, why: str, tmp_path: Path) -> None:
    field = field_of(levels)
    file = written(field, "watertight", tmp_path / "map.stl")
    with pytest.raises(ScanError, match=rf"{why}.*; set size"):
        rsegen.scan(file)
    known = rsegen.ScanOptions(size=field.blocks.shape, block_width_cm=10, boundary="none")
    assert is_that(rsegen.scan(file, known).scan, field)
