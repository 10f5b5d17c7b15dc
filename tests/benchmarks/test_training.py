"""The robot of the page of training sees the ground, is given rows, and needs to learn; the page has its program."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks import training
from docs.generate import DOCS

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
from benchmarks.rover import LENGTH, PATTERN, ROWS, RUBBLE, START, course


def _drive(row: int, number: int, action: tuple[float, ...] = (1, 0, 0, 0)) -> Any:
    """The robot at the end of an episode on a field of a row."""
    robot = course(RUBBLE, row)
    robot.reset(seed=1, options={"map": row + ROWS * number})
    over = False
    while not over:
        *_, terminated, truncated, _ = robot.step(np.array(action))
        over = terminated or truncated
    return robot


def test_the_robot_sees_the_heights_around_it() -> None:
    robot: Any = course(RUBBLE, 10)
    observation, info = robot.reset(seed=1, options={"map": 21})
    assert info["map"] == 21
    state = robot.unwrapped.data
    x, y, z = state.qpos[:3]
    assert observation[17:] == pytest.approx(5 * (robot.env.ground.heights(PATTERN + np.array([x, y])) - z), abs=1e-5)
    assert np.ptp(observation[17:]) > 0.1
    assert robot.observation_space.shape == observation.shape


@pytest.mark.slow
def test_full_speed_ahead_crosses_flat_ground_and_no_rubble() -> None:
    ((_, walked),) = _drive(0, 0).episodes
    assert walked > LENGTH
    far = [_drive(10, number).episodes[0][1] for number in range(8)]
    assert np.mean(far) < LENGTH / 2
    robot: Any = course(RUBBLE)
    assert (robot.unwrapped.init_qpos[0], training.COURSE) == (START, LENGTH)


@pytest.mark.slow
def test_a_robot_that_got_far_gets_a_harder_row_and_one_that_did_not_an_easier_one() -> None:
    robot = course(RUBBLE)
    for speed, row in ((1, 1), (0, 0), (0, 0)):
        robot.reset(seed=1)
        over = False
        while not over:
            *_, terminated, truncated, _ = robot.step(np.array([speed, 0, 0, 0]))
            over = terminated or truncated
        assert robot.row == row
    assert [row for row, _ in robot.episodes] == [0, 1, 0]


def test_the_page_shows_the_program_and_names_every_policy() -> None:
    text = (DOCS / "training.md").read_text("utf-8")
    assert f"```python\n{training.ROVER.read_text('utf-8')}```" in text
    assert all(f"| {title} |" in text for title in training.TITLES.values())


def test_a_missing_library_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(training, "find_spec", lambda name: None if name == "stable_baselines3" else name)
    assert training.main([]) == 1
    line = "stable_baselines3: not installed; pip install stable-baselines3 'gymnasium[mujoco]'\n"
    assert capsys.readouterr().out == line
