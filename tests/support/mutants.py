"""Mutants of the pure core: which small changes to params, field, recipe and geometry no test notices.

    python -m tests.support.mutants obstacles/peak.py    those of a file, or of a folder
    python -m tests.support.mutants 50                         a sample of 50, the same every time
    python -m tests.support.mutants                            all of them, some 7,000: hours

mutmut makes them in `mutants/`, finds out which tests run which function, and runs those on each; pyproject.toml says
which. It changes nothing in class bodies, such as the bounds of parameters: the published schema is a test of those.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

ROOT = Path(__file__).parents[2]
MADE = ROOT / "mutants" / "src"
OUTCOMES = {0: "survived", 5: "no test", 33: "no test", None: "not run"}
"""mutmut's codes of a mutant that lives; every other one is an end by failure, by a limit of CPU time, or a crash."""
SEED = 1


def main(asked: Sequence[str]) -> int:
    """Run the mutants that are asked for, and print the survivors and the score; 1 if mutmut itself fails."""
    names = [name for word in asked for name in _names(word)]
    code = _mutmut(*names)
    found = {name: code for name, code in _results().items() if _is_asked(name, names)}
    living = {name: OUTCOMES[code] for name, code in found.items() if code in OUTCOMES}
    for name, outcome in sorted(living.items()):
        print(f"{outcome}: {name}", *_change(name), sep="\n    ")  # noqa: T201
    print(f"{len(found) - len(living)} of {len(found)} mutants were killed")  # noqa: T201
    return int(code != 0)


def _names(word: str) -> list[str]:
    """mutmut's names, or patterns of them, for a path below src/rsegen, a number, or a name."""
    if word.isdecimal():
        _mutmut("nothing")  # makes the mutants and looks which tests run them
        return random.Random(SEED).sample(sorted(_results()), int(word))  # noqa: S311
    if word.startswith("rsegen."):
        return [word]
    dotted = word.removesuffix(".py").removesuffix("/__init__").strip("/").replace("/", ".")
    return [f"rsegen.{dotted}.*"]


def _mutmut(*names: str) -> int:
    return subprocess.run([sys.executable, "-m", "mutmut", "run", *names], cwd=ROOT, check=False).returncode


def _results() -> Mapping[str, int | None]:
    """mutmut's exit code of every mutant that was made."""
    records = (json.loads(path.read_text("utf-8")) for path in sorted(MADE.rglob("*.meta")))
    return {name: code for record in records for name, code in record["exit_code_by_key"].items()}


def _is_asked(name: str, patterns: Sequence[str]) -> bool:
    return not patterns or any(fnmatchcase(name, pattern) for pattern in patterns)


def _change(name: str) -> list[str]:
    """The lines that a mutant takes away and puts in their place."""
    shown = subprocess.run(
        [sys.executable, "-m", "mutmut", "show", name], cwd=ROOT, check=False, capture_output=True, text=True
    )
    return [line for line in shown.stdout.splitlines() if line[:1] in "+-" and line[:3] not in ("+++", "---")]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
