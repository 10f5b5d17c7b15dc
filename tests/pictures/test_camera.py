"""Pictures of triangles by a camera: places, what hides what, shadows, and what moves."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import Random, Recipe, compose
from rsegen.driving.filming import shapes_of_map
from rsegen.field.stepfield import Array
from rsegen.pictures.camera import Camera, Pixels, Triangles, View, _pixels, south_west_of
from rsegen.robots.lookup import robot_of
from rsegen.robots.visuals import visuals

EXTENT = (2.0, 2.0)
CAMERA = south_west_of(EXTENT, (320, 180))
GROUND = (0.8, 0.8, 0.8)


def block(x: float, y: float, side: float, high: float, colour: tuple[float, float, float]) -> Triangles:
    """A box on the ground."""
    low, end = np.array([x - side / 2, y - side / 2, 0]), np.array([x + side / 2, y + side / 2, high])
    corners = np.array([(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]) * (end - low) + low
    faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    triangles = corners[faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)]
    return Triangles(triangles, np.tile(colour, (12, 1)))


def shown(still: Triangles, moving: Triangles | None = None) -> Pixels:
    return View(CAMERA, still, 3.0, GROUND).picture(moving or Triangles.joined([]))


def at(picture: Pixels, x: float, y: float, z: float) -> Array:
    """The colour of the pixel that shows a place, 0..1."""
    column, row, _ = CAMERA.projected(np.array([x, y, z]))
    return np.asarray(picture[int(row), int(column)] / 255)


def test_the_middle_of_the_map_is_in_the_middle_of_the_picture_and_north_is_left_and_up() -> None:
    """The camera looks at it from the south-west; its pitch is rounded to 0.0001."""
    x, y, nearness = CAMERA.projected(np.zeros(3))
    assert (x, y) == pytest.approx((160, 90), abs=0.1)
    assert 1 / nearness == pytest.approx(np.linalg.norm(CAMERA.place), rel=1e-6)
    assert CAMERA.projected(np.array([0, 1.0, 0]))[0] < 160 < CAMERA.projected(np.array([1.0, 0, 0]))[0]
    assert CAMERA.projected(np.array([0, 0, 0.5]))[1] < 90
    assert np.isnan(CAMERA.projected(2 * np.array(CAMERA.place))).all()


@pytest.mark.parametrize("extent", [(0.4, 0.4), (3.0, 1.0), (20.0, 8.0)])
def test_a_whole_map_is_in_the_picture(extent: tuple[float, float]) -> None:
    camera = south_west_of(extent)
    corners = np.array([(x * extent[0] / 2, y * extent[1] / 2, 0) for x in (-1, 1) for y in (-1, 1)])
    seen = camera.projected(corners)
    assert (seen[:, :2] > 0).all()
    assert (seen[:, :2] < camera.pixels).all()


def test_tops_have_their_colour_and_sides_are_darker() -> None:
    picture = shown(block(0, 0, 0.5, 0.4, (0.9, 0.2, 0.1)))
    assert at(picture, 0, 0, 0.4) == pytest.approx((0.9, 0.2, 0.1), abs=0.01)
    assert at(picture, 0, 0.9, 0) == pytest.approx(GROUND, abs=0.01)
    south, west = at(picture, 0, -0.25, 0.2), at(picture, -0.25, 0, 0.2)
    assert 0.9 > south[0] > west[0] > 0.4  # the sun is in the south-east
    assert south / south[0] == pytest.approx(np.array([1, 2 / 9, 1 / 9]), abs=0.02)


def test_what_is_nearer_hides_what_is_behind_it() -> None:
    near, far = block(-0.4, -0.4, 0.4, 0.8, (1, 0, 0)), block(0.0, 0.0, 0.4, 0.2, (0, 1, 0))
    for parts in ([near, far], [far, near]):
        picture = shown(Triangles.joined(parts))
        assert not (picture[..., 1] > 2 * picture[..., 0].astype(int)).any()
    assert (shown(far)[..., 1] > 2 * shown(far)[..., 0].astype(int)).any()


def test_a_block_throws_a_shadow_away_from_the_sun_and_nowhere_else() -> None:
    without, picture = shown(Triangles.joined([])), shown(block(0, 0, 0.4, 0.6, (0.9, 0.9, 0.9)))
    assert at(picture, -0.35, 0.4, 0) == pytest.approx(0.52 * np.array(GROUND), abs=0.01)
    for x, y in ((0.5, -0.5), (0.9, 0.0), (-0.8, -0.8)):
        assert at(picture, x, y, 0) == pytest.approx(at(without, x, y, 0), abs=0.01)


def test_a_level_field_has_no_shadow_of_its_own() -> None:
    """Surfaces that look at the sun would shade themselves where the sun's pixels are coarse."""
    picture = shown(block(0, 0, 2.0, 0.1, (0.5, 0.6, 0.7)))
    tops = [at(picture, x, y, 0.1) for x in np.linspace(-0.95, 0.95, 24) for y in np.linspace(-0.95, 0.95, 24)]
    assert np.ptp(tops, axis=0).max() < 0.01


