"""Rasters and edges rebuild the field; tags are what their definitions say."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat

from rsegen import DiagonalBarrier, HorizontalBarrier, Peak, Random, Recipe, Scene, StepField, build, compose
from rsegen.recipe.codec import decode
from rsegen.standing.posture import COLUMNS, Posture, edges, peaks_and_pits
from tests.formats.maps import SCENES, made
from tests.support.strategies import fields

SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
K = pytest.mark.parametrize("per_block", [1, 5, 10])

COURSE = compose(
    Recipe(
        seed=2,
        chunks=(2, 1),
        obstacles=(
            Random(levels=2),
            HorizontalBarrier(levels=5, first=(3, 0), last=(3, 9)),
            DiagonalBarrier(levels=4, first=(10, 0), last=(19, 9)),
            Peak(levels=5, first=(5, 5), last=(7, 7)),
        ),
    )
)


def rows(content: bytes) -> list[list[str]]:
    return [line.split(",") for line in content.decode().splitlines()]


@SCENE
@K
def test_every_sub_cell_has_its_block_s_height(scene: Scene, per_block: int) -> None:
    files, heights = made(Posture(per_block=per_block), scene), scene.field.heights
    raster = np.load(io.BytesIO(files["raster.npy"]))
    assert raster.dtype == np.float64
    np.testing.assert_array_equal(raster, np.kron(heights, np.ones((per_block, per_block))))
    table = np.loadtxt(io.BytesIO(files["raster.csv"]), delimiter=",", ndmin=2)
    np.testing.assert_array_equal(table[::-1].T, raster)


def rebuilt(found: np.ndarray, field: StepField) -> Iterator[np.ndarray]:
    """The heights, from the jumps that are met on the way from the west, and on the way from the south."""
    for axis in (0, 1):
        jumps = np.zeros([cells + 1 for cells in field.shape])
        for row in found[found[:, 4 + axis] != 0]:
            i, j = (int(np.argmin(np.abs(line - at))) for line, at in zip(field.edges(), row[:2], strict=True))
            jumps[i, j] = row[4 + axis] * (row[9] - row[7])
        yield np.cumsum(jumps, axis=axis)[:-1, :-1]


@given(field=fields())
def test_edges_rebuild_the_field_from_the_west_and_from_the_south(field: StepField) -> None:
    found = edges(field)
    for heights in rebuilt(found, field):
        np.testing.assert_allclose(heights, field.heights, atol=1e-9)
    assert found.shape[1] == len(COLUMNS)
    assert (found[:, 9] > found[:, 7]).all()
    assert (np.abs(found[:, 4:6]).sum(axis=1) == 1).all()
    lengths = np.abs(found[:, 2:4] - found[:, :2])
    np.testing.assert_allclose(lengths, np.where(found[:, 4:6] != 0, 0, field.block_width), atol=1e-9)
    for level, height in ((6, 7), (8, 9)):
        blocks = found[:, level] >= 0
        np.testing.assert_allclose(found[blocks, level] * field.unit, found[blocks, height], atol=1e-9)
        assert (found[~blocks, height] == pytest.approx(field.frame_height)) or not (~blocks).any()


@SCENE
def test_the_table_of_edges_is_the_array(scene: Scene) -> None:
    head, *body = rows(made(Posture(), scene)["edges.csv"])
    assert head == list(COLUMNS)
    expected = edges(scene.field)
    np.testing.assert_allclose(np.array(body, dtype=float).reshape(expected.shape), expected, atol=1e-9)


def plateaus(field: StepField) -> Iterator[tuple[set[tuple[int, int]], list[float]]]:
    """Every plateau and how far it is above each cell beside it: spread cell by cell."""
    n_x, n_y = field.shape
    left = {(i, j) for i in range(n_x) for j in range(n_y) if not field.frame[i, j]}
    while left:
        inside, border = set[tuple[int, int]](), [min(left)]
        own, steps = field.heights[border[0]], []
        while border:
            i, j = border.pop()
            inside.add((i, j))
            for at in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                on_map = 0 <= at[0] < n_x and 0 <= at[1] < n_y
                height = field.heights[at] if on_map else 0.0
                if on_map and not field.frame[at] and height == own:
                    border += [at] if at not in inside else []
                else:
                    steps.append(own - height)
        left -= inside
        yield inside, steps


@given(field=fields(), limit=st.sampled_from([0.0, 0.1, 0.2]))
def test_peaks_and_pits_have_their_documented_heights(field: StepField, limit: float) -> None:
    peaks, pits = peaks_and_pits(field, limit)
    found = list(plateaus(field))
    for where, sign in ((peaks, 1), (pits, -1)):
        expected = [cells for cells, steps in found if all(sign * step > limit + 1e-10 for step in steps)]
        numbered = [set(map(tuple, np.argwhere(where == number).tolist())) for number in range(where.max() + 1)]
        assert sorted(map(sorted, numbered)) == sorted(map(sorted, expected))


def test_barriers_and_peaks_of_the_recipe_are_tagged_where_they_are() -> None:
    files, field = made(Posture(), COURSE), COURSE.field
    _, *body = rows(files["tags.csv"])
    at = {
        kind: {(int(i), int(j)) for i, j, _, tag, source, _ in body if (tag, source) == (kind, "recipe")}
        for kind in KINDS
    }
    assert at["horizontal_barrier"] == {(4, 1 + j) for j in range(10)}
    assert at["diagonal_barrier"] >= {(13 + k, 1 + k) for k in range(10)}
    assert at["peak"] == {(6 + i, 6 + j) for i in range(3) for j in range(3)}
    assert all(int(level) == field.levels[int(i), int(j)] for i, j, level, *_ in body)
    said = json.loads(files["posture.json"])["tags"]["recipe"]
    assert [(one["number"], one["kind"]) for one in said] == list(zip((1, 2, 3), KINDS, strict=True))
    assert (said[0]["first"], said[0]["last"], said[0]["cells"]) == ([3, 0], [3, 9], 10)


KINDS = ("horizontal_barrier", "diagonal_barrier", "peak")


def test_a_field_without_a_known_obstacle_has_tags_of_its_heights_alone() -> None:
    said = json.loads(made(Posture(), SCENES["blocks that touch along an edge"])["posture.json"])["tags"]
    assert said["recipe"] == []
    assert said["field"] == {"peaks": 2, "pits": 0}


@SCENE
def test_start_and_goal_are_on_flat_ground_outside_the_map(scene: Scene) -> None:
    said = json.loads(made(Posture(clearance_cm=50), scene)["posture.json"])
    reach = scene.field.extent[0] / 2 + 0.5
    assert (said["start"]["x"], said["goal"]["x"]) == pytest.approx((-reach, reach))
    assert all(said[end][key] == 0 for end in ("start", "goal") for key in ("y", "z", "yaw"))
    assert decode(said["recipe"]) == scene.alone
    assert build(decode(said["recipe"]), scene.index) == scene.field


@pytest.mark.parametrize("scene", [*SCENES.values(), COURSE], ids=[*SCENES, "course"])
def test_matlab_has_it_all(scene: Scene) -> None:
    files, field = made(Posture(per_block=3), scene), scene.field
    found = loadmat(io.BytesIO(files["posture.mat"]))
    np.testing.assert_array_equal(found["raster"], np.load(io.BytesIO(files["raster.npy"])))
    np.testing.assert_array_equal(found["levels"], field.levels)
    np.testing.assert_array_equal(found["edges"].reshape(-1, len(COLUMNS)), edges(field))
    assert [text.item() for text in found["edge_columns"].ravel()] == list(COLUMNS)
    peaks, pits = peaks_and_pits(field, field.unit)
    np.testing.assert_array_equal(found["peaks"], peaks + 1)
    np.testing.assert_array_equal(found["pits"], pits + 1)
    assert found["start"].tolist() == [[-found["goal"][0, 0], 0, 0, 0]]
    kinds = [text.item() for text in found["shape_kinds"].ravel()]
    assert found["shapes"].reshape(*field.shape, -1).shape == (*field.shape, len(kinds))
