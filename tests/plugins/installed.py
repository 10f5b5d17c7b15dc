"""The package of tests/plugins/demo as it is when it is installed, and commands that run beside it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

DEMO = Path(__file__).parent / "demo"
RAMP = "ramp levels=5 first=0,0 last=8,9 tread=2"
STEPS = "0,0,1,1,2,2,3,3,4,0"
"""A row of its levels."""

EAGER = """
import sys
import rsegen.writing.execute
rsegen.writing.execute.WORTHWHILE = 0  # so few maps are shared out too
from rsegen.cli.edge import main
if __name__ == "__main__":
    sys.exit(main())
"""


def install(folder: Path, version: str = "1.2") -> Path:
    """Install the package into a folder of packages as pip does: its modules, and a folder of metadata."""
    shutil.copytree(DEMO / "rsegen_demo", folder / "rsegen_demo", dirs_exist_ok=True)
    declare(folder, "rsegen-demo", version, entry_points())
    return folder


def declare(folder: Path, name: str, version: str, offers: str) -> None:
    """The metadata of an installed package with such entry points, in place of other versions of it."""
    for other in folder.glob(f"{name.replace('-', '_')}-*.dist-info"):
        shutil.rmtree(other)
    metadata = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (metadata / "entry_points.txt").write_text(offers)


def installed(folder: Path, source: str, offers: str = "[rsegen.obstacles]\ndune = dunes:Dune\n") -> Path:
    """Install a package `sandbox` with one module, `dunes`; return the folder."""
    (folder / "dunes.py").write_text(source)
    declare(folder, "sandbox", "0.3", offers)
    return folder


def module_of(source: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Run the source of a plug-in in this process, as a module `dunes` that a test has for itself."""
    module = ModuleType("dunes")
    monkeypatch.setitem(sys.modules, "dunes", module)
    exec(source, vars(module))  # noqa: S102  # as a plug-in is run
    return module


def entry_points() -> str:
    """Entry points of the package's pyproject.toml, in the words of entry_points.txt."""
    text = (DEMO / "pyproject.toml").read_text("utf-8")
    sections = re.findall(r'^\[project\.entry-points\."([^"]+)"\]\n((?:.+\n)+)', text, re.MULTILINE)
    return "\n".join(f"[{group}]\n{rows}" for group, rows in sections).replace('"', "")


def run(
    *arguments: str | Path, packages: Path | None = None, code: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """The command, or a script of its own, in another process that finds these packages."""
    own = os.environ | ({"PYTHONPATH": str(packages)} if packages else {}) | environment
    command = ["-c", code] if code else ["-m", "rsegen"]
    return subprocess.run(
        [sys.executable, *command, *map(str, arguments)], env=own, capture_output=True, text=True, check=False
    )


def done(*arguments: str | Path, packages: Path | None = None, code: str = "", **environment: str) -> str:
    """Return what it printed, if all went well without a warning."""
    found = run(*arguments, packages=packages, code=code, **environment)
    assert (found.returncode, found.stderr) == (0, ""), found
    return found.stdout


def refused(*arguments: str | Path, packages: Path | None = None, **environment: str) -> str:
    """The one line that it was refused with."""
    found = run(*arguments, packages=packages, **environment)
    assert found.returncode == 2, found
    assert found.stderr.count("\n") == 1, found
    return found.stderr.strip()
