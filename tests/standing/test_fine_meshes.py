"""A robot of fine meshes has few samples, and rests where one with many does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.field.stepfield import Array
from rsegen.standing import body as sampling
from rsegen.standing.body import Body, CollisionPart, body_of_shapes, sample_distance, sampled_mesh
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import has_stood
from rsegen.standing.settling import Settled, outer_radius, settle

trimesh = pytest.importorskip("trimesh")

LENGTH = 0.5
FIELD = rsegen.build(rsegen.Recipe(seed=3, boundary="none", unit_cm=3, obstacles=[rsegen.Random(levels=3)]))


def fine(mesh: Any, points: int) -> Any:
    """The mesh with its triangles divided until it has so many points."""
    while len(mesh.vertices) < points:
        mesh = mesh.subdivide()
    return mesh


def plate(points: int = 5_000) -> Any:
    """A flat hull."""
    return fine(trimesh.creation.box(extents=(LENGTH, 0.3, 0.1)), points)


def bowl() -> Any:
    """A hull that is round below."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    return mesh.apply_transform(np.diag([LENGTH / 2, 0.15, 0.06, 1]))


def stepped() -> Any:
    """A hull with a lower plate, aslant in the grid of samples."""
    parts = [plate(), trimesh.creation.box(extents=(0.2, 0.15, 0.05)).apply_translation((0.05, 0, -0.06))]
    mesh = fine(trimesh.util.concatenate(parts), 5_000)
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(0.02, (0, 0, 1)))


def robot(hull: Any, distance: float = sample_distance(LENGTH)) -> Body:
    """A robot with this hull on four wheels, which are meshes too."""
    shapes = [(CollisionPart("hull", drives=False, mu=1, mu2=1), hull, np.eye(4))]
    wheel = trimesh.creation.cylinder(radius=0.06, height=0.04, sections=48)
    for number, (x, y) in enumerate(((0.17, 0.17), (-0.17, 0.17), (0.17, -0.17), (-0.17, -0.17))):
        turned = trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0))
        turned[:3, 3] = x, y, -0.05
        shapes.append((CollisionPart(f"wheel{number}", drives=True, mu=1, mu2=1), fine(wheel, 300), turned))
    sampled = [
        (part, sampled_mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), distance), pose)
        for part, mesh, pose in shapes
    ]
    return body_of_shapes(sampled, mass=10, centre=np.zeros(3), speed=0.5, distance=distance, where="robot")


def at_rest(body: Body, radius: float) -> Settled:
    """The robot at 100 places."""
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-0.4, 0.4, (2, 100))
    return settle(PaddedGround.of(FIELD, radius), body, x, y, rng.uniform(-np.pi, np.pi, 100))


def off(rest: Settled, exact: Settled) -> tuple[Array, Array]:
    """By how much robots are off in height, millimetres, and orientation, degrees."""
    stood = has_stood(rest) & has_stood(exact)
    assert stood.mean() > 0.9
    turned = (rest.axes[stood, :, 2] * exact.axes[stood, :, 2]).sum(axis=1)
    return np.abs(rest.z - exact.z)[stood] * 1000, np.degrees(np.arccos(np.clip(turned, -1, 1)))


@pytest.mark.slow
@pytest.mark.parametrize("hull", [bowl, stepped])
def test_fewer_samples_inside_of_faces_change_no_pose_by_more_than_samples_do_anyway(
    hull: Callable[[], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = robot(hull())
    exact = robot(hull(), sample_distance(LENGTH) / 2)
    monkeypatch.setattr(sampling, "_inside_faces", lambda points, *_: np.zeros(len(points), bool))
    many = robot(hull())
    radius = outer_radius(exact)
    rests = [at_rest(body, radius) for body in (few, many, exact)]
    (height, turn), (height_before, turn_before) = (off(rest, rests[2]) for rest in rests[:2])
    assert np.median(height) < np.median(height_before) + 0.1
    assert np.quantile(height, 0.9) < 1.3 * np.quantile(height_before, 0.9) + 0.2
    assert np.median(turn) < np.median(turn_before) + 0.1
    assert has_stood(rests[0]).tolist() == has_stood(rests[1]).tolist()


def test_a_flat_face_of_many_triangles_has_few_samples_inside_and_all_of_its_edge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    few = robot(plate(10_000))
    monkeypatch.setattr(sampling, "_inside_faces", lambda points, *_: np.zeros(len(points), bool))
    many = robot(plate(10_000))

    def edge(body: Body) -> set[tuple[float, ...]]:
        """The samples on the edge of the hull's underside."""
        low = (body.part == 0) & (body.points[:, 2] < -0.05 + 1e-6)
        outer = np.abs(np.abs(body.points[:, :2]) - (LENGTH / 2, 0.15)).min(axis=1) < 1e-6
        return {tuple(point) for point in body.points[low & outer].round(6).tolist()}

    assert edge(few) == edge(many)
    assert len(edge(few)) > 100
    assert (few.part == 0).sum() < 0.5 * (many.part == 0).sum()
    assert (few.low == many.low).all()
    assert (few.high == many.high).all()


def test_of_many_meshes_each_sample_is_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes hide nothing, so whether samples are inside of them is not asked; rows are numbered as numpy does it."""
    asked: list[str] = []
    depth = sampling.SurfaceSamples.depth

    def counted(self: sampling.SurfaceSamples, points: Array) -> Array:
        asked.append(self.kind)
        return depth(self, points)

    monkeypatch.setattr(sampling.SurfaceSamples, "depth", counted)
    part = CollisionPart("part", drives=False, mu=1, mu2=1)
    mesh = trimesh.creation.box(extents=(0.1, 0.1, 0.1))
    small = sampled_mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), 0.01)
    places = [np.eye(4) for _ in range(5)]
    for number, place in enumerate(places):
        place[0, 3] = 0.2 * number
    shapes = [(part, small, place) for place in places] + [
        (part, sampling.sampled_box((2, 0.02, 0.3), 0.01), np.eye(4))
    ]
    body = body_of_shapes(shapes, mass=1, centre=np.zeros(3), speed=1, distance=0.01, where="robot")
    assert asked == ["box"]
    assert set(body.part) == set(range(6))


@pytest.mark.parametrize("far", [1, 10**6])
def test_rows_are_numbered_in_their_order(far: int) -> None:
    rows = np.random.default_rng(2).integers(-5, 5, (500, 3)) * far
    _, expected = np.unique(rows, axis=0, return_inverse=True)
    numbers = sampling._numbered(rows)
    assert (numbers.max() < 500) == (far > 1)  # those of a small box are its places
    np.testing.assert_array_equal(np.unique(numbers, return_inverse=True)[1], expected.ravel())
    assert sampling._numbered(rows[:0]).shape == (0,)