@pytest.mark.parametrize("place", [(0, 0, 0), (0.7, -0.3, 0.2), (-1.4, 0, 0), (-4, -4, 0), (60, 0, 0), (-40, -40, 0)])
def test_what_moves_is_seen_as_if_it_had_been_there_from_the_beginning(place: tuple[float, float, float]) -> None:
    """Only a part of the picture is drawn anew: robot, shadow, and what the robot hides are all in it."""
    field = compose(Recipe(seed=1, chunk_size=4, obstacles=(Random(levels=5),)))
    still = shapes_of_map(field)
    robot = Triangles.joined(
        Triangles(shape.points[shape.corners], np.tile(shape.colour, (len(shape.corners), 1)))
        for shapes in visuals(robot_of("crawler")).values()
        for shape in shapes
    )
    pose = np.eye(4)
    pose[:3, 3] = place
    moving = robot.moved(pose)
    expected = shown(Triangles.joined([still, moving]))
    assert np.array_equal(shown(still, moving), expected)
    is_seen = np.hypot(*place[:2]) < 2
    assert np.array_equal(shown(still), expected) != is_seen


@pytest.mark.parametrize("side", [100, 300, 900])
def test_nothing_is_seen_between_two_triangles(side: int) -> None:
    """The ground is two of them, whose common edge goes through the middles of pixels of a square picture."""
    camera = Camera(place=(0.3, -0.4, 0.3), pitch=0.35, yaw=2.3, view=0.6, pixels=(side, side))
    nothing = Triangles.joined([])
    pixels = View(camera, nothing, 1.0, (0.5, 0.5, 0.5)).picture(nothing)
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 1


def test_a_triangle_has_the_pixels_whose_middles_are_in_it() -> None:
    """By the shares of its three corners, of which nearness is the same mean."""
    rng, (high, wide) = np.random.default_rng(3), (40, 60)
    corners = rng.uniform((-10, -10, 0.1), (wide + 10, high + 10, 1), (50, 3, 3))
    y, x = np.mgrid[:high, :wide] + 0.5
    for triangle in corners:
        sides = np.linalg.inv(np.vstack([triangle[:, :2].T, np.ones(3)]))
        shares = np.einsum("ij,j...->i...", sides, np.array([x, y, np.ones_like(x)]))
        expected = np.where((shares >= 0).all(axis=0), np.einsum("i...,i", shares, triangle[:, 2]), 0)
        drawn = np.zeros((high, wide))
        for at, nearness, _ in _pixels(triangle[None], (high, wide)):
            drawn.ravel()[at] = nearness
        np.testing.assert_allclose(drawn, expected, atol=1e-9)
