"""What is wrong gets one clear line and an exit code, leaves nothing half written and costs nothing that was there.

Exit code 2: the user's mistake, told before anything is tried; 1: the machine failed, or was told to stop.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest

import rsegen
from rsegen import KINDS, Placement, Recipe, writer
from rsegen.cli import COMMANDS, main
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.params import Choice, Parameter, Real, Text, Whole, parameters
from rsegen.places import AtCell, Pair

MANY_DIGITS = int("9" * 400)
MORE_DIGITS_THAN_PYTHON_WRITES = 1 << 20_000
OBSTACLE = ["--obstacle", "random max_height=5", "--seed", "7"]
NO_WORD = "xyz"
LISTS = [f", &{one} [{', '.join([f'*{below}'] * 10)}]" for below, one in pairwise("abcdefghi")]
BOMB = f"description: [&a [x, x]{''.join(LISTS)}]\n"
"""A few hundred bytes of YAML that stand for 10^8 lists."""


class Refused(Protocol):
    """Runs a command that is to be refused, and gives its one line of complaint."""

    def __call__(self, *arguments: str | Path) -> str: ...


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Refused:
    """Inside `tmp_path`: exit code 2, quickly; one line on stderr and none on stdout; and everything is as it was."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str | Path) -> str:
        capsys.readouterr()
        before, start = snapshot(tmp_path), time.monotonic()
        assert exit_code(*arguments) == 2
        assert time.monotonic() - start < 10
        assert snapshot(tmp_path) == before
        out, err = capsys.readouterr()
        assert out == ""
        return the_line(err)

    return run


def exit_code(*arguments: str | Path) -> object:
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as end:
        return end.code


def the_line(err: str) -> str:
    """The one line that is on stderr, short enough to be read."""
    assert err.endswith("\n")
    assert err.count("\n") == 1, err
    assert err.startswith("rsegen")
    assert "Traceback" not in err
    assert "mistake in rsegen" not in err
    assert len(err) < 1000
    return err.strip()


def snapshot(folder: Path) -> dict[str, bytes | None]:
    """Everything in a folder, hidden things and links too."""
    paths = sorted(folder.rglob("*"))
    plain = {path for path in paths if path.is_file() and not path.is_symlink()}
    return {str(path.relative_to(folder)): path.read_bytes() if path in plain else None for path in paths}


def recipe(content: str | bytes, name: str = "recipe.yaml") -> Path:
    path = Path(name)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


# Every parameter that there is, by the sort of value that it takes.


def wrong_values(parameter: Parameter) -> Iterator[object]:
    """What a file may give that no parameter of this sort takes."""
    yield from (True, NO_WORD, {}, {"a": [1]}, [[[[1]]]], math.nan, math.inf, -math.inf)
    match parameter:
        case Whole(low=low, high=high):
            yield from (low - 1, low + 0.5, str(low), -MANY_DIGITS)
            yield from () if high is None else (high + 1, MANY_DIGITS, 1e300)
        case Real(low=low, high=high):
            yield from (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), str(low), MANY_DIGITS)
        case Choice():
            yield from ("", 1, [])
        case Text():
            yield from (1, 2.5, "x\n", "\n", "\0", "\ud800", "x" * 501)
        case AtCell():
            yield from (1, 1.5, [], [1], [1, 2, 3], [0, -1], [0, 0.5], [0, True], [0, None], [0, "1"], "random,random")
        case Pair():
            yield from (0, -1, 1.5, 10**9 + 1, MANY_DIGITS, "2", "2x2", [], [1], [1, 2, 3], [1, 0], [1, True])
        case _:
            yield from (1, [], "1,2", [1, -1], [1, math.nan], [1, math.inf], [1, True], [1, "2"], [1, None], [0] * 5)


def wrong_texts(parameter: Parameter) -> Iterator[str]:
    """What a flag may give that no parameter of this sort takes."""
    yield ""
    match parameter:
        case Whole(low=low, high=high):
            yield from (
                str(low - 1),
                f"{low}.5",
                f"{low}.0",
                "1e3",
                "nan",
                "inf",
                "0x10",
                "1_0",
                NO_WORD,
                "-" + "9" * 9000,
            )
            yield from () if high is None else (str(high + 1), "9" * 9000)
        case Real(low=low, high=high):
            yield from (str(low - 1), str(high + 1), "nan", "inf", "-inf", "1e400", "-1e400", "1,5", NO_WORD)
        case Choice(values=values):
            yield from (NO_WORD, values[0].upper(), f"{values[0]} ", ",".join(values))
        case Text():
            yield from ("x\n", "a\nb", "\x1b[31m", "\udcff", "x" * 501)
        case Pair():
            yield from ("0", "-1", "2x0", "2x", "x", "1x2x3", "2.5", "2 x 2", NO_WORD, "9" * 9000, "9" * 9000 + "x1")
        case _:
            yield from (NO_WORD, "1;2", "nan,nan", ",", "-1,-1", "1.5,x")


