"""The robot of a preview: where it settles, above what is behind it and behind what is in front of it."""

from __future__ import annotations

import io
from collections.abc import Mapping
from math import cos
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from rsegen import preview
from rsegen.cli.edge import main
from rsegen.field.stepfield import Array, StepField
from rsegen.pictures.preview import _ELEVATION, _TOWARD, _project
from rsegen.robots.base import ROBOTS
from rsegen.standing.body import Body
from rsegen.standing.drawing import _DRIVEN, _UNDRIVEN, RobotDrawing, draw_robot
from rsegen.standing.resting import Poses, resting_poses
from tests.standing.stands import field_of

BURGER = ROBOTS["burger"].body


def walled(side: str) -> StepField:
    """Level ground with a wall of 80 cm at one side of its middle: the viewer is in the south-east."""
    levels = np.zeros((14, 14), int)
    where: Mapping[str, Any] = {"south": np.s_[:, 3], "north": np.s_[:, 10], "west": np.s_[3], "east": np.s_[10]}
    levels[where[side]] = 8
    return field_of(levels, 0.1)


def seen(field: StepField, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> float:
    """Share of the right half of the preview that has about the colours of a robot: the plan is in the left half."""
    image = Image.open(io.BytesIO(preview(field, robot=ROBOTS["crawler"], at=at))).convert("RGB")
    pixels = np.asarray(image)[:, image.size[0] // 2 :].astype(float) / 255
    colours = [np.abs(pixels - to_rgb(colour)).max(axis=2) < 0.2 for colour in (_DRIVEN, _UNDRIVEN)]
    return float(np.logical_or(*colours).mean())


@pytest.mark.slow
def test_a_robot_is_behind_what_is_in_front_of_it() -> None:
    share = {side: seen(walled(side)) for side in ("north", "west", "south", "east")}
    behind = min(share["north"], share["west"])
    assert behind > 0.01
    assert max(share["south"], share["east"]) < 0.5 * behind


def outlines_of(body: Body, rests: Poses) -> list[tuple[Array, str]]:
    return list(RobotDrawing(body=body, rests=rests, stable=1).silhouettes(_project, _TOWARD))


@pytest.mark.parametrize("kind", sorted(ROBOTS))
def test_the_outlines_are_those_of_the_robot_as_seen(kind: str) -> None:
    body, level = ROBOTS[kind].body, np.zeros((20, 20), int)
    low, high = (outlines_of(body, resting_poses(field_of(level + height, 0.1), body, 0, 0, 0)) for height in (0, 2))
    assert len(low) == len(high) == len(body.parts)
    assert {colour for _, colour in low} == {_DRIVEN, _UNDRIVEN}
    for (below, _), (above, _) in zip(low, high, strict=True):
        risen = (above.max(axis=0) + above.min(axis=0) - below.max(axis=0) - below.min(axis=0)) / 2
        assert risen == pytest.approx([0, 0.2 * cos(_ELEVATION)], abs=1e-3)
    across = np.ptp(np.concatenate([outline for outline, _ in low])[:, 0])
    assert across == pytest.approx(ROBOTS[kind].size[0], rel=0.6)


def test_the_nearest_part_is_drawn_last() -> None:
    """Of a robot that looks east the wheels on its right are nearer to the viewer, and lower in the picture."""
    body = ROBOTS["jackal"].body
    drawn = outlines_of(body, resting_poses(walled("north"), body, 0, -0.1, 0))
    heights = [float(outline[:, 1].mean()) for outline, colour in drawn if colour == _DRIVEN]
    assert len(heights) == 4
    assert max(heights[2:]) < min(heights[:2])


def test_the_plan_has_the_robot_too_and_the_title_says_how_it_stands() -> None:
    axes = Figure().add_subplot()
    draw_robot(axes, BURGER, resting_poses(walled("north"), BURGER, 0.2, -0.1, 0.5))
    assert axes.dataLim.x0 < 0.2 < axes.dataLim.x1
    level = resting_poses(walled("north"), BURGER, 0, 0, 0)
    told = RobotDrawing(body=BURGER, rests=level, stable=1).describe()
    assert told.startswith("the robot tilts by 0.0 degrees, ")
    assert told.endswith(" degrees from tipping over")
    assert RobotDrawing(body=BURGER, rests=level, stable=2).describe() == f"{told}; one of 2 stable poses"
    edge = resting_poses(walled("north"), BURGER, 0, 0.25, 0)
    assert RobotDrawing(body=BURGER, rests=edge, stable=0).describe() == "the robot tips over"


def test_the_command_draws_a_robot_and_refuses_places_that_are_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain, drawn = tmp_path / "plain.png", tmp_path / "drawn.png"
    assert main(["preview", "peak", "-o", str(plain)]) == 0
    assert main(["preview", "peak", "--robot", "crawler", "--at", "0.1,0,30", "-o", str(drawn)]) == 0
    assert plain.read_bytes() != drawn.read_bytes()
    capsys.readouterr()
    for wrong, said in (
        (["--at", "0,0,0"], "--at: is the place of a robot; use --robot too"),
        (["--robot", "crawler", "--at", "9,0,0"], "--at: 9 m is outside the field, -0.6..0.6 m"),
        (["--robot", "crawler", "--at", "1,2"], "--at: [1.0, 2.0] is not 3 values"),
        (["--robot", "crawl"], "--robot: unknown robot 'crawl'"),
    ):
        file = tmp_path / "wrong.png"
        assert main(["preview", "peak", *wrong, "-o", str(file)]) == 2
        assert said in capsys.readouterr().err
        assert not file.exists()
