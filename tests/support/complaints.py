"""Form of error messages: one clear line on stderr, short enough to be read."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Protocol

from rsegen.cli.edge import main

MANY_DIGITS = int("9" * 400)
MORE_DIGITS_THAN_PYTHON_WRITES = 1 << 20_000
OBSTACLE = ["--obstacle", "random levels=5", "--seed", "7"]
NO_WORD = "xyz"
LISTS = [f", &{one} [{', '.join([f'*{below}'] * 10)}]" for below, one in pairwise("abcdefghi")]
BOMB = f"description: [&a [x, x]{''.join(LISTS)}]\n"
"""A few hundred bytes of YAML that stand for 10^8 lists."""


class Refused(Protocol):
    """Runs a command that is to be refused, and gives its one line of complaint."""

    def __call__(self, *arguments: str | Path) -> str: ...


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
    assert "internal error" not in err
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