def right(parameter: Parameter) -> str:
    """What the complaint must say, whichever the value."""
    return parameter.describe() if isinstance(parameter, (Whole, Real, Choice, Text, Pair)) else ""


def cases(owner: type, wrong: Callable[[Parameter], Iterator[object]]) -> list[Any]:
    """(name, value) for every parameter of a class."""
    return [
        pytest.param(name, value, id=f"{name}-{ascii(value)[:30]}")
        for name, parameter in parameters(owner).items()
        for value in wrong(parameter)
        if not (name == "description" and value in ("", NO_WORD)) and not (name in ("name", "key") and value == NO_WORD)
    ]


def rows(wrong: Callable[[Parameter], Iterator[object]]) -> list[Any]:
    """(kind, name, value) for every parameter of every kind, and for those of its place."""
    return [
        pytest.param(kind, *case.values, id=f"{kind}-{case.id}")
        for kind, cls in KINDS.items()
        for case in [*cases(cls, wrong), *(cases(Placement, wrong) if kind == "peak" else [])]
    ]


@pytest.mark.parametrize(("name", "value"), cases(Recipe, wrong_values))
def test_a_global_parameter_in_a_file(refused: Refused, name: str, value: object) -> None:
    line = refused("generate", recipe(json.dumps({name: value}), "recipe.json"), "-o", "out")
    assert line.startswith(f"rsegen: recipe.json: {name}: ")
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize(("name", "text"), cases(Recipe, wrong_texts))
def test_a_global_parameter_as_a_flag(refused: Refused, name: str, text: str) -> None:
    line = refused("generate", f"--{name.replace('_', '-')}={text}", "-o", "out")
    assert line.startswith(f"rsegen: {name}: ")
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize("name", parameters(Recipe))
def test_a_key_with_nothing_after_it(refused: Refused, name: str) -> None:
    line = refused("info", recipe(f"{name}:\n"))
    assert line.startswith(f"rsegen: recipe.yaml: {name}: nothing ")
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize(("kind", "name", "value"), rows(wrong_values))
def test_a_parameter_of_an_obstacle_in_a_file(refused: Refused, kind: str, name: str, value: object) -> None:
    content = {"obstacles": [{"kind": "peak", "max_height": 2}, {"kind": kind, "max_height": 5} | {name: value}]}
    line = refused("generate", recipe(json.dumps(content), "recipe.json"), "-o", "out")
    assert line.startswith(f"rsegen: recipe.json: obstacles[1].{name}")
    assert right({**parameters(Placement), **parameters(KINDS[kind])}[name]) in line


@pytest.mark.parametrize(("kind", "name", "text"), rows(wrong_texts))
def test_a_parameter_of_an_obstacle_as_a_flag(refused: Refused, kind: str, name: str, text: str) -> None:
    given = "" if name == "max_height" else "max_height=5 "
    line = refused("generate", "--obstacle", f"{kind} {given}'{name}={text}'", "-o", "out")
    assert f": {name}" in line
    assert right({**parameters(Placement), **parameters(KINDS[kind])}[name]) in line


# What stands in no single parameter.

OBSTACLES: Mapping[str, tuple[str, Sequence[str]]] = {
    "nothing": ("", ["give a kind and then KEY=VALUE"]),
    "a misspelt kind": ("peek max_height=5", ["'peek'", "did you mean 'peak'?", *KINDS]),
    "a kind of another world": ("volcano max_height=5", ["'volcano'", *KINDS]),
    "a misspelt parameter": ("peak max_hight=5", ["'max_hight'", "did you mean 'max_height'?", "softness", "first"]),
    "another kind's parameter": ("peak max_height=5 weights=1,2", ["'weights'", "parameter of peak", "softness"]),
    "no height": ("peak", ["max_height: is missing", "2..32767"]),
    "no equals sign": ("peak max_height", ["'max_height' is not KEY=VALUE"]),
    "spaces round the equals sign": ("peak max_height = 5", ["'max_height' is not KEY=VALUE"]),
    "a parameter twice": ("peak max_height=5 max_height=6", ["max_height: is given twice"]),
    "a kind twice": ("peak kind=random max_height=5", ["kind: is given twice"]),
    "an open quotation mark": ("peak 'max_height=5", ["KEY=VALUE"]),
    "ends that share no coordinate": (
        "horizontal_barrier max_height=5 first=1,2 last=3,4",
        ["last: first [1, 2] and last [3, 4] share neither x nor y"],
    ),
    "a cell beyond the map": ("peak max_height=5 first=0,10", ["obstacles[0].first[1]: 10 is outside 0..9"]),
    "a cell very far beyond it": ("peak max_height=5 last=" + "9" * 4000 + ",0", ["last[0]", "is outside 0..9"]),
    "too few weights": ("random max_height=3 weights=1,2", ["weights: 2 weights for 3 levels"]),
    "too many weights": ("random max_height=3 weights=1,2,3,4", ["weights: 4 weights for 3 levels"]),
    "weights of nothing": ("random max_height=3 weights=0,0,0", ["weights: all weights are 0"]),
}


