"""Each capability is a folder that can be taken away, and says what it needs."""

from __future__ import annotations

import ast
import importlib
import json
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import rsegen
from rsegen.params.capabilities import (
    CORE,
    Capability,
    Command,
    _problem,
    all_extras,
    capabilities,
    commands,
    public_names,
)
from tests.support.deletion import FOLDERS, environment, sources_without, with_dependants
from tests.support.long import long_unless

HOUSE = Path(rsegen.__file__).parent


@cache
def imports() -> list[tuple[str, str]]:
    """Return each import of a module of rsegen, in functions and for type checkers too: its module, what it imports."""
    found = list[tuple[str, str]]()
    for path in HOUSE.rglob("*.py"):
        module = ".".join(["rsegen", *path.relative_to(HOUSE).with_suffix("").parts]).removesuffix(".__init__")
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rsegen"):
                found += [(module, f"{node.module}.{name.name}") for name in node.names]
    return found


def folder_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def asked_by_another(capability: Capability) -> set[str]:
    """Modules that only another capability imports, by what this one declares: formats of it, calls of the page."""
    return {*capability.calls, *(module for offered in capability.offers.values() for module in offered.values())}


def test_every_folder_is_of_the_core_or_declares_itself() -> None:
    folders = {path.parent.name for path in HOUSE.glob("*/__init__.py")}
    assert folders == {*CORE, *FOLDERS}
    assert len(FOLDERS) > 10


@pytest.mark.parametrize("name", FOLDERS)
def test_a_capability_imports_those_that_it_needs_and_no_other(name: str) -> None:
    capability = capabilities()[name]
    used = {
        folder_of(imported)
        for module, imported in imports()
        if folder_of(module) == name and module not in asked_by_another(capability)
    }
    assert used & set(FOLDERS) - {name} == set(capability.needs)


def test_no_capability_needs_itself_by_way_of_others() -> None:
    needs = {name: capabilities()[name].needs for name in FOLDERS}
    assert len([*TopologicalSorter(needs).static_order()]) == len(FOLDERS)


def test_all_that_is_declared_is_there() -> None:
    for capability in capabilities().values():
        for command in capability.commands:
            module = importlib.import_module(command.module)
            assert callable(getattr(module, f"add_{command.name}"))
            assert callable(getattr(module, f"run_{command.name}"))
            assert not command.function or command.function in public_names()
        places = [capability.targets, capability.crossers, capability.predictor, capability.doctor, capability.notebook]
        for place in [*filter(None, places), *capability.sidecars, *capability.words.values()]:
            module_name, _, attribute = place.partition(":")
            assert hasattr(importlib.import_module(module_name), attribute), place
        manual = HOUSE.parents[1] / "docs" / f"{capability.manual}.md"
        assert not capability.manual or manual.is_file(), manual
    names = [command.name for capability in capabilities().values() for command in capability.commands]
    assert sorted(names) == sorted(commands())


def test_the_extras_are_those_of_the_package() -> None:
    text = (HOUSE.parents[1] / "pyproject.toml").read_text("utf-8")
    assert all(f"\n{name} = [" in text for name in all_extras())


TRIED = """
import contextlib, io, json, sys
import rsegen
from rsegen.cli.edge import main

def printed(*arguments):
    with contextlib.redirect_stdout(io.StringIO()) as text:
        try:
            code = main(arguments)
        except SystemExit as end:
            code = end.code
    assert code == 0, arguments
    return text.getvalue()

worlds = sys.argv[1]
print(json.dumps({
    "help": printed("--help"),
    "generate": printed("generate", "peak", "-o", worlds),
    "info": printed("info", worlds + "/peak_0000"),
    "doctor": printed("doctor"),
    "names": [name for name in rsegen.__all__ if getattr(rsegen, name) is not None],
    "house": rsegen.__file__,
}))
"""
"""Script that tries what is left, in one process: each start takes half a second."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    long_unless(
        {"page", "robots", "mujoco", "formats", "all"}.__contains__, [*FOLDERS, "all"], reason="another capability"
    ),
)
def test_what_is_left_works_without_a_capability(name: str, tmp_path: Path) -> None:
    gone = set(FOLDERS) if name == "all" else with_dependants([name])
    copy = sources_without(gone, tmp_path / "copy")
    command = [sys.executable, "-c", TRIED, str(tmp_path / "worlds")]
    run = subprocess.run(command, capture_output=True, text=True, cwd=copy, env=environment(copy), check=False)
    assert (run.returncode, run.stderr) == (0, "")
    left = json.loads(run.stdout)
    assert left["house"].startswith(str(copy))
    lost = {command.name for folder in gone for command in capabilities()[folder].commands}
    listed = {line.split()[0] for line in left["help"].splitlines() if line[:2] == "  " and line[2:3].isalpha()}
    assert listed == set(commands()) - lost
    assert "peak_0000.world" in left["generate"]
    assert (tmp_path / "worlds" / "peak_0000" / "peak_0000.world").is_file()
    assert "68.0%" in left["info"]
    assert "Extras" in left["doctor"]
    public = {name for folder in gone for names in capabilities()[folder].public.values() for name in names}
    assert set(left["names"]) == {"__version__", *public_names()} - public


def test_a_command_of_another_package_may_not_take_the_name_of_one_of_rsegen() -> None:
    taken = Capability(summary="", commands=(Command("drive", "drive a robot", "", "elsewhere"),))
    assert _problem("other", taken, capabilities()) == "the command 'drive' is taken"
    twice = (Command("fly", "drive a robot", "", "elsewhere"),) * 2
    assert _problem("other", Capability(summary="", commands=twice), capabilities()) == "the command 'fly' is taken"


@pytest.mark.parametrize(
    ("complaint", "offered"),
    {
        "3 is not a rsegen.params.capabilities.Capability": 3,
        "it needs 'wings', which is not here": Capability(summary="", needs=("wings",)),
        "its field 'needs' is not a tuple of str": Capability(summary="", needs="pictures"),  # type: ignore[arg-type]
        "its field 'commands' is not a tuple of Command": Capability(summary="", commands=("fly",)),  # type: ignore[arg-type]
        "its field 'public' is a tuple": Capability(summary="", public=("fly",)),  # type: ignore[arg-type]
        "its field 'doctor' is a NoneType": Capability(summary="", doctor=None),  # type: ignore[arg-type]
        "is not a command": Capability(summary="", commands=(Command("--fly", "measure", "", "elsewhere"),)),
    }.items(),
)
def test_what_another_package_declares_is_checked_before_it_is_used(complaint: str, offered: object) -> None:
    assert complaint in _problem("other", offered, capabilities())


def test_the_name_of_a_capability_may_not_be_taken() -> None:
    assert "the capability 'pictures' exists already" in _problem("pictures", Capability(summary=""), capabilities())
