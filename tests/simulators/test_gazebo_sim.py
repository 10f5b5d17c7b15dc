"""Gazebo Sim by its command and its messages, which a stand-in plays; no server of it runs here."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import rsegen
from rsegen.errors import SimulatorFailed
from rsegen.robots.base import ROBOTS
from rsegen.robots.drives import PublishCommand, Tracks
from rsegen.robots.links import posed
from rsegen.simulators.base import SIMULATORS, OpenRequest, commands_of
from rsegen.simulators.gazebo_sim import SimWorld
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import running_server
from tests.simulators.standins import PROGRAMS, put, start
from tests.support.patience import until

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
SIM = SIMULATORS["sim"]
INITIALIZED = "[Msg] World [rse_0000] initialized with [default_physics] physics profile.\\n"
LOADED = f"{INITIALIZED}[Msg] Publishing dynamic pose messages on [/world/rse_0000/dynamic_pose/info]\\n"
UNREADABLE = "[Err] [Server.cc:183] Error Code 13: [/sdf/world[1]]: Msg: Unable to find uri[model://a]"


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


@pytest.mark.parametrize("first", ["classic", "sim"])
def test_both_gazebos_are_found_in_whatever_order_their_folders_are_on_path(
    first: str, programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each has a program `gz`; that of Gazebo Classic prints its help for `gz sim --versions`."""
    folders = {name: programs.parent / name for name in PROGRAMS}
    for name, folder in folders.items():
        put(folder, PROGRAMS[name])
    in_order = sorted(folders, key=lambda name: name != first)
    monkeypatch.setenv("PATH", os.pathsep.join([*(str(folders[name]) for name in in_order), os.environ["PATH"]]))
    sim, classic = (SIMULATORS[name].installation() for name in ("sim", "classic"))
    assert sim
    assert classic
    assert (sim.version, dict(sim.commands)) == ("8.9.0", {"gz sim": folders["sim"] / "gz"})
    assert (classic.version, classic.commands["gz"]) == ("11.14.0", folders["classic"] / "gz")