@pytest.mark.parametrize(("text", "words"), OBSTACLES.values(), ids=OBSTACLES)
def test_an_obstacle_as_a_flag(refused: Refused, text: str, words: Sequence[str]) -> None:
    line = refused("generate", "--obstacle", text, "-o", "out")
    assert [word for word in words if word not in line] == []


YAML: Mapping[str, tuple[str | bytes, Sequence[str]]] = {
    "empty": ("", ["nothing is not a recipe", "obstacles:"]),
    "a comment only": ("# to do\n", ["nothing is not a recipe"]),
    "a list": ("- kind: peak\n", ["is not a recipe", "give keys"]),
    "a word": ("hello\n", ["'hello' is not a recipe"]),
    "an unknown key": ("sneed: 1\n", ["unknown key 'sneed'", "did you mean 'seed'?", *parameters(Recipe)]),
    "a key that is a number": ("1: 2\n", ["unknown key 1"]),
    "a key that is a list": ("? [1]\n: 2\n", ["recipe.yaml:1:3", "unhashable key"]),
    "a key of two lines": ('"a\\nb": 1\n', ["'a\\nb'"]),
    "a key of many letters": (f"{'k' * 900}: 1\n", ["unknown key 'kkk"]),
    "a key that stands twice": ("seed: 1\nmaps: 1\nseed: 2\n", ["recipe.yaml:3", "'seed' stands twice"]),
    "a key twice in a row": (
        "obstacles:\n  - kind: peak\n    kind: random\n    max_height: 3\n",
        ["recipe.yaml:3", "'kind' stands twice"],
    ),
    "a merge key": ("<<: {seed: 1}\n", ["'<<' is not read here", "write the keys out"]),
    "obstacles that are no list": ("obstacles: {kind: peak}\n", ["obstacles: ", "is not a list", "'- kind: '"]),
    "obstacles that are nothing": ("obstacles:\n", ["obstacles: nothing is not a list"]),
    "an obstacle that is a word": ("obstacles: [peak]\n", ["obstacles[0]: 'peak' is not an obstacle", "give kind:"]),
    "an obstacle that is nothing": ("obstacles: [null]\n", ["obstacles[0]: nothing is not an obstacle"]),
    "an obstacle without a kind": ("obstacles: [{max_height: 3}]\n", ["obstacles[0].kind: is missing", *KINDS]),
    "a kind that is a list": ("obstacles: [{kind: [peak], max_height: 3}]\n", ["obstacles[0].kind", *KINDS]),
    "two obstacles of one key": (
        "obstacles: [{kind: peak, max_height: 3, key: a}, {kind: peak, max_height: 3, key: a}]\n",
        ["obstacles[1].key: 'a' is another obstacle's key too"],
    ),
    "a cell beyond the map": (
        "chunks: [1, 2]\nobstacles: [{kind: peak, max_height: 3, first: [0, 19], last: [10, 0]}]\n",
        ["obstacles[0].last[0]: 10 is outside 0..9"],
    ),
    "a format of the future": ("version: 2\n", ["version: 2 is outside 1"]),
    "a date": ("seed: 2022-02-02\n", ["seed: datetime.date(2022, 2, 2) is not a whole number"]),
    "a date that is none": ("seed: 2022-13-45\n", ["month must be in 1..12"]),
    "binary content": ("seed: !!binary aGVsbG8=\n", ["seed: b'hello' is not a whole number"]),
    "an object of Python": (
        "!!python/object/apply:os.mkdir [owned]\n",
        ["recipe.yaml:1:1", "not YAML", "python/object"],
    ),
    "an object in a value": ("seed: !!python/object/apply:os.mkdir [owned]\n", ["recipe.yaml:1:7", "not YAML"]),
    "a tag that lies": ("maps: !!bool maybe\n", ["not YAML: a value is not what its tag says"]),
    "another tag that lies": ("maps: !!timestamp now\n", ["not YAML: a value is not what its tag says"]),
    "a map that is a list": ("!!map [1]\n", ["recipe.yaml:1:1", "expected a mapping"]),
    "a letter that is none": ('name: "\\UFFFFFFFF"\n', ["not YAML"]),
    "too many digits": (f"seed: {'9' * 9000}\n", ["not YAML", "4300"]),
    "too many digits in base 16": (f"seed: 0x{'f' * 9000}\n", ["seed: a number of thousands of digits is outside 0.."]),
    "a cell of too many digits": (
        f"obstacles: [{{kind: peak, max_height: 3, first: [0x{'f' * 9000}, 0]}}]\n",
        ["obstacles[0].first[0]: a number of thousands of digits is outside 0..9"],
    ),
    "wrong indentation": ("obstacles:\n - kind: peak\n  max_height: 3\n", ["recipe.yaml:3:3: not YAML"]),
    "a tab": ("obstacles:\n\t- kind: peak\n", ["recipe.yaml:2:1: not YAML"]),
    "an open bracket": ("obstacles: [", ["recipe.yaml:1:13: not YAML"]),
    "two documents": ("seed: 1\n---\nseed: 2\n", ["recipe.yaml:2:1: not YAML"]),
    "an alias of nothing": ("seed: *a\n", ["recipe.yaml:1:7: not YAML", "'a'"]),
    "itself": ("&a {obstacles: [*a]}\n", ["obstacles[0].kind: is missing"]),
    "itself as a list": ("obstacles: &a [*a]\n", ["obstacles[0]: [[", "is not an obstacle"]),
    "deep nesting": (f"obstacles: {'[' * 600}{']' * 600}\n", ["nested too deeply"]),
    "deep nesting of keys": ("{a: " * 3000, ["nested too deeply"]),
    "a bomb": (BOMB, ["description: [[", "give one line of up to 500 characters"]),
    "a bomb as a kind": (f"{BOMB}obstacles: [{{kind: *i, max_height: 3}}]\n", ["obstacles[0].kind", *KINDS]),
    "a bomb as a place": (f"{BOMB}obstacles: [{{kind: peak, max_height: 3, first: *i}}]\n", ["obstacles[0].first"]),
    "any bytes": (bytes(range(256)), ["not a text in UTF-8"]),
    "another encoding": ("description: über".encode("latin-1"), ["not a text in UTF-8"]),
    "sixteen bits a letter": ("seed: 1\n".encode("utf-16"), ["not a text in UTF-8"]),
    "a null character": (b"seed: 1\n\0", ["not YAML", "#x0000"]),
    "a bell": (b"name: \a\n", ["not YAML", "#x0007"]),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(100), ["not a text in UTF-8"]),
    "a huge file": (b"#" * (4 * 2**20 + 1), ["larger than 4 MiB", "JSON: up to 64 MiB"]),
    "very many keys": (f"{{{', '.join(f'k{key}: 1' for key in range(5000))}}}", ["unknown key 'k0'"]),
}


