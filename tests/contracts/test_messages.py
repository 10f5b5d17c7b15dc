"""Contract of all messages: in Python it recommends arguments, in a shell flags."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from inspect import Parameter, signature, unwrap
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen.cli.command_line import parser_of
from rsegen.cli.edge import in_flags
from rsegen.errors import UserError
from rsegen.params.capabilities import commands
from rsegen.params.command import declared

SOURCES = Path(rsegen.__file__).parent
FLAG = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
FUNCTIONS: list[Callable[..., Any]] = [
    found for name in dir(rsegen) if callable(found := getattr(rsegen, name)) and hasattr(found, "__wrapped__")
]
"""The public commands."""

ARGUMENTS = [(function, name) for function in FUNCTIONS for name in declared(function)]

COMMAND_LINES = {
    "formats/heightmap.py": "a command line that reads the image again, to be copied",
    "build_sheets/overview.py": "a printed page",
    "build_sheets/timber.py": "a printed page",
    "page/command_forms.py": "command lines that the page runs",
    "page/runs.py": "command lines that the page runs",
    "page/model/texts.py": "the command line of a recipe, to be copied",
    "rating/rating.py": "command lines that drive a trial again, to be copied",
    "experiments/run.py": "the command line of an experiment, in its report",
}
"""Files of the library that write flags of rsegen on purpose."""


RECIPE = rsegen.Recipe(seed=1, maps=2, obstacles=[rsegen.Peak(levels=5)])


class Wrong:
    """A value that no parameter takes."""

    def __repr__(self) -> str:
        return "wrong"


@pytest.mark.parametrize(("function", "name"), ARGUMENTS, ids=[f"{f.__name__}-{name}" for f, name in ARGUMENTS])
def test_a_wrong_argument_is_named_as_in_python(
    function: Callable[..., Any], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = signature(unwrap(function)).parameters.values()
    given: dict[str, Any] = {each.name: RECIPE for each in arguments if each.default is Parameter.empty}
    given.pop("options", None)
    given.pop("names", None)
    given |= {place: "out" for place in ("folder", "output", "path") if place in given}
    given |= {"plan": "quick"} if "plan" in given else {}
    given |= {"recipes": [RECIPE], "formats": []} if "recipes" in given else {}
    with pytest.raises(UserError) as refused:
        function(**given | {name: Wrong()})
    assert str(refused.value).startswith(name.strip("_"))
    assert not FLAG.search(str(refused.value))
    assert not any(tmp_path.iterdir())


@cache
def texts() -> tuple[tuple[str, str], ...]:
    """Return each text of the library that is no docstring, with its file; help texts of flags are of the shell."""
    return tuple(_texts())


def _texts() -> Iterator[tuple[str, str]]:
    for file in sorted(SOURCES.rglob("*.py")):
        name = file.relative_to(SOURCES).as_posix()
        if name.startswith("cli/") or file.name in ("commands.py", "parameters.py", "flags.py"):
            continue  # the command line, which has flags
        tree = ast.parse(file.read_text("utf-8"))
        alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        helps = {
            id(part)
            for node in ast.walk(tree)
            if (isinstance(node, ast.keyword) and node.arg == "help")
            or (isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("Shell", "FormatList", "Extra"))
            or (isinstance(node, ast.Assign | ast.AnnAssign) and _name(node) in ("flag", "help"))
            for part in ast.walk(node)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone | helps:
                yield name, node.value


def _name(node: ast.Assign | ast.AnnAssign) -> str:
    """Return the name that is assigned to, if it is one."""
    return getattr(node.target if isinstance(node, ast.AnnAssign) else node.targets[0], "id", "")


@pytest.mark.slow
def test_no_text_of_the_library_has_a_flag() -> None:
    flags = {flag for name in commands() for action in parser_of(name).actions for flag in action.option_strings}
    found = {(name, flag) for name, text in texts() for flag in FLAG.findall(text) if flag in flags and " " in text}
    assert {(name, flag) for name, flag in found if name not in COMMAND_LINES} == set()


def test_no_message_says_give() -> None:
    """Messages say what to pass, set, choose or use; files of a ROS 2 package and build sheets keep their bytes."""
    of_files = {SOURCES / "build_sheets" / name for name in ("overview.py", "timber.py")} | {
        *SOURCES.glob("ros2/**/*.py")
    }
    files = sorted({*SOURCES.rglob("*.py")} - of_files)
    advice = re.compile(r"(?:^|[;:.] |\bor )[Gg]ive\b")
    said = {
        (file.name, node.value)
        for file in files
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\n" not in node.value
        if advice.search(node.value) and not node.value.endswith(".")  # docstrings of one line end so
    }
    assert len(files) > 200
    assert said == set()


@pytest.mark.slow
def test_advice_names_parameters_that_some_command_declares() -> None:
    known = {parameter.strip("_") for function in FUNCTIONS for parameter in declared(function)}
    advice = re.compile(r"\b(?:give|set|use|with|by|or) (\w+)=(?:True\b|'|\[)")
    found = {name for _, text in texts() for name in advice.findall(text)}
    assert {"force", "resume", "tracks", "wheels"} <= found <= known | {"shape"}  # of a format, as a text of a shell


@pytest.mark.parametrize(
    ("message", "command", "in_shell"),
    [
        ("use force=True to replace it", "generate", "use --force to replace it"),
        ("use force=True to replace it", None, "use force=True to replace it"),
        ("name them with tracks='LEFT,RIGHT'", "drive", "name them with --tracks LEFT,RIGHT"),
        ("use by='reach.west_east.cost', or", "series", "use --by reach.west_east.cost, or"),
        ("set output='DIR', or at=[X, Y, Z]", "spawn", "set --output DIR, or --at X,Y,Z"),
        ("as with rsegen.open('DIR')", "spawn", "as with rsegen open DIR"),
        ("as with rsegen.open('DIR', shared=True)", "spawn", "as with rsegen open DIR --shared"),
        ("load it by rsegen.load_plugin('ramp.py')", "info", "load it by --plugin ramp.py"),
        ("'peak levels=5 seed=3': unknown", "generate", "'peak levels=5 seed=3': unknown"),
        ("use rsegen.robot_of('burger')", "series", "use rsegen.robot_of('burger')"),
    ],
)
def test_a_shell_gets_flags(message: str, command: str | None, in_shell: str) -> None:
    assert in_flags(message, command) == in_shell
