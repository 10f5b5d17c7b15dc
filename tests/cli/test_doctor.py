"""`rsegen doctor`: what is here and what is missing, however disordered the machine is."""

from __future__ import annotations

import json
import re
import sys
from importlib.metadata import PackageNotFoundError
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.params import extras
from rsegen.params.capabilities import all_extras
from rsegen.params.extras import pip_install
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED
from tests.simulators.standins import PROGRAMS, alone_on_path, put

Capture = pytest.CaptureFixture[str]
PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def report(capsys: Capture) -> str:
    capsys.readouterr()
    assert main(["doctor"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def summary(capsys: Capture) -> dict[str, Any]:
    assert main(["doctor", "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def remedies(capsys: Capture) -> dict[str, str]:
    return {row["what"]: row["remedy"] for row in summary(capsys)["missing"]}


def test_extras_match_the_package() -> None:
    section = PYPROJECT.read_text("utf-8").partition("[project.optional-dependencies]")[2].partition("\n[")[0]
    assert set(re.findall(r"^(\w+) = \[", section, re.MULTILINE)) == {extra.name for extra in all_extras().values()} | {
        "all"
    }


@pytest.mark.slow
def test_versions_match_the_imported_packages(capsys: Capture) -> None:
    found = summary(capsys)
    assert found["rsegen"] == rsegen.__version__
    assert found["libraries"]["numpy"] == np.__version__
    assert found["executable"] == sys.executable
    assert {"matplotlib", "pyyaml", "pyzmq"} <= found["libraries"].keys()
    text = report(capsys)
    assert f"rsegen      {rsegen.__version__}\n" in text
    assert f"numpy {np.__version__}" in text


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
def test_simulators_are_found_with_version_and_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    programs = alone_on_path(tmp_path, monkeypatch)
    put(programs, PROGRAMS["classic"])
    assert f"  Gazebo Classic 11.14.0\n    gzserver: {programs}/gzserver\n" in report(capsys)
    mujoco, sim, classic = summary(capsys)["simulators"]
    assert (mujoco["name"], mujoco["version"]) == ("mujoco", EMBEDDED["mujoco"].version())
    assert (sim["version"], classic["version"]) == (None, "11.14.0")
    assert remedies(capsys)["Gazebo Sim: worlds cannot be opened in it"] in SIMULATORS["sim"].how_to_install
    assert not (programs / "gzserver.started").exists()


@pytest.mark.slow
def test_a_missing_extra_is_reported_with_its_use_and_install_command(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name in ("scipy", "pxr") else find_spec("numpy"))
    found = remedies(capsys)
    assert found["scipy: MATLAB files of the formats arrays and posture"] == pip_install(["mat"])
    assert found["pxr: the format usd"] == pip_install(["usd"])
    assert {row["name"]: row["missing"] for row in summary(capsys)["extras"]}["usd"] == ["pxr"]


@pytest.mark.slow
def test_without_any_extra_the_report_is_printed(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    text = report(capsys)
    assert all(pip_install([extra.name]) in text for extra in all_extras().values())
    assert "\nExtras\n  none\n\nMissing\n" in text


@pytest.mark.slow
def test_what_is_missing_is_listed_once(monkeypatch: pytest.MonkeyPatch, capsys: Capture, tmp_path: Path) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name in ("scipy", "pxr") else find_spec("numpy"))
    alone_on_path(tmp_path, monkeypatch)
    text = report(capsys)
    installed, missing = text.split("\nMissing\n")
    for extra in all_extras().values():
        is_missing = extra.name in ("mat", "usd")
        assert (extra.use in installed, extra.use in missing) == (not is_missing, is_missing)
    for title in ("Gazebo Sim", "Gazebo Classic"):
        assert title not in installed
        assert missing.count(f"  {title}: ") == 1


def test_a_simulator_that_breaks_is_a_line(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def broken(self: object) -> None:
        raise RuntimeError("no\nway")

    monkeypatch.setattr(type(SIMULATORS["sim"]), "installation", broken)
    assert "  Gazebo Sim: RuntimeError: no way\n" in report(capsys)


@pytest.mark.slow
def test_without_package_metadata_the_report_is_printed(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def not_installed(_: str) -> list[str]:
        raise PackageNotFoundError

    monkeypatch.setattr("importlib.metadata.requires", not_installed)
    assert summary(capsys)["libraries"] == {"numpy": np.__version__}