@pytest.mark.parametrize(("content", "words"), YAML.values(), ids=YAML)
def test_a_yaml_file(refused: Refused, content: str | bytes, words: Sequence[str]) -> None:
    line = refused("generate", recipe(content), "-o", "out")
    assert line.startswith("rsegen: recipe.yaml:")
    assert [word for word in words if word not in line] == []


JSON: Mapping[str, tuple[str | bytes, Sequence[str]]] = {
    "empty": ("", ["recipe.json:1:1: not JSON"]),
    "null": ("null", ["nothing is not a recipe"]),
    "a list": ("[]", ["[] is not a recipe"]),
    "a comma too many": ('{"seed": 1,}', ["recipe.json:1:", "not JSON"]),
    "a comment": ("// mine\n{}", ["recipe.json:1:1: not JSON"]),
    "two documents": ("{}{}", ["recipe.json:1:3: not JSON"]),
    "a key that stands twice": ('{"seed": 1, "seed": 2}', ["'seed' stands twice"]),
    "a key twice in a row": ('{"obstacles": [{"kind": "peak", "kind": "random"}]}', ["'kind' stands twice"]),
    "a number that overflows": ('{"unit_cm": 1e400}', ["unit_cm: inf is not a finite number", "0.001..100000 cm"]),
    "too many digits": (f'{{"seed": {"9" * 9000}}}', ["not a recipe", "4300"]),
    "deep nesting": ("[" * 100_000, ["nested too deeply"]),
    "deep nesting of keys": ('{"a":' * 100_000, ["nested too deeply"]),
    "half a letter": ('{"name": "\\ud800"}', ["name: '\\ud800' will not do"]),
    "a new line after the name": ('{"name": "x\\n"}', ["name: 'x\\n' will not do"]),
    "sixteen bits a letter": ("{}".encode("utf-16"), ["not a text in UTF-8"]),
    "a huge file": (b" " * (64 * 2**20 + 1), ["larger than 64 MiB"]),
}


