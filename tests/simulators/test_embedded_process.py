"""A world in a process of its own runs by the clock between requests, and ends with the program that has started it."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

import rsegen
from rsegen.errors import SimulatorFailed
from rsegen.robots.lookup import robot_of
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.embedded_process import EmbeddedProcess, Task, world_in_process
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.simulators.process import usage

FLAT = rsegen.Recipe(name="flat", boundary="none")


@contextmanager
def started(*, is_real: bool = False, z: float = DROP_HEIGHT) -> Iterator[EmbeddedProcess]:
    start = Pose(x=0, y=0, z=z)
    placed = PlacedRobot(name="one", robot=robot_of("crawler"), start=start)
    task = Task(simulator="mujoco", recipe=FLAT, robots=[placed], is_real=is_real)
    with world_in_process(task) as world:
        yield world


def test_it_is_paused_until_it_is_told_and_then_simulates_as_fast_as_it_can() -> None:
    with started() as world:
        time.sleep(0.3)
        clock = world.clock()
        assert (clock.simulated, clock.real, clock.paused) == (0.0, 0.0, True)
        world.drive("one", robot_of("crawler"), 0.2, 0.0)
        world.unpause()
        time.sleep(1.0)
        assert not world.clock().paused
        world.pause()
        clock = world.clock()
        assert clock.simulated > 1.2
        assert clock.steps == round(1000 * clock.simulated)
        assert world.poses()["one"].x == pytest.approx(0.2 * clock.simulated, rel=0.15)
        time.sleep(0.2)
        assert world.clock() == clock
        world.step(100)
        assert world.clock().simulated == pytest.approx(clock.simulated + 0.1)
        assert world.last_poses()[1] == world.poses()


def test_in_real_time_it_keeps_to_the_clock() -> None:
    with started(is_real=True) as world:
        for _ in range(2):  # also after a pause
            world.unpause()
            time.sleep(0.6)
            world.pause()
            time.sleep(0.3)
        clock = world.clock()
        assert clock.real >= 1.2
        assert clock.simulated == pytest.approx(clock.real, abs=0.3)  # on a busy machine


def test_its_process_has_a_cost_of_its_own_and_ends_with_the_world() -> None:
    with started() as world:
        before = usage(world.pid)
        assert before.memory > 20
        world.step(2000)
        assert usage(world.pid).cpu > before.cpu
        assert world.pid != os.getpid()
    with pytest.raises(SimulatorFailed):
        usage(world.pid)


def test_a_world_that_cannot_be_loaded_is_a_failure() -> None:
    with pytest.raises(SimulatorFailed, match="no robot can start there"), started(z=-0.1):
        pass


def test_a_process_that_is_gone_is_a_failure() -> None:
    with started() as world:
        world._process.kill()
        world._process.wait()
        with pytest.raises(SimulatorFailed, match="the process of the simulator has ended"):
            world.clock()
