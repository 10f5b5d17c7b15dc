"""scripts/gazebo-sim finds what is installed, and says how to install one where there is none."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.simulators.standins import path_with, put

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
SCRIPT = Path(__file__).parents[2] / "scripts" / "gazebo-sim"


def found(programs: Path) -> subprocess.CompletedProcess[str]:
    for tool in ("bash", "cat", "grep", "sort", "tail", "tr"):
        there = shutil.which(tool, path=os.defpath)
        assert there
        (programs.parent / "tools" / tool).symlink_to(there)
    environment = {"PATH": path_with(programs), "SAYS": ""}
    return subprocess.run([SCRIPT], env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("gz", "ign", "words"),
    [
        ("8.9.0\\n10.1.0\\n", "6.16.0\\n", "Gazebo Sim 10.1.0, gz sim: {}/gz\n"),
        ("Invalid arguments\\n", "6.2.0\\n6.16.0\\n", "Gazebo Sim 6.16.0, ign gazebo: {}/ign\n"),
    ],
)
def test_the_newest_that_is_installed_is_printed(gz: str, ign: str, words: str, programs: Path) -> None:
    put(programs, {"gz": gz, "ign": ign})
    said = found(programs)
    assert (said.returncode, said.stdout, said.stderr) == (0, words.format(programs), "")


@pytest.mark.parametrize("there", [{}, {"gz": "Invalid arguments\\n"}])
def test_without_gazebo_sim_the_script_says_how_to_install_it(there: dict[str, str], programs: Path) -> None:
    put(programs, there)
    said = found(programs)
    assert (said.returncode, said.stdout) == (1, "")
    assert all(system in said.stderr for system in ("Ubuntu 24.04", "Ubuntu 22.04", "Debian", "macOS", "conda"))