@pytest.mark.parametrize(("content", "words"), JSON.values(), ids=JSON)
def test_a_json_file(refused: Refused, content: str | bytes, words: Sequence[str]) -> None:
    line = refused("generate", recipe(content, "recipe.json"), "-o", "out")
    assert line.startswith("rsegen: recipe.json:")
    assert [word for word in words if word not in line] == []


NAMES = [
    "../../x",
    "a/b",
    "/x",
    "..",
    ".",
    ".hidden",
    "-x",
    "a b",
    '<&">',
    "x\0",
    "ünï",
    "x\n",
    "\n",
    "x" * 65,
    " ",
]


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_a_name_cannot_leave_the_folder_or_break_the_world(refused: Refused, name: str) -> None:
    line = refused("generate", f"--name={name}", "-o", "out")
    assert line.startswith("rsegen: name: ")
    assert "1..64 letters, digits, _ . -" in line


# Commands, flags, and what they are pointed at.

COMMAND_LINES: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "nothing": ([], ["COMMAND"]),
    "a misspelt command": (["genrate"], ["'genrate'", "did you mean 'generate'?", "info, obstacles, preview, schema"]),
    "a command of two lines": (["a\nb"], ["'a\\nb'", "generate, info"]),
    "a misspelt flag": (["generate", "-o", "out", "--sed", "1"], ["'--sed'", "did you mean '--seed'?", "--chunk-size"]),
    "half a flag": (["generate", "-o", "out", "--chunk", "1"], ["'--chunk'", "did you mean '--chunks'?"]),
    "another command's flag": (["info", "recipe.yaml", "--force"], ["'--force'", "--json"]),
    "two recipes": (["generate", "a.yaml", "b.yaml", "-o", "out"], ["'b.yaml' is too much"]),
    "no output": (["generate"], ["-o/--output"]),
    "an output of no name": (["generate", "-o", ""], ["-o/--output", "give a folder"]),
    "a recipe of no name": (["generate", "", "-o", "out"], ["directory"]),
    "a flag without its value": (["generate", "-o", "out", "--seed"], ["--seed", "expected one argument"]),
    "a recipe that is not there": (["generate", "no.yaml", "-o", "out"], ["no.yaml: No such file"]),
    "a recipe in a file": (["generate", "file/r.yaml", "-o", "out"], ["file/r.yaml: Not a directory"]),
    "a recipe of too long a name": (["generate", "n" * 300, "-o", "out"], ["nnn: File name too long"]),
    "a folder without a recipe": (
        ["generate", "folder", "-o", "out"],
        ["folder: ", "recipe.json", "give a recipe file"],
    ),
    "a link to itself": (["info", "loop"], ["loop: Too many levels of symbolic links"]),
    "a target that is not there": (["info", "no.yaml"], ["no.yaml: No such file"]),
    "a target without maps": (["info", "folder"], ["folder: no map in it"]),
    "a target of another sort": (["info", "file"], ["file: 'not a recipe' is not a recipe"]),
    "an index beyond": (["info", "two.yaml", "--map", "2"], ["--map", "'2'", "two.yaml", "rse_0000..rse_0001"]),
    "an index below": (["info", "two.yaml", "--map=-1"], ["--map", "'-1'", "rse_0000..rse_0001"]),
    "an index that is a word": (["info", "two.yaml", "--map", "last"], ["--map", "'last'", "rse_0000..rse_0001"]),
    "another map's name": (["info", "two.yaml", "--map", "map_0001"], ["--map", "'map_0001'", "rse_0000..rse_0001"]),
    "an index of many digits": (["info", "two.yaml", "--map", "9" * 9000], ["--map", "'999", "rse_0000..rse_0001"]),
    "an output that is a file": (["generate", "-o", "file"], ["file: is a file; give a folder"]),
    "an output in a file": (["generate", "-o", "file/a/b"], ["file/a/b/rse_0000: cannot be written: Not a directory"]),
    "an output of too long a name": (["generate", "-o", "n" * 300], ["nnn: File name too long"]),
    "an output on a device": (["generate", "-o", "/dev/null"], ["/dev/null: is a file"]),
    "an output where nothing can be": (["generate", "-o", "/proc/a/b"], ["/proc/a/b/rse_0000: cannot be written"]),
    "a picture without an ending": (["preview", "two.yaml", "-o", "picture"], ["picture: ", ".png, .svg, .pdf"]),
    "a picture of another ending": (["preview", "two.yaml", "-o", "p.bmp"], ["p.bmp: ", ".png, .svg, .pdf"]),
    "a picture of an ending only": (["preview", "two.yaml", "-o", ".png"], [".png: ", "not a picture's name"]),
    "a picture of no name": (["preview", "two.yaml", "-o", ""], ["not a picture's name"]),
    "a picture that is there": (["preview", "two.yaml", "-o", "old.png"], ["old.png: is there already", "--force"]),
    "a picture that is a folder": (
        ["preview", "two.yaml", "-o", "folder.png", "--force"],
        ["folder.png: is there already and is not a file"],
    ),
    "a picture in a file": (["preview", "two.yaml", "-o", "file/p.png"], ["file/p.png: cannot be written"]),
    "a picture of a map beyond": (["preview", "two.yaml", "-o", "p.png", "--map", "2"], ["--map", "rse_0001"]),
}


