"""Features that a camera finds on blocks: corners, on a plateau too, where one colour gives it nothing to hold on to.

Judged by OpenCV's FAST detector on pictures of Gazebo Classic and of MuJoCo.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen import Matrix, Recipe

cv2 = pytest.importorskip("cv2", reason="opencv-python-headless is not installed")
pytestmark = pytest.mark.long(reason="a camera without a graphics card")

BLOCKS = 8
PLATEAU = Matrix.of(np.full((BLOCKS, BLOCKS), 2))
LEAST = {"levels": 4, "wood": 4}
"""Corners per block."""

RENDER = """
import sys
import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = mujoco.Renderer(model, 480, 640)
renderer.update_scene(data, camera="overview")
np.save(sys.argv[2], renderer.render())
"""


def plateau(look: str) -> Recipe:
    return Recipe(seed=1, chunk_size=BLOCKS, boundary="none", look=look, obstacles=(PLATEAU,))


def corners(grey: np.ndarray) -> float:
    """Corners per block in a picture."""
    return len(cv2.FastFeatureDetector.create(20).detect(grey)) / BLOCKS**2


def seen_in_gazebo(look: str, folder: Path) -> np.ndarray:
    output = folder / look
    rsegen.drive(
        plateau(look), simulator="classic", duration=1, contacts=False, predict=False, picture=True, output=output
    )
    return np.asarray(cv2.imread(str(output / "picture.jpg"), cv2.IMREAD_GRAYSCALE))


def seen_in_mujoco(look: str, folder: Path) -> np.ndarray:
    scene = rsegen.compose(plateau(look))
    rsegen.export(scene, folder / look, "mjcf")
    picture = folder / f"{look}.npy"
    model = next((folder / look).rglob("scene.xml"))
    subprocess.run([sys.executable, "-c", RENDER, str(model), str(picture)], check=True)
    return np.asarray(cv2.cvtColor(np.load(picture), cv2.COLOR_RGB2GRAY))


def check(found: dict[str, float]) -> None:
    assert found["plain"] < 2, "one flat colour, apart from the robot and the rim"
    for look, least in LEAST.items():
        assert found[look] > least


@pytest.mark.slow
@pytest.mark.usefixtures("gazebo_classic", "screen")
def test_a_camera_in_gazebo_classic_finds_several_corners_per_block(tmp_path: Path) -> None:
    check({look: corners(seen_in_gazebo(look, tmp_path)) for look in ("plain", *LEAST)})


@pytest.mark.slow
@pytest.mark.usefixtures("screen")
def test_a_camera_in_mujoco_finds_several_corners_per_block(tmp_path: Path) -> None:
    check({look: corners(seen_in_mujoco(look, tmp_path)) for look in ("plain", *LEAST)})
