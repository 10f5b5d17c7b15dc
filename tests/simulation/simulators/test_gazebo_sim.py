"""Gazebo Sim by its command and its messages, which a stand-in plays; no server of it runs here."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators import SIMULATORS
from rsegen.simulation.simulators.server import running_server
from tests.simulation.simulators.standins import PROGRAMS, put, start

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
SIM = SIMULATORS["sim"]
LOADED = "[Msg] World [rse_0000] initialized with [default_physics] physics profile.\\n"


@pytest.mark.parametrize("told", ["Invalid arguments\\n\\n", "The gz command\\n  sdf:  Utilities\\n 8\\n", ""])
def test_another_program_of_its_name_is_not_taken_for_it(told: str, programs: Path) -> None:
    put(programs, {"gz": told, "ign": told})
    assert SIM.installation() is None


@pytest.mark.parametrize(
    ("gz", "ign", "newest", "words"),
    [
        ("8.9.0\\n", "6.16.0\\n", "8.9.0", "gz sim"),
        ("8.9.0\\n10.1.0\\n9.5.0\\n", "6.16.0\\n", "10.1.0", "gz sim"),
        ("Invalid arguments\\n", "6.2.0\\n6.16.0\\n", "6.16.0", "ign gazebo"),
        ("9.0.0~pre1\\n", "", "9.0.0~pre1", "gz sim"),
    ],
)
def test_the_newest_of_all_its_versions_is_found(gz: str, ign: str, newest: str, words: str, programs: Path) -> None:
    put(programs, {"gz": gz, "ign": ign})
    here = SIM.installation()
    assert here
    assert (here.version, dict(here.commands)) == (newest, {words: programs / words.split(maxsplit=1)[0]})


def test_a_server_has_loaded_when_it_says_so(programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "60")
    monkeypatch.setenv("SAYS", f"{LOADED}[Err] [a.cc:1] no such mesh\\n")
    here = SIM.installation()
    assert here
    with running_server(here, world) as server:
        did = start(programs / "gz")
        assert did.command[1:] == ("sim", "-s", "-v", "3", str(world))
        assert did.variables["HOME"] == str(server.home)
        assert {did.variables[name] for name in ("GZ_PARTITION", "IGN_PARTITION")} == {
            server.environment["GZ_PARTITION"]
        }
        assert server.errors == ["[Err] [a.cc:1] no such mesh"]
    assert not server.home.exists()


@pytest.mark.parametrize(
    ("stays", "says", "why"),
    [
        ("0", "[Msg] Loading SDF world file\\n", "the server has died"),
        ("60", "[Msg] Loading SDF world file\\n", "it did not load in time"),
    ],
)
def test_a_server_that_does_not_load_is_an_error_with_its_last_words(
    stays: str, says: str, why: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", stays)
    monkeypatch.setenv("SAYS", says)
    here = SIM.installation()
    assert here
    with pytest.raises(SimulatorFailed, match=why) as error, running_server(here, world, timeout=0.5):
        pass
    assert str(error.value).endswith("[Msg] Loading SDF world file")
