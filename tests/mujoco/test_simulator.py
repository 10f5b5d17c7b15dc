"""Messages if MuJoCo is missing, too old, or taken away."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable

import pytest

import rsegen
from rsegen.errors import NoSimulator, UnknownName
from rsegen.mujoco.simulator import Mujoco
from rsegen.simulators.embedded import EMBEDDED, embedded_simulator

RECIPE = rsegen.Recipe(name="course", seed=1, chunk_size=2)


def test_its_version_is_that_of_its_wheel() -> None:
    assert Mujoco().version() == importlib.metadata.version("mujoco-core")
    assert str(Mujoco()) == f"MuJoCo {importlib.metadata.version('mujoco-core')}"


@pytest.mark.parametrize("found", [None, "3.10.0"])
def test_without_it_the_message_says_how_to_get_it_and_what_else_drives(
    found: str | None, monkeypatch: pytest.MonkeyPatch, refused: Callable[..., str]
) -> None:
    monkeypatch.setattr("rsegen.mujoco.simulator.find_spec", lambda _: found)
    monkeypatch.setattr("rsegen.mujoco.simulator.version", lambda _: found)
    line = refused("drive", "peak", "--robot", "crawler")
    old = f"mujoco-core {found} is installed, which is too old; to install MuJoCo 4: pip install -U 'mujoco-core>=4'"
    missing = "MuJoCo 4 is not installed; to install it: pip install 'mujoco-core>=4'"
    assert (old if found else missing) in line
    assert "Gazebo drives: choose the simulator sim or classic" in line
    with pytest.raises(NoSimulator, match="which is too old" if found else "many drives need MuJoCo"):
        rsegen.drive_many(RECIPE)


def test_names_are_those_of_all_simulators() -> None:
    assert embedded_simulator(None) is embedded_simulator("mujoco") is EMBEDDED["mujoco"]
    assert embedded_simulator("classic") is None
    with pytest.raises(UnknownName, match="unknown simulator 'mujocco'; did you mean 'mujoco'"):
        embedded_simulator("mujocco")


def test_without_the_capability_a_drive_asks_for_a_gazebo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rsegen.simulators.embedded.EMBEDDED", {})
    assert embedded_simulator(None) is None