@pytest.mark.parametrize(("arguments", "words"), COMMAND_LINES.values(), ids=COMMAND_LINES)
def test_a_command_line(refused: Refused, arguments: Sequence[str], words: Sequence[str]) -> None:
    recipe("not a recipe", "file")
    recipe("maps: 2\nseed: 7\nchunk_size: 2\n", "two.yaml")
    recipe("an old picture", "old.png")
    Path("folder").mkdir()
    Path("folder.png").mkdir()
    Path("loop").symlink_to("loop")
    line = refused(*arguments)
    assert [word for word in words if word not in line] == []


def test_json_does_not_change_how_a_mistake_is_told(refused: Refused) -> None:
    assert refused("generate", "-o", "out", "--json", "--maps", "0") == refused("generate", "-o", "out", "--maps", "0")


@pytest.mark.parametrize("command", [command.__name__.rpartition(".")[2] for command in COMMANDS])
def test_every_command_compares_an_unknown_flag_with_its_own(refused: Refused, command: str) -> None:
    given = {"generate": ["-o", "out"], "preview": ["a.yaml", "-o", "p.png"], "info": ["a.yaml"]}
    line = refused(command, *given.get(command, []), "--hlep")
    assert "unknown flag '--hlep'; did you mean '--help'?" in line


# What is there already.


def test_a_map_that_is_there_is_left_alone_and_no_other_is_begun(refused: Refused) -> None:
    assert exit_code("generate", *OBSTACLE, "--first-map", "2", "-o", "out") == 0
    line = refused("generate", *OBSTACLE, "--maps", "5", "-o", "out")
    assert "out/rse_0002: is there already; give --force to replace it" in line


def test_force_spares_a_folder_that_is_not_a_map(refused: Refused) -> None:
    Path("out/rse_0001").mkdir(parents=True)
    recipe("years of work", "out/rse_0001/thesis.tex")
    line = refused("generate", *OBSTACLE, "--maps", "2", "--force", "-o", "out")
    assert "out/rse_0001: was not made by rsegen (it has no recipe.json)" in line


def test_force_spares_a_file_in_the_place_of_a_map(refused: Refused) -> None:
    Path("out").mkdir()
    recipe("years of work", "out/rse_0000")
    assert "out/rse_0000: was not made by rsegen" in refused("generate", *OBSTACLE, "--force", "-o", "out")


@pytest.mark.parametrize("target", ["elsewhere", "nowhere"])
def test_force_spares_a_link(refused: Refused, target: str) -> None:
    Path("elsewhere").mkdir()
    recipe("{}", "elsewhere/recipe.json")
    Path("out").mkdir()
    Path("out/rse_0000").symlink_to(f"../{target}")
    assert "out/rse_0000: is a link" in refused("generate", *OBSTACLE, "--force", "-o", "out")


# More than there is: said before it is tried.

TOO_MUCH: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "chunks": (["--chunks", "1000000"], ["chunks: a map of", "fewer chunks"]),
    "chunks along one axis": (
        ["--chunks", "1000000000x1", "--chunk-size", "1000"],
        ["chunks: a map of", "fewer chunks"],
    ),
    "small chunks in frames": (["--chunks", "300000", "--chunk-size", "1"], ["900000 x 900000 cells"]),
    "boxes": (["--chunks", "1000000", "--mesh-type", "multi"], ["chunks: a map of", "fewer chunks"]),
    "maps": (["--maps", "1000000000000", "--chunk-size", "1"], ["maps: 1000000000000", "give fewer", "first_map"]),
    "maps without number": (["--maps", "9" * 400], ["maps: 999", "give fewer"]),
}


@pytest.mark.parametrize(("flags", "words"), TOO_MUCH.values(), ids=TOO_MUCH)
def test_more_than_there_is_memory_for(refused: Refused, flags: Sequence[str], words: Sequence[str]) -> None:
    line = refused("generate", *OBSTACLE, *flags, "-o", "out")
    assert " GB" in line
    assert [word for word in words if word not in line] == []


@pytest.mark.parametrize("command", [["info"], ["preview", "-o", "p.png"]], ids=["info", "preview"])
def test_looking_at_more_than_there_is_memory_for(refused: Refused, command: list[str]) -> None:
    assert "chunks: a map of" in refused(*command, recipe("chunks: 1000000\n"))


