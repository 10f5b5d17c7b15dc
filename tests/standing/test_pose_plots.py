"""Pictures of poses, looked at by another library."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from PIL import Image

from rsegen import Random, Recipe, Scene, compose
from rsegen.recipe.codec import decode
from rsegen.robots.base import ROBOTS
from rsegen.standing import drawing, plots
from rsegen.standing.drawing import draw_robot, hull
from rsegen.standing.plots import pose_maps
from rsegen.standing.resting import resting_poses

RECIPE = Recipe(seed=1, unit_cm=1, frame_height_cm=1, boundary="none", obstacles=(Random(levels=4),))
BURGER = ROBOTS["burger"].body


def scene_of(recipe: Recipe = RECIPE) -> Scene:
    return compose(recipe)


def share(image: Image.Image, colour: str) -> float:
    """Share of a picture that has about a colour."""
    pixels = np.asarray(image.convert("RGB")).astype(float) / 255
    return float((np.abs(pixels - to_rgb(colour)).max(axis=2) < 0.03).mean())


@pytest.mark.slow
def test_the_maps_show_every_reason_that_there_is_and_the_robot() -> None:
    scene = scene_of()
    image = Image.open(io.BytesIO(pose_maps(scene, BURGER, 0.5, robot="burger")))
    assert image.size[0] == 1500
    assert len(image.convert("RGB").getcolors(1_000_000) or []) > 100
    x, y = plots._places(scene.field)
    found = resting_poses(scene.field, BURGER, x[:, None], y[None, :], np.array(0.5)).reason
    assert len(set(found.tolist())) > 1
    for number, colour in enumerate(plots._REASON_COLOURS):
        assert share(image, colour) >= 0.15 * (found == number).mean()
    assert share(image, drawing._DRIVEN) > 2e-5  # lines, blurred
    assert decode(json.loads(image.info["Description"])) == RECIPE


@pytest.mark.slow
def test_the_same_map_gives_the_same_bytes_and_the_legend_is_words() -> None:
    svg = pose_maps(scene_of(), BURGER, 0.0, "svg", robot="burger")
    assert svg == pose_maps(scene_of(), BURGER, 0.0, "svg", robot="burger")
    text = svg.decode()
    for word in (*plots._NAMES, "tilt [degrees]; grey: tips over", "margin", "burger, heading 0 degrees"):
        assert word in text


@pytest.mark.slow
@pytest.mark.parametrize("chunks", [(1, 1), (3, 1)])
def test_on_flat_ground_everything_is_level_and_green(chunks: tuple[int, int]) -> None:
    flat = Recipe(seed=1, boundary="none", chunks=chunks)
    image = Image.open(io.BytesIO(pose_maps(scene_of(flat), BURGER, 0.0)))
    assert share(image, plots._REASON_COLOURS[0]) > 0.1 / chunks[0]
    for colour in plots._REASON_COLOURS[1:]:
        assert share(image, colour) < 0.005


def test_a_robot_is_drawn_where_it_is_with_its_wheels_in_another_colour() -> None:
    axes = Figure().subplots()
    found = resting_poses(scene_of().field, BURGER, np.array([0.1]), np.array([-0.2]), np.array([np.pi / 2]))
    draw_robot(axes, BURGER, found)
    outlines = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    wheels = [patch for patch in outlines if patch.get_edgecolor() == to_rgba(drawing._DRIVEN)]
    assert len(wheels) == 2
    # The heading is north, so the wheels, 16 cm apart, are west and east of the robot.
    middles = np.array(sorted(np.mean(wheel.get_xy(), axis=0).tolist() for wheel in wheels))
    assert np.ptp(middles[:, 0]) == pytest.approx(0.16, abs=0.01)
    assert middles.mean(axis=0) == pytest.approx([0.1, -0.2], abs=0.02)
    (arrow,) = axes.texts
    assert arrow.xy[1] > -0.2  # type: ignore[attr-defined]  # an annotation


def test_a_hull_holds_all_points_counterclockwise() -> None:
    points = np.random.default_rng(1).uniform(-1, 1, (200, 2))
    corners = hull(points)
    sides = np.roll(corners, -1, axis=0) - corners
    to_points = points[:, None] - corners
    assert (sides[:, 0] * to_points[..., 1] - sides[:, 1] * to_points[..., 0] > -1e-5).all()
    assert hull(points[:1]).shape == (1, 2)


def test_inner_points_are_left_out_of_a_hull_which_stays_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    for points in (np.random.default_rng(1).normal(size=(5000, 2)), np.outer(np.linspace(0, 1, 2000), (1, 2))):
        few, corners = drawing._without_inner(points), hull(points)
        with monkeypatch.context() as patch:
            patch.setattr(drawing, "_MANY", len(points))
            np.testing.assert_array_equal(corners, hull(points))
        assert len(few) <= len(points)
    assert len(drawing._without_inner(np.random.default_rng(1).normal(size=(5000, 2)))) < 500
