"""The benchmarked partitions cover what they should, so that their figures are about the same field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.contact import fields, partitions
from benchmarks.contact.constructions import ALL
from benchmarks.contact.courses import BODIES, GROUNDS, HEADINGS, course, drops, starts
from benchmarks.contact.shapes import Triangles
from benchmarks.contact.worlds import field_of, written
from rsegen import StepField
from rsegen.geometry import surface


@pytest.fixture
def field() -> StepField:
    levels = np.random.default_rng(1).integers(0, 4, (14, 11)).astype(np.int16)
    no_frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels, frame=no_frame, block_width=0.1, unit=0.01, frame_height=0.1)


@pytest.mark.parametrize("partition", [partitions.merged, partitions.largest_first, partitions.cells])
def test_a_partition_covers_every_top_once(partition: fields.Partition, field: StepField) -> None:
    covered = np.zeros(field.shape)
    for i0, i1, j0, j1, height in partition(field.heights):
        covered[i0:i1, j0:j1] += height

    assert covered == pytest.approx(field.heights)


@pytest.mark.parametrize("partition", [partitions.layered, partitions.extended])
def test_parts_cover_the_field_and_reach_only_under_higher_blocks(
    partition: fields.Partition, field: StepField
) -> None:
    covered = np.zeros(field.shape)
    for i0, i1, j0, j1, height in partition(field.heights):
        assert (field.heights[i0:i1, j0:j1] >= height).all()
        covered[i0:i1, j0:j1] = np.maximum(covered[i0:i1, j0:j1], height)

    assert covered == pytest.approx(field.heights)


@pytest.mark.parametrize("shapes", [fields.mesh(partitions.largest_first), fields.closed])
def test_a_mesh_has_the_area_of_the_shipped_one(shapes: fields.Shapes, field: StepField) -> None:
    (made,) = shapes(field)
    assert isinstance(made, Triangles)

    shipped = surface(field)

    assert area(made.corners) == pytest.approx(area(shipped.vertices[shipped.triangles]))


def test_every_robot_starts_on_its_floor_and_every_body_falls_on_its_cell() -> None:
    field = course(1)

    assert set(starts(field)) == {(ground, heading) for ground in GROUNDS for heading in HEADINGS}
    assert {start.ground for start in starts(field).values()} == {0.02}
    found = drops(field)
    assert len(found) == 3 * BODIES
    x, y = field.edges()
    for drop in found:
        i, j = np.searchsorted(x, drop.x) - 1, np.searchsorted(y, drop.y) - 1
        assert field.heights[i, j] == drop.top


@pytest.mark.parametrize(
    ("backend", "robot", "shape"),
    [("sim", "soft", "capsule"), ("sim", "ball", "sphere"), ("classic", "soft", "sphere")],
)
def test_casters_are_what_rsegen_writes_unless_they_are_to_be_balls(
    backend: str, robot: str, shape: str, tmp_path: Path
) -> None:
    plane = next(each for each in ALL if not each.levels)

    world = written(plane, field_of(plane, 1), tmp_path, backend, [robot]).read_text()

    others = {"capsule", "sphere"} - {shape}
    assert f"<{shape}>" in world
    assert not any(f"<{other}>" in world for other in others)


def area(corners: np.ndarray[tuple[int, int, int], np.dtype[np.float64]]) -> float:
    """Of tops alone."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.maximum(normals[:, 2], 0).sum() / 2)
