"""A copy of the tree without some capabilities, and what is left of it.

`python -m tests.support.deletion` deletes each capability in turn, with those that need it, and runs the fast tests
that are left; names of capabilities on the command line choose which. `--all` deletes all of them at once: the core
alone passes its tests, and a table says which of its lines they do not run.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from rsegen.params.capabilities import capabilities
from rsegen.robots.base import ROBOTS

ROOT = Path(__file__).parents[2]
FOLDERS = [name for name in capabilities() if (ROOT / "src" / "rsegen" / name).is_dir()]
"""Capabilities that can be deleted."""

_OF_ALL = ("bad_input", "benchmarks", "contracts", "crash", "docs", "examples", "fuzz", "golden", "plugins", "real")
"""Folders of tests that ask something of the whole, and so need all of it."""

_UNUSED = ("node_modules", "test_house.py", "test_doctor.py", "course.html", ".rsegen")
"""The last two are what `make site` is writing at the same time."""

_LEFT_OUT = shutil.ignore_patterns("*.pyc", "__pycache__", *_UNUSED)
_LEFT_OUT_OF_SOURCES = shutil.ignore_patterns("*.pyc.*", *_UNUSED)
"""Bytecode is copied, as to compile the sources takes longer than to use them; not that which is being written."""


def with_dependants(names: Iterable[str]) -> set[str]:
    """Return capabilities, and all that need any of them."""
    gone = set(names)
    while more := {name for name in FOLDERS if gone.intersection(capabilities()[name].needs)} - gone:
        gone |= more
    return gone


def sources_without(names: Collection[str], folder: Path) -> Path:
    """Copy the sources into a folder without some capabilities; return the copy's root."""
    shutil.copytree(ROOT / "src", folder / "src", ignore=_LEFT_OUT_OF_SOURCES)
    for name in names:
        shutil.rmtree(folder / "src" / "rsegen" / name)
    return folder


def tree_without(names: Collection[str], folder: Path) -> Path:
    """Copy sources and tests into a folder without some capabilities and tests that use them; return its root."""
    sources_without(names, folder)
    for part in ("tests", "benchmarks", "scripts", "docs"):
        shutil.copytree(ROOT / part, folder / part, ignore=_LEFT_OUT)
    for name in (*_OF_ALL, *names):
        shutil.rmtree(folder / "tests" / name, ignore_errors=True)
    shutil.copy(ROOT / "pyproject.toml", folder)
    gone = list(uses_of_what_is_gone(folder, names))
    while gone:  # and tests that use these
        for test in gone:
            test.unlink()
        modules = [".".join(test.relative_to(folder).with_suffix("").parts) for test in gone]
        uses = re.compile(rf"\b(?:{'|'.join(map(re.escape, modules))})\b")
        gone = [path for path in folder.glob("tests/**/*.py") if uses.search(path.read_text("utf-8"))]
    return folder


def uses_of_what_is_gone(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Yield the files of tests of others that use what some capabilities bring: modules, public names or commands."""
    gone = [capabilities()[name] for name in names]
    public = {name for capability in gone for of_module in capability.public.values() for name in of_module}
    words = {command.name for capability in gone for command in capability.commands}
    words |= {name for capability in gone for offered in capability.offers.values() for name in offered}
    words |= {*ROBOTS} if "robots" in names else set()
    # None of a kind would be a pattern that is in every file.
    public, words = public or {"no public name"}, words or {"no word"}
    uses = re.compile(
        rf"\b(?:rsegen|tests)\.(?:{'|'.join(names)})\b|\btests\.(?:{'|'.join(_OF_ALL)})\b"
        rf"|\brsegen\.(?:{'|'.join(public)})\b|^from rsegen import .*\b(?:{'|'.join(public)})\b"
        rf"|\"(?:{'|'.join(words)})[\" ]|--(?:preview|sheet|formats)",
        re.MULTILINE,
    )
    for path in folder.glob("tests/**/*.py"):
        if uses.search(path.read_text("utf-8")):
            yield path


def environment(folder: Path) -> dict[str, str]:
    """Return the environment in which a copy is what Python imports."""
    return {**os.environ, "PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}


def main(names: list[str]) -> int:
    """Delete each of some capabilities, by default all in turn, and run the fast tests that are left."""
    tried = [_core_alone()] if names == ["--all"] else [_without(name) for name in names or FOLDERS]
    return 0 if all(tried) else 1


def _without(name: str) -> bool:
    """Return whether the fast tests pass without a capability and those that need it."""
    gone = with_dependants([name])
    with tempfile.TemporaryDirectory() as folder:
        copy = tree_without(gone, Path(folder))
        left = len(list(copy.glob("tests/**/test_*.py")))
        print(f"without {', '.join(sorted(gone))}: {left} files of tests are left", flush=True)  # noqa: T201  # a command
        return _in_copy(copy, *_TESTS)


def _core_alone() -> bool:
    """Return whether the fast tests of the core pass where there is nothing else; print which lines they do not run."""
    with tempfile.TemporaryDirectory() as folder:
        copy = tree_without(FOLDERS, Path(folder))
        steps = [("coverage", "run", "-m", *_TESTS), ("coverage", "combine", "--quiet"), ("coverage", "report")]
        passed = [_in_copy(copy, *step) for step in steps]  # the table also where a test fails
        return all(passed)


def _in_copy(copy: Path, *module: str) -> bool:
    """Run a module with its arguments in a copy of the tree; return whether it ends well."""
    run = subprocess.run([sys.executable, "-m", *module], cwd=copy, env=environment(copy), check=False)
    return run.returncode == 0


_TESTS = ("pytest", "-q", "-n", "2", "-p", "no:cacheprovider", "-m", "not slow and not long and not real", "tests")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