# The Python API says the same.

CALLS: Mapping[str, tuple[Callable[[], object], str]] = {
    "a number that cannot be written": (
        lambda: Recipe(seed=MORE_DIGITS_THAN_PYTHON_WRITES),
        "seed: a number of thousands of digits is outside 0..",
    ),
    "a pair of such": (lambda: Recipe(chunks=(1, MORE_DIGITS_THAN_PYTHON_WRITES)), "chunks: a number of thousands"),
    "an array": (lambda: Recipe(seed=np.zeros((3, 3))), "seed: .* is not a whole number"),  # type: ignore[arg-type]
    "nothing": (lambda: Recipe(maps=None), "maps: nothing is not a whole number"),  # type: ignore[arg-type]
    "a truth": (lambda: Recipe(maps=True), "maps: True is not a whole number"),
    "obstacles in a word": (lambda: Recipe(obstacles="peak"), "obstacles: 'peak' is not a list"),  # type: ignore[arg-type]
    "an obstacle without a place": (
        lambda: Recipe(obstacles=[rsegen.Peak(max_height=5)]),  # type: ignore[list-item]
        r"obstacles\[0\]: Peak\(.* is not a placement",
    ),
    "a place without an obstacle": (lambda: Placement(obstacle="peak"), "obstacle: 'peak' is not"),  # type: ignore[arg-type]
    "a barrier askew": (
        lambda: Placement(obstacle=rsegen.HorizontalBarrier(max_height=5), first=(1, 2), last=(3, 4)),
        "share neither x nor y",
    ),
    "a height of ground only": (lambda: rsegen.Peak(max_height=1), "max_height: 1 is outside 2..32767"),
    "an index below 0": (lambda: rsegen.build(Recipe(), -1), "index: -1 is outside 0.."),
}


@pytest.mark.parametrize(("call", "words"), CALLS.values(), ids=CALLS)
def test_a_call(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ParameterError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["no.yaml", ".", "a\0b"], ids=ascii)
def test_a_file_that_cannot_be_loaded(name: str) -> None:
    with pytest.raises(FileError) as caught:
        rsegen.load(name)
    assert "\n" not in str(caught.value)


def test_a_call_that_is_refused_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(UserError):
        rsegen.generate(Recipe(chunks=(10**6, 10**6)), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


# The machine fails, or is told to stop: exit code 1, one line, whole maps or nothing.


def test_a_mistake_of_ours_is_one_line_that_asks_for_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("of ours")

    monkeypatch.setattr(writer, "_fill", broken)
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path / "out") == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "please report it: ZeroDivisionError: of ours" in err
    assert list(tmp_path.iterdir()) == []


