"""MuJoCo's warnings end a drive in one line; none is printed, or written into the current folder."""

from __future__ import annotations

import threading
from pathlib import Path

import mujoco
import pytest

import rsegen
from rsegen.errors import SimulatorFailed
from rsegen.mujoco import map_model
from rsegen.mujoco.log import without_log
from rsegen.mujoco.turning import turn_gain
from tests.mujoco.worlds import world_of


def writes_log() -> bool:
    config = mujoco.MjLogConfig.get()
    return bool(config.logto_console and config.logto_file)


@pytest.mark.parametrize("robot", ["burger", "crawler"])
def test_physics_that_fail_leave_no_log(
    robot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    world = world_of(robot)
    world.step(10)
    monkeypatch.chdir(tmp_path)
    world.data.qvel[0] = float("nan")
    with pytest.raises(SimulatorFailed, match=r"the physics failed after .* s \(Nan, Inf or huge value in Q") as error:
        world.step(100)
    assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
    assert writes_log()


@pytest.mark.parametrize("memory", ["1K", "60K"])
def test_too_little_memory_is_an_error_of_one_line(
    memory: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(map_model, "MEMORY", memory)
    monkeypatch.chdir(tmp_path)
    turn_gain.cache_clear()  # what is measured with so little memory is kept for no other test
    try:
        with pytest.raises(SimulatorFailed, match="memory") as error:
            rsegen.drive("large-random", robot="jackal", robots=5, duration=0.5)
    finally:
        turn_gain.cache_clear()
    assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_a_users_log_is_as_it_was_when_the_last_thread_ends() -> None:
    inside, go_on = threading.Event(), threading.Event()

    def simulate() -> None:
        with without_log():
            inside.set()
            go_on.wait()

    thread = threading.Thread(target=simulate)
    assert writes_log()
    thread.start()
    inside.wait()
    with without_log():
        assert not writes_log()
    assert not writes_log()
    go_on.set()
    thread.join()
    assert writes_log()
