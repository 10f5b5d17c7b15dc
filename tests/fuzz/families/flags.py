"""Every flag of every command, with values that are right, wrong or strange."""

from __future__ import annotations

import argparse
import random
from collections.abc import Mapping, Sequence
from functools import cache

from rsegen.cli.command_line import parser_of
from rsegen.params.capabilities import commands
from tests.fuzz.case import Case, Content, Special
from tests.fuzz.hostile import NUMBERS, TEXTS
from tests.fuzz.seeds import INVENTORY, TABLES, map_folder

LEFT_OUT = {"gui", "doctor"}
"""Commands that are not run: a server, which runs until it is stopped and has its own trials, and one without flags."""
NEVER = {"--help", "-h", "--scheduler", "--workers", "--plugin", "--version", "--list"}
"""Flags that are not drawn: a cluster, more processes, code, and pages that end a command whatever else is given."""
LONG = {("terrain", "--sheet")}
"""Flags of commands that take long: a terrain has 200 tiles, and a sheet has a page for each of them."""
OUTPUTS = {"-o", "--output", "--csv"}
_PLACES = (
    "out",
    "a/b/c",
    "maps",
    "p.png",
    "s.pdf",
    "s.csv",
    "out\x1b[31m",
    "out\udcff",
    ".",
    "taken",
    "n" * 300,
    "taken/x",
    "loop",
    "x" * 9000,
)
_TARGETS: tuple[str, ...] = (
    "peak",
    "r.yaml",
    "maps",
    "maps/rse_0000",
    "r.yaml#1",
    "maps#0",
    "none.yaml",
    "taken",
    "loop",
    "\x1b[31m.yaml",
)
_TARGETS += (
    "t.csv",
    "",
    "burger",
    "x\udcff.json",
    "n" * 20_000 + ".yaml",
    "turtlebot",
    "map.world",
    "quick",
    "..",
    "a\rb",
)
_VALUES: tuple[str, ...] = (
    "1",
    "2",
    "3x2",
    "0,1",
    "1,1,1",
    "random",
    "yes",
    "no",
    "5",
    "0.5",
    "rse_0001",
    "burger",
    "jackal",
    "inv.csv",
    "none",
    "merged",
)
_VALUES += (
    "watertight",
    "blocks",
    "stl",
    "mjcf shape=hfield",
    "stl,ply",
    "#ff0000",
    "outer",
    "divided",
    "multi",
    "pallet",
    "max",
    "add",
)
_OBSTACLES: tuple[str, ...] = (
    "random levels=5",
    "peak levels=5 softness=30 first=2,2 last=7,7",
    "horizontal_barrier levels=4 first=0,1 last=3,1",
    "pallet levels=3",
)
_OBSTACLES += (
    "normal_random levels=5",
    "matrix levels=3 rows='0 1 2'",
    "peak",
    "random levels=5 weights=1,2,3,4,5",
    "diagonal_barrier levels=3 first=random",
)


@cache
def options(command: str) -> Mapping[str, argparse.Action]:
    """Every flag of a command."""
    actions = parser_of(command).actions
    found = {flag: action for action in actions for flag in action.option_strings if flag not in NEVER}
    return {flag: action for flag, action in found.items() if (command, flag) not in LONG}


def case(rng: random.Random) -> Case:
    """A command with a few of its flags."""
    command = rng.choice([name for name in commands() if name not in LEFT_OUT])
    argv = [command]
    outputs: list[str] = []
    known = options(command)
    required = [flag for flag in ("-o", "--to") if flag in known and rng.random() < 0.95]
    for flag in [*required, *rng.sample(sorted(known), min(len(known), rng.choice((0, 1, 1, 2, 3))))]:
        argv += _given(rng, flag, known[flag], outputs)
    if rng.random() < 0.9 and command not in ("sim", "schema", "obstacles", "examples"):
        argv.insert(
            rng.choice((1, len(argv))), rng.choice(_TARGETS if rng.random() < 0.6 else ("peak", "r.yaml", "maps"))
        )
    if command in ("generate", "series", "dataset", "export", "import"):
        argv += ["--workers", "1"]
    if rng.random() < 0.05:
        argv.insert(
            rng.randrange(len(argv) + 1), rng.choice(("--", "-", "-x", "--=", "---", "--seed", "extra", "\x1b", "-o"))
        )
    return Case(family="flags", argv=tuple(argv), files=_files(rng), outputs=tuple(outputs))


def _given(rng: random.Random, flag: str, action: argparse.Action, outputs: list[str]) -> list[str]:
    if action.nargs == 0:
        return [flag]
    if flag in OUTPUTS:
        outputs.append(rng.choice(_PLACES))
        return [f"{flag}={outputs[-1]}"] if len(flag) > 2 else [flag, outputs[-1]]
    value = rng.choice(_OBSTACLES) if flag == "--obstacle" else _value(rng)
    if flag == "--obstacle" and rng.random() < 0.6:
        value = _other_word(rng, value)
    return [flag, value] if rng.random() < 0.5 else [f"{flag}={value}"]


def _value(rng: random.Random) -> str:
    kinds: Sequence[Sequence[object]] = (_VALUES, _VALUES, NUMBERS, [text for text in TEXTS if "\0" not in text])
    value = str(rng.choice(rng.choice(kinds)))
    return f"{value},{_value(rng)}" if rng.random() < 0.1 else value


def _other_word(rng: random.Random, text: str) -> str:
    words = text.split()
    at = rng.randrange(len(words))
    key, equals, _ = words[at].partition("=")
    words[at] = rng.choice(
        (f"{key}{equals}{_value(rng)}", f"{key}{equals}", "=", f"x{words[at]}", f"{words[at]} {words[at]}", "'")
    )
    return " ".join(words)


def _files(rng: random.Random) -> dict[str, Content]:
    files: dict[str, Content] = {
        "r.yaml": b"maps: 2\nseed: 7\nchunk_size: 4\n",
        "inv.csv": INVENTORY,
        "t.csv": TABLES[0],
    }
    files |= {"taken": b"a file\n", "loop": Special(kind="link", target="loop")}
    return {**files, **map_folder()} if rng.random() < 0.3 else files
