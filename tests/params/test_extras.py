"""The command that installs what is missing."""

from __future__ import annotations

import shlex
import sys
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from rsegen.params.capabilities import all_extras
from rsegen.params.extras import pip_install, requirements

ROOT = Path(__file__).parents[2]


def test_the_libraries_of_extras_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    declared = project["optional-dependencies"]
    declared.pop("all")
    assert {name: sorted(needed) for name, needed in requirements().items() if name not in ("", "all")} == {
        name: sorted(needed) for name, needed in declared.items()
    }


def test_a_message_never_asks_an_index_for_rsegen() -> None:
    for extra in all_extras().values():
        _, _, _, install, *wanted = shlex.split(pip_install([extra.name]))
        assert install == "install"
        assert wanted == requirements()[extra.name]


def test_libraries_of_several_extras_are_named_once() -> None:
    wanted = shlex.split(pip_install(["mesh", "scan", "mesh"]))[4:]
    assert sorted(set(wanted)) == sorted(wanted)


def test_without_an_installation_it_is_the_folder_that_rsegen_runs_from(monkeypatch: pytest.MonkeyPatch) -> None:
    def not_installed(_: str) -> list[str]:
        raise PackageNotFoundError

    monkeypatch.setattr("importlib.metadata.requires", not_installed)
    assert shlex.split(pip_install(["mesh", "usd"])) == [sys.executable, "-m", "pip", "install", f"{ROOT}[mesh,usd]"]
