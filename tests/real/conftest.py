"""The simulators that judge: where one is missing its tests are skipped; with CI=true they fail, but for Gazebo Sim."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NoReturn

import pytest

from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.process import command_output
from tests.simulators.conftest import classic_world, programs, pytest_itemcollected, sim_address, world
from tests.support.missing import missing
from tests.support.screen import xvfb

__all__ = ["classic_world", "programs", "pytest_itemcollected", "sim_address", "world"]

CHECKERS = (("ign", "sdf", "--check"), ("gz", "sdf", "--check"))
"""Commands of libsdformat 12 and later; Gazebo Classic's own `gz sdf` reads its old dialect and is not asked."""


@pytest.fixture(scope="session", params=["classic", "sim"])
def gazebo(request: pytest.FixtureRequest) -> Installation:
    """Each Gazebo of this machine in turn."""
    found: Installation = request.getfixturevalue(f"gazebo_{request.param}")
    return found


@pytest.fixture(scope="session")
def gazebo_classic() -> Installation:
    """The Gazebo Classic 11 of this machine."""
    return SIMULATORS["classic"].installation() or missing("no Gazebo Classic 11: run scripts/gazebo-classic")


@pytest.fixture(scope="session")
def gazebo_sim() -> Installation:
    """The Gazebo Sim of this machine."""
    return SIMULATORS["sim"].installation() or missing_sim()


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A virtual screen, on which cameras of simulators and of MuJoCo render."""
    with xvfb() as number:
        for name, value in {"LIBGL_ALWAYS_SOFTWARE": "1", "DISPLAY": number, "MUJOCO_GL": "glfw"}.items():
            monkeypatch.setenv(name, value)
        yield


@pytest.fixture(scope="session")
def sdf_checker(tmp_path_factory: pytest.TempPathFactory) -> Sequence[str]:
    """The command by which libsdformat checks a file."""
    empty = tmp_path_factory.mktemp("sdf") / "empty.sdf"
    empty.write_text('<sdf version="1.6"/>\n')
    found = (checker for checker in CHECKERS if "Valid" in command_output([*checker, empty]))
    return next(found, None) or missing("no libsdformat 12: run scripts/sdformat")


@pytest.fixture(scope="session")
def check_sdf(sdf_checker: Sequence[str]) -> Callable[[Path], str]:
    """Output of libsdformat for a file."""
    return lambda path: command_output([*sdf_checker, path])


@pytest.fixture(scope="session")
def print_sdf(sdf_checker: Sequence[str]) -> Callable[[Path], str]:
    """A file as libsdformat reads it, also a URDF."""
    return lambda path: command_output([*sdf_checker[:-1], "--print", path])


def missing_sim() -> NoReturn:
    """Skip, in CI too: no system that it runs on has packages of it."""
    pytest.skip("no Gazebo Sim: scripts/gazebo-sim says how to install one")
