"""A machine on which no simulator is, until a test puts stand-ins on its PATH."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from rsegen.cli.edge import main
from tests.simulators.standins import alone_on_path
from tests.simulators.transport import NEEDS_ENGINE, transport_world


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark what uses `sim_address` as long."""
    if "sim_address" in getattr(item, "fixturenames", ()):
        item.add_marker(NEEDS_ENGINE)


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder on PATH that stand-ins can be put into; no screen, no home, no variable of a simulator."""
    folder = alone_on_path(tmp_path, monkeypatch)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "GAZEBO_MASTER_URI", "GZ_PARTITION", "GZ_SIM_RESOURCE_PATH", "STAYS"):
        monkeypatch.delenv(name, raising=False)
    return folder


@pytest.fixture
def sim_address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Mapping[str, str]]:
    """The variables, which are set, of a world of Gazebo Sim's transport; the working folder is the test's own."""
    monkeypatch.chdir(tmp_path)
    with transport_world() as address:
        for name, value in address.items():
            monkeypatch.setenv(name, value)
        yield address


@pytest.fixture
def world(tmp_path: Path) -> Path:
    """The world of a map, in a folder whose name has to be quoted."""
    return generated(tmp_path / "my worlds")


@pytest.fixture
def classic_world(tmp_path: Path) -> Path:
    """One that only Gazebo Classic opens."""
    return generated(tmp_path / "worlds", "--simulator", "classic")


def generated(folder: Path, *flags: str) -> Path:
    row = ["--obstacle", "random levels=3", "--chunk-size", "2", "--seed", "1"]
    assert main(["generate", *row, *flags, "-o", str(folder)]) == 0
    return folder / "rse_0000" / "rse_0000.world"