def test_memory_that_runs_out_after_all_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(writer, "_fill", full)
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path / "out") == 1
    assert "out of memory; give fewer chunks" in the_line(capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(threading.current_thread() is not threading.main_thread(), reason="signals need the main thread")
@pytest.mark.parametrize("force", [False, True])
def test_an_impatient_second_ctrl_c_does_not_disturb_the_clearing_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], force: bool
) -> None:
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path) == 0
    before, remove = snapshot(tmp_path), shutil.rmtree

    def stopped(*_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    def stopped_again(*arguments: Any, **options: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        remove(*arguments, **options)

    monkeypatch.setattr(writer, "_fill", stopped)
    monkeypatch.setattr(shutil, "rmtree", stopped_again)
    capsys.readouterr()
    flags = ["--force"] if force else ["--first-map", "1"]
    assert exit_code("generate", *OBSTACLE, *flags, "-o", tmp_path) == 1
    assert "stopped; the maps that were complete are there" in the_line(capsys.readouterr().err)
    assert snapshot(tmp_path) == before


def started(
    *arguments: str | Path, before: str = "", after: str = "", stdout: Any = subprocess.PIPE, **environment: str
) -> subprocess.Popen[str]:
    """The command as a process of its own, which buffers what it prints; `before` and `after` are the shell's."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | environment
    shell = ["/bin/sh", "-c", f'{before} exec "$@" {after}', "sh"]
    command = [*shell, sys.executable, "-m", "rsegen", *map(str, arguments)]
    return subprocess.Popen(command, stdout=stdout, stderr=subprocess.PIPE, text=True, env=own)


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its exit code and what it said on stderr."""
    _, err = process.communicate(timeout=60)
    return process.returncode, err


def whole_maps_only(folder: Path) -> bool:
    made = {frozenset(path.name.replace(one.name, "") for path in one.rglob("*")) for one in folder.iterdir()}
    return len(made) == 1 and all(one.name.startswith("rse_") for one in folder.iterdir())


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_run_that_is_stopped_leaves_whole_maps_only(tmp_path: Path, name: str) -> None:
    process = started("generate", *OBSTACLE, "--maps", "100000", "-o", tmp_path / "out")
    while len(list(tmp_path.glob("out/rse_*"))) < 3:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(getattr(signal, name))
    code, err = ended(process)
    assert (code, the_line(err)) == (1, "rsegen: stopped; the maps that were complete are there, nothing else is")
    assert whole_maps_only(tmp_path / "out")


def test_a_run_that_is_stopped_in_its_only_map_leaves_nothing(tmp_path: Path) -> None:
    process = started("generate", *OBSTACLE, "--chunks", "20", "--mesh-type", "multi", "-o", tmp_path / "a" / "b")
    while not list(tmp_path.glob("a/b/.rse_*")):
        assert process.poll() is None
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    code, err = ended(process)
    assert (code, the_line(err)) == (1, "rsegen: stopped; the maps that were complete are there, nothing else is")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_grows_too_large_for_the_system_leaves_nothing(tmp_path: Path) -> None:
    process = started("generate", *OBSTACLE, "--chunks", "5", "-o", tmp_path / "a" / "b", before="ulimit -f 20;")
    code, err = ended(process)
    assert code == 1
    assert "rse_0000: cannot be written: File too large; nothing was left there" in the_line(err)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 200 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    try:
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", folder], capture_output=True, text=True, check=False
        )
    except OSError as error:
        pytest.skip(f"a small disk cannot be mounted here: {error}")
    if done.returncode:
        pytest.skip(f"a small disk cannot be mounted here: {' '.join(done.stderr.split())}")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


def test_a_full_disk_leaves_whole_maps_only(disk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("generate", *OBSTACLE, "--maps", "50", "-o", disk / "out") == 1
    assert "cannot be written: No space left on device; nothing was left there" in the_line(capsys.readouterr().err)
    assert whole_maps_only(disk / "out")


@pytest.mark.parametrize(
    "command",
    [["generate", "--chunks", "10", "-o", "a/b"], ["preview", "recipe.yaml", "-o", "a/b.png"]],
    ids=lambda c: c[0],
)
def test_a_full_disk_leaves_nothing_of_what_does_not_fit(
    disk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    monkeypatch.chdir(disk)
    recipe("seed: 7\n")
    recipe(bytes(120_000), "ballast")
    before = snapshot(disk)
    assert exit_code(*command, *(OBSTACLE if command[0] == "generate" else [])) == 1
    assert "cannot be written: No space left on device" in the_line(capsys.readouterr().err)
    assert snapshot(disk) == before


def test_a_full_disk_leaves_the_map_that_was_to_be_replaced(disk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("generate", *OBSTACLE, "-o", disk) == 0
    before = snapshot(disk)
    capsys.readouterr()
    assert exit_code("generate", *OBSTACLE, "--chunks", "10", "--force", "-o", disk) == 1
    assert "No space left on device" in the_line(capsys.readouterr().err)
    assert snapshot(disk) == before


def test_a_disk_that_may_only_be_read(disk: Path, refused: Refused) -> None:
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    for command in (["generate", "-o", f"{disk}/out"], ["preview", recipe("seed: 7\n"), "-o", f"{disk}/p.png"]):
        assert "cannot be written: Read-only file system" in refused(*command)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize(
    "command", [["schema"], ["obstacles", "--json"], ["--version"], ["generate", "--help"]], ids=" ".join
)
def test_a_report_that_cannot_be_printed(command: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        code, err = ended(started(*command, stdout=full))
    assert (code, the_line(err)) == (1, "rsegen: what was to be printed: No space left on device")


@pytest.mark.parametrize("command", [["schema"], ["obstacles"], ["--help"]], ids=" ".join)
def test_a_reader_that_has_gone_hears_nothing_more(command: list[str]) -> None:
    reader, pipe = os.pipe()
    os.close(reader)
    try:
        assert ended(started(*command, stdout=pipe)) == (1, "")
    finally:
        os.close(pipe)


@pytest.mark.parametrize("closed", [">&-", "2>&-"])
def test_closed_output_does_not_keep_a_map_from_being_made(tmp_path: Path, closed: str) -> None:
    process = started("generate", *OBSTACLE, "--maps", "2", "-o", tmp_path / "out", after=closed)
    assert ended(process) == (0, "")
    assert whole_maps_only(tmp_path / "out")


def test_a_folder_that_cannot_be_printed_is_written_all_the_same(tmp_path: Path) -> None:
    for code, words in ((0, ""), (2, "is there already")):
        process = started("generate", *OBSTACLE, "-o", tmp_path / "über", PYTHONIOENCODING="ascii")
        assert process.wait(60) == code
        assert words in ended(process)[1]
    assert whole_maps_only(tmp_path / "über")