def test_a_command_that_is_on_path_by_two_names_of_its_folder_is_asked_once(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    (programs.parent / "bin").symlink_to(programs)
    monkeypatch.setenv("PATH", f"{programs.parent / 'bin'}:{os.environ['PATH']}")
    assert commands_of("gz") == [programs.parent / "bin" / "gz"]


@pytest.mark.parametrize("where", ["NOTES", "SAYS"])
def test_a_server_has_loaded_when_it_prints_so_or_writes_it_to_its_own_log(
    where: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "60")
    monkeypatch.setenv("SAYS", "[Msg] Publishing sc")
    monkeypatch.setenv(where, LOADED)
    monkeypatch.setenv("COMPLAINS", "[Err] [a.cc:1] no such mesh\\n")
    here = SIM.installation()
    assert here
    with running_server(here, world) as server:
        did = start(programs / "gz")
        assert did.command[1:] == ("sim", "-s", "-v", "3", str(world))
        assert did.variables["HOME"] == str(server.home)
        assert {did.variables[name] for name in ("GZ_PARTITION", "IGN_PARTITION")} == {
            server.environment["GZ_PARTITION"]
        }
        until(lambda: server.errors == ["[Err] [a.cc:1] no such mesh"])
    assert not server.home.exists()


def test_lines_of_errors_are_not_cut_by_blocks_of_other_lines(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("SAYS", "[Msg] Publishing sc")
    monkeypatch.setenv("COMPLAINS", "[Err] [a.cc:1] no such mesh\\n")
    lines: list[str] = []
    with pytest.raises(SimulatorFailed, match="ended by itself"):
        rsegen.open(world, headless=True, on_error=lines.append)
    assert lines == ["[Err] [a.cc:1] no such mesh"]


@pytest.mark.parametrize(
    ("stays", "says", "why"),
    [
        ("0", "", r"the server has died; its log ends with:\n.*the last words$"),
        ("0", f"{UNREADABLE}\\n", rf"the world was not loaded; its last errors are:\n{re.escape(UNREADABLE)}$"),
        ("600", f"{UNREADABLE}\\n", rf"the world was not loaded; its last errors are:\n{re.escape(UNREADABLE)}$"),
    ],
)
def test_a_server_that_does_not_load_is_an_error_with_its_errors_or_its_last_words(
    stays: str, says: str, why: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", stays)
    monkeypatch.setenv("SAYS", f"{says}[Msg] the last words\\n")
    here = SIM.installation()
    assert here
    with pytest.raises(SimulatorFailed, match=why), running_server(here, world):
        pass


@pytest.mark.parametrize("says", ["", INITIALIZED])
def test_a_server_that_never_tells_its_models_poses_has_not_loaded(
    says: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "600")
    monkeypatch.setenv("SAYS", says)
    here = SIM.installation()
    assert here
    with (
        pytest.raises(SimulatorFailed, match=r"it has not loaded its world, after 0.5 s without progress"),
        running_server(replace(here, timeout=0.5), world),
    ):
        pass


@pytest.mark.parametrize(
    ("line", "failed"),
    [
        (UNREADABLE, True),
        ("[Err] [ServerPrivate.cc:794] Error Code 1: Msg: Unable to read file[/a.world]", True),
        ("[Err] [UserCommands.cc:970] Error Code 13: Msg: Unable to find uri[model://a]", False),
    ],
)
def test_an_error_in_the_world_differs_from_one_in_a_spawned_model(line: str, *, failed: bool) -> None:
    assert SIM.load_failed(f"[Msg] Loading SDF world file\n\x1b[1;31m{line}\x1b[0m\n") == failed


@pytest.mark.parametrize("mark", ["[Err] [Server.cc:86]", "(2026-11-28 07:53:24.155) [error] [ServerPrivate.cc:794]"])
def test_an_error_behind_a_warning_without_a_line_break_is_a_line_of_its_own(mark: str) -> None:
    """As Harmonic and Jetty say of a world that has a model twice."""
    warning = "Warning [Utils.cc:115] Non-unique name[a] detected 2 times in XML children of world with name[a]."
    error = f"{mark} Error Code 2: Msg: model with name[a] already exists."
    assert SIM.error_lines(f"{warning}\x1b[1;31m{error}\x1b[0m\n") == [error]


def test_the_profiler_of_a_second_server_is_no_error() -> None:
    assert SIM.error_lines("[Err] [RemoteryProfilerImpl.cc:94] Error launching Remotery: Failed to bind\n") == []


@pytest.mark.parametrize(
    ("programs_here", "file", "variable"),
    [
        ({"gz": "8.9.0\\n"}, ".gz/sim/8/server.config", "GZ_SIM_SERVER_CONFIG_PATH"),
        ({"ign": "6.16.0\\n"}, ".ignition/gazebo/6/server.config", "IGN_GAZEBO_SERVER_CONFIG_PATH"),
    ],
)
def test_a_server_in_a_home_of_its_own_keeps_to_the_users_choice_of_plugins(
    programs_here: dict[str, str],
    file: str,
    variable: str,
    programs: Path,
    world: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    put(programs, programs_here)
    here = SIM.installation()
    assert here
    opening = OpenRequest(world=world, home=Path("/home/of/its/own"))
    assert variable not in SIM.headless(here, opening).environment
    chosen = Path.home() / file
    chosen.parent.mkdir(parents=True)
    chosen.touch()
    assert SIM.headless(here, opening).environment[variable] == str(chosen)
    assert variable not in SIM.headless(here, OpenRequest(world=world)).environment
    assert variable not in SIM.paused(here, opening, Path("/home/of/its/own")).environment
    monkeypatch.setenv(variable, "/another/server.config")
    assert variable not in SIM.headless(here, opening).environment


class Listening(SimWorld):
    """A world without a server, with a robot at a place, that keeps the commands that it is sent."""

    def __init__(self, backend: str) -> None:
        self.backend, self.sent = backend, list[PublishCommand]()

    def poses(self) -> dict[str, Pose]:
        return {"one": Pose(x=1, y=2, z=0)}

    def send_command(self, command: PublishCommand) -> None:
        self.sent.append(command)


@pytest.mark.parametrize("backend", ["sim", "fortress"])
def test_belts_are_commanded_one_by_one_and_wheels_by_their_plug_in(backend: str) -> None:
    world = Listening(backend)
    world.drive("one", ROBOTS["burger"], 0.1, 0.2)
    assert world.sent == [ROBOTS["burger"].command("one", 0.1, 0.2, backend)]
    world.sent.clear()
    drive = ROBOTS["crawler"].drive
    assert isinstance(drive, Tracks)
    world.drive("one", ROBOTS["crawler"], 0.1, 0.2)
    assert world.sent == list(drive.belt_commands("one", 0.1, 0.2, posed((1, 2, 0, 0, 0, 0)), backend))
    assert len(world.sent) == 2 * len((*drive.left, *drive.right)) > 0
