"""Contract of all simulators: a new file is tested here the moment it exists, with stand-ins."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rsegen.errors import SimulatorFailed
from rsegen.simulators.base import SIMULATORS, Installation, OpenRequest, Simulator, installations
from rsegen.simulators.gazebo_classic import STATE
from rsegen.writing.programs import LaunchCommand
from tests.simulators.standins import PROGRAMS, put, start

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
STATES = (
    "<gazebo_log>\n<chunk encoding='txt'><![CDATA[\n<sdf version='1.7'><state world_name='course'>"
    "<sim_time>1 50000000</sim_time><model name='burger_0'><pose>0 1 0.1 0 0 0.5</pose></model></state></sdf>]]>\n"
    "</chunk>\n</gazebo_log>\n"
)
EACH = pytest.mark.parametrize("simulator", SIMULATORS.values(), ids=list(SIMULATORS))


def installed(simulator: Simulator, programs: Path) -> Installation:
    put(programs, PROGRAMS[simulator.name])
    here = simulator.installation()
    assert here
    return here


def launches(here: Installation, opening: OpenRequest) -> Iterator[LaunchCommand]:
    windowed = here.simulator.with_gui(here, opening)
    assert windowed
    yield windowed
    yield here.simulator.headless(here, opening)
    yield here.simulator.paused(here, opening, Path("/home/of/its/own"))


@EACH
def test_it_says_in_whole_lines_how_to_get_it(simulator: Simulator) -> None:
    assert simulator.how_to_install
    assert all(line == line.strip() and "\n" not in line for line in (simulator.title, *simulator.how_to_install))


@EACH
def test_it_is_not_found_where_nothing_is(simulator: Simulator, programs: Path) -> None:
    assert simulator.installation() is None


@EACH
def test_it_is_not_found_where_the_programs_of_another_are(simulator: Simulator, programs: Path) -> None:
    for name in set(PROGRAMS) - {simulator.name}:
        put(programs, PROGRAMS[name])
    assert simulator.installation() is None


@EACH
def test_it_is_found_with_its_version_and_its_commands(simulator: Simulator, programs: Path) -> None:
    here = installed(simulator, programs)
    assert here.version in "".join(PROGRAMS[simulator.name].values())
    assert str(here) == f"{simulator.title} {here.version}"
    assert {path.parent for path in here.commands.values()} == {programs}
    assert list(installations()) == [here]


@EACH
def test_a_launch_has_all_that_the_world_needs(simulator: Simulator, programs: Path, world: Path) -> None:
    for launch in launches(installed(simulator, programs), OpenRequest(world=world)):
        assert Path(launch.command[0]).parent == programs
        assert launch.folder / launch.command[-1] == world
        assert launch.folder == world.parent
        assert str(world.parent.parent) in launch.environment.values()


@EACH
def test_models_are_looked_for_before_where_the_user_has_them(
    simulator: Simulator, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = installed(simulator, programs)
    plain = here.simulator.headless(here, OpenRequest(world=world))
    for name in (name for name, value in plain.environment.items() if value == str(world.parent.parent)):
        monkeypatch.setenv(name, "/the/user's")
        given = here.simulator.headless(here, OpenRequest(world=world, models=Path("/given")))
        assert given.environment[name] == "/given:/the/user's"


@EACH
def test_every_launch_has_an_address_of_its_own_unless_it_is_shared(
    simulator: Simulator, programs: Path, world: Path
) -> None:
    here, alone = installed(simulator, programs), OpenRequest(world=world)
    shared = replace(alone, shared=True)
    for one, other in zip(launches(here, alone), launches(here, alone), strict=True):
        assert one.command == other.command
        differing = {name for name, value in one.environment.items() if value != other.environment[name]}
        assert differing == set(here.simulator.address_variables)
    for one, other in zip(launches(here, shared), launches(here, shared), strict=True):
        assert one == other


@EACH
def test_only_a_server_has_a_home_of_its_own(simulator: Simulator, programs: Path, world: Path) -> None:
    windowed, headless, standing = launches(installed(simulator, programs), OpenRequest(world=world))
    assert "HOME" not in {*windowed.environment, *headless.environment}
    assert standing.environment["HOME"] == "/home/of/its/own"


@EACH
def test_the_printed_line_launches_the_same_in_a_shell(simulator: Simulator, programs: Path, world: Path) -> None:
    for launch in launches(installed(simulator, programs), OpenRequest(world=world)):
        subprocess.run(["/bin/sh", "-c", launch.shell_line], check=True)
        did = start(Path(launch.command[0]))
        assert (did.folder, did.command) == (launch.folder, launch.command)
        assert {name: did.variables[name] for name in launch.environment} == launch.environment


@EACH
def test_error_lines_are_recognised(simulator: Simulator) -> None:
    log = "\n".join(
        [
            "\x1b[1;32m[Msg] all is well\x1b[0m",
            "\x1b[1;31m[Err] [Server.cc:1] \x1b[0m\x1b[1;31mno mesh\x1b[0m",
            *(f"[Err] {known}" for known in simulator.harmless_messages),
            "(2026-01-01 00:00:00.000) [error] [Server.cc:1] no plug-in",
        ]
    )
    found = simulator.error_lines(log)
    assert found == [
        "[Err] [Server.cc:1] no mesh",
        "(2026-01-01 00:00:00.000) [error] [Server.cc:1] no plug-in",
    ]


@EACH
def test_a_world_that_failed_to_load_is_found_in_the_log(simulator: Simulator) -> None:
    assert simulator.load_failures
    assert all(simulator.load_failed(f"[Err] [a.cc:1] {words} that") for words in simulator.load_failures)
    assert not simulator.load_failed("")


@pytest.mark.parametrize("kept", [None, "", "<gazebo_log>\n<chunk>", STATES.removesuffix("</gazebo_log>\n")])
def test_a_record_that_classic_could_not_complete_is_a_failure_that_is_tried_again(
    kept: str | None, tmp_path: Path
) -> None:
    file, simulator = tmp_path / STATE, SIMULATORS["classic"]
    file.parent.mkdir()
    file.write_text(STATES)
    assert simulator.read_record(tmp_path) == [(1.05, {"burger_0": [0, 1, 0.1, 0, 0, 0.5]})]
    file.unlink() if kept is None else file.write_text(kept)
    with pytest.raises(SimulatorFailed, match="Gazebo Classic was killed before its record was complete"):
        simulator.read_record(tmp_path)
