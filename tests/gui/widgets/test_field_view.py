"""The 3D view, on a real display of its own: what can be seen in its pictures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from rsegen.exporters.scene import FRAME_COLOUR, level_colour
from rsegen.gui.model.reach import EASTWARD, NORTHWARD
from tests.support.screen import ON_SCREEN, missing
from tests.support.waiting import MINUTES

HERE = Path(__file__).parent
BOX = (0.95, 0.0, 0.75)
Found = dict[str, Any]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("views")


@pytest.fixture(scope="session")
def found(display: str, folder: Path) -> Found:
    """What viewed.py says, with its pictures in the folder."""
    said = viewed(folder, DISPLAY=display, **ON_SCREEN)
    if said["unavailable"]:
        missing(str(said["unavailable"]))
    return said


def viewed(folder: Path, **environment: str) -> Found:
    command = [sys.executable, str(HERE / "viewed.py"), str(folder)]
    run = subprocess.run(
        command, env=os.environ | environment, capture_output=True, text=True, timeout=MINUTES / 1000, check=False
    )
    if "ModuleNotFoundError: No module named 'PySide6'" in run.stderr or "Could not load the Qt platform" in run.stderr:
        missing(run.stderr.strip().splitlines()[-1])
    assert run.returncode == 0, run.stderr
    said: Found = json.loads(run.stdout.splitlines()[-1])
    return said


def share(folder: Path, name: str, colour: tuple[float, float, float]) -> float:
    """How much of a picture has a colour, about; the legend, on the right, left out."""
    with Image.open(folder / f"{name}.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(float) / 255
    shown = pixels[:, : int(pixels.shape[1] * 0.75)]
    return float((np.abs(shown - colour).max(axis=2) < 0.02).mean())


def test_a_view_shows_frame_and_levels(found: Found, folder: Path) -> None:
    for colour in (FRAME_COLOUR, *(level_colour(level, 4) for level in range(1, 5))):
        assert share(folder, "plain", colour) > 0.0002


def test_a_map_without_frames_is_shown_without_frames(found: Found, folder: Path) -> None:
    assert share(folder, "large", FRAME_COLOUR) == 0
    assert share(folder, "large", level_colour(4, 4)) > 0.01


def test_a_highlighted_window_is_outlined(found: Found, folder: Path) -> None:
    assert share(folder, "plain", BOX) == 0
    assert share(folder, "highlighted", BOX) > 0.001


def test_a_flat_map_is_ground_alone(found: Found, folder: Path) -> None:
    assert share(folder, "flat", (219 / 255,) * 3) > 0.1
    assert share(folder, "flat", level_colour(4, 4)) == 0
    assert share(folder, "flat", BOX) == 0


def test_reach_and_paths_are_shown_in_the_view_and_its_pictures(found: Found, folder: Path) -> None:
    eastward, northward = (np.array(colour) / 255 for colour in (EASTWARD, NORTHWARD))
    for name in ("reach", "reach-saved"):
        assert share(folder, name, tuple(eastward)) > 0.0005
        assert share(folder, name, tuple(northward)) > 0.0005
    for name in ("before-reach", "no-reach"):
        assert share(folder, name, tuple(eastward)) == 0
    before, after = (np.asarray(Image.open(folder / f"{name}.png")) for name in ("before-reach", "no-reach"))
    assert np.array_equal(before, after)


def corner(folder: Path, name: str, row: int) -> float:
    """How bright the background is at the left of a row of pixels, 0..1."""
    with Image.open(folder / f"{name}.png") as image:
        return float(np.asarray(image.convert("L"))[row, 10:40].mean() / 255)


def test_the_background_follows_the_palette_and_is_no_void(found: Found, folder: Path) -> None:
    assert corner(folder, "plain", 10) > 0.75
    assert 0.07 < corner(folder, "dark", 10) < 0.25
    for name in ("plain", "dark"):
        assert abs(corner(folder, name, 10) - corner(folder, name, -100)) > 0.02


def test_the_legend_and_the_scale_bar_are_in_the_view(found: Found, folder: Path) -> None:
    for name, ink in (("plain", 0), ("dark", 230)):
        with Image.open(folder / f"{name}.png") as image:
            pixels = np.asarray(image.convert("RGB"))
        legend = pixels[:140, -120:].reshape(-1, 3) / 255
        for colour in (FRAME_COLOUR, *(level_colour(level, 4) for level in range(1, 5))):
            assert (np.abs(legend - colour).max(axis=1) < 0.02).sum() > 60
        bar = pixels[-50:-4, 5:200].astype(int)
        longest = max(int((np.abs(row - ink).max(axis=1) < 30).sum()) for row in bar)
        assert 50 < longest < 145


def test_keys_look_from_the_sides_at_one_scale_and_a_turn_brings_the_perspective_back(found: Found) -> None:
    perspective, above, south, turned, again, nearer, after_drag = found["sides"]
    assert perspective[2] > 0.5
    assert perspective[3] == 0
    assert above == again == nearer == [0, 0, 1, 1]
    assert south == [0, -1, 0, 1]
    assert turned[3] == 0
    assert after_drag == [0, 0, 0, 1]
    scales = found["metres per pixel"]
    assert scales[1] == pytest.approx(scales[4])
    assert scales[5] == pytest.approx(scales[4] / 1.2)


def test_a_large_map_is_shown_coarser_but_whole(found: Found, folder: Path) -> None:
    assert share(folder, "coarse", level_colour(4, 4)) > 0.01


def test_the_mouse_turns_the_map_and_up_stays_up(found: Found) -> None:
    assert found["turned"]


def test_keys_turn_the_map_and_come_nearer_and_up_stays_up(found: Found) -> None:
    keys = found["keys"]
    round_, up, away = keys[""]
    assert keys["left"] == pytest.approx([round_ + 10, up, away])
    assert keys["up"] == pytest.approx([round_ + 10, up + 10, away])
    assert keys["plus"] == pytest.approx([round_ + 10, up + 10, away / 1.2])
    assert keys["minus"] == pytest.approx([round_ + 10, up + 10, away])
    assert keys["down"] == pytest.approx(keys[""])
    assert keys["top"] == [0, 0, 1]


def test_a_click_tells_the_cell_and_a_drag_none(found: Found) -> None:
    assert found["clicks"] == [[20, 19], None]


def test_a_robot_stands_next_to_the_map_as_long_as_it_is_chosen(found: Found, folder: Path) -> None:
    names = ("robot", "no-robot", "before-robot")
    robot, without, before = (np.asarray(Image.open(folder / f"{name}.png")) for name in names)
    assert (robot != without).any(axis=2).mean() > 0.003
    assert (without != before).any(axis=2).mean() < 0.001


def test_a_picture_of_twice_the_size_shows_the_same_twice_as_large(found: Found, folder: Path) -> None:
    with Image.open(folder / "wide.png") as wide, Image.open(folder / "dark.png") as dark:
        assert wide.size == tuple(2 * side for side in found["picture"])
        small = np.asarray(wide.convert("RGB").resize(dark.size)).astype(float)
        assert np.abs(small - np.asarray(dark.convert("RGB")))[10:-10, 10:-10].mean() < 6


def test_the_view_looks_from_a_direction_that_was_kept(found: Found) -> None:
    assert found["along"]


def test_the_camera_stays_until_it_is_reset(found: Found) -> None:
    assert found["camera kept"]
    assert found["camera reset"]


def test_a_picture_that_cannot_be_written_is_refused_by_name(found: Found) -> None:
    assert "nowhere" in found["refused"]


def test_the_window_shows_the_example_in_every_part(found: Found, display: str, folder: Path) -> None:
    environment = {"DISPLAY": display, **ON_SCREEN, "HOME": str(folder)}
    command = [sys.executable, "-m", "docs.window", str(folder / "window.png")]
    subprocess.run(command, cwd=HERE.parents[2], env=os.environ | environment, timeout=MINUTES / 1000, check=True)
    for colour in (FRAME_COLOUR, BOX, *(level_colour(level, 4) for level in range(1, 5))):
        assert share(folder, "window", colour) > 0.0005


def test_without_a_display_the_view_says_why(tmp_path: Path) -> None:
    said = viewed(tmp_path, QT_QPA_PLATFORM="offscreen")
    assert "needs a display" in said["unavailable"]
    assert (tmp_path / "plain.png").exists()


def test_without_opengl_the_view_says_why(display: str, tmp_path: Path) -> None:
    said = viewed(tmp_path, DISPLAY=display, QT_QPA_PLATFORM="xcb", QT_XCB_GL_INTEGRATION="none")
    assert "needs OpenGL" in said["unavailable"]
    assert (tmp_path / "plain.png").exists()
