"""`rsegen sim` and `rsegen open`, with stand-ins for the simulators."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from rsegen.cli.edge import main
from rsegen.driving.commands import drive
from rsegen.mujoco import simulator
from rsegen.page.forms import field
from rsegen.params.command import declared
from rsegen.simulators import open_world, process
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.commands import open as open_command
from rsegen.simulators.embedded import EMBEDDED
from rsegen.simulators.patience import Patience
from rsegen.spawning.commands import remove
from tests.simulators.standins import PROGRAMS, interrupted_when_started, put, start
from tests.support.complaints import the_line
from tests.support.shells import completed

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
Capture = pytest.CaptureFixture[str]


def opened(*arguments: str | Path) -> int:
    return main(["open", *map(str, arguments)])


def test_sim_lists_installed_simulators_and_how_to_install_the_others(programs: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["sim"])
    assert main(["sim"]) == 0
    out = capsys.readouterr().out
    assert f"Gazebo Sim 8.9.0\n           gz sim: {programs}/gz\n" in out
    assert "Gazebo Classic is not installed\n" in out
    assert all(line in out for line in SIMULATORS["classic"].how_to_install)


def test_sim_says_the_same_to_programs(programs: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["classic"])
    assert main(["sim", "--json"]) == 0
    mujoco, sim, classic = json.loads(capsys.readouterr().out)
    assert (mujoco["name"], mujoco["title"], mujoco["commands"], mujoco["problem"]) == ("mujoco", "MuJoCo", {}, "")
    assert mujoco["version"] == EMBEDDED["mujoco"].version()
    assert [row["embedded"] for row in (mujoco, sim, classic)] == [True, False, False]
    assert (sim["name"], sim["version"], sim["commands"]) == ("sim", None, {})
    assert sim["how_to_get"] == list(SIMULATORS["sim"].how_to_install)
    assert (classic["name"], classic["version"]) == ("classic", "11.14.0")
    assert classic["commands"]["gzserver"] == str(programs / "gzserver")


def test_sim_says_how_to_install_a_library_that_is_missing_or_too_old(
    programs: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    assert main(["sim"]) == 0
    assert f"mujoco   MuJoCo {EMBEDDED['mujoco'].version()}\nsim " in capsys.readouterr().out
    monkeypatch.setattr(simulator, "find_spec", lambda _: None)
    assert main(["sim"]) == 0
    advice = EMBEDDED["mujoco"].how_to_install[0]
    assert f"mujoco   MuJoCo is not installed\n           {advice}\n" in capsys.readouterr().out
    assert main(["doctor"]) == 0
    assert "MuJoCo: robots cannot be driven in it" in capsys.readouterr().out
    monkeypatch.undo()
    monkeypatch.setattr(simulator, "version", lambda _: "3.2.1")
    assert main(["sim"]) == 0
    old = "mujoco-core 3.2.1 is installed, which is too old; to install MuJoCo 4: pip install -U 'mujoco-core>=4'"
    assert f"mujoco   MuJoCo {old}; " in capsys.readouterr().out


def test_completion_and_forms_know_the_simulators_of_each_command(tmp_path: Path) -> None:
    for command, known in (
        (drive, ["classic", "mujoco", "sim"]),
        (open_command, ["classic", "mujoco", "sim"]),
        (remove, ["classic", "sim"]),
    ):
        parameter = declared(command)["simulator"]
        assert parameter.known_names
        assert sorted(parameter.known_names()) == known
        assert field(parameter)["schema"]["anyOf"][0] == {"enum": known}
    assert completed("rsegen drive --simulator ", tmp_path) == {"classic", "mujoco", "sim"}


@pytest.mark.parametrize(
    ("name", "program", "words"), [("sim", "gz", ["sim", "-s", "-r"]), ("classic", "gzserver", ["--verbose"])]
)
def test_open_starts_a_server_until_the_seconds_are_over(
    name: str, program: str, words: Sequence[str], programs: Path, world: Path, capsys: Capture
) -> None:
    put(programs, PROGRAMS[name])
    looks = iter(["", "", "rse_0000"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STAYS", "60")
        patch.setattr(open_world, "_running_world", lambda *_: next(looks))
        assert opened(world, "--simulator", name, "--headless", "--seconds", "2") == 0
    did = start(programs / program)
    assert did.command[1:-1] == tuple(words)
    assert did.folder / did.command[-1] == world
    assert Path(did.variables["HOME"]).name.startswith("rsegen-")
    assert not Path(did.variables["HOME"]).exists()
    out, err = capsys.readouterr()
    address = [f"{name}={did.variables[name]}" for name in SIMULATORS[name].address_variables]
    assert out.endswith(f": {world}, at {' '.join(address)}\n")
    assert err == ""


def test_open_fails_if_another_world_than_that_of_the_file_runs(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Gazebo Classic falls back on an empty one, as of the file of a model."""
    put(programs, PROGRAMS["classic"])
    monkeypatch.setenv("STAYS", "60")
    monkeypatch.setattr(open_world, "_running_world", lambda *_: "default")
    capsys.readouterr()
    assert opened(world, "--simulator", "classic", "--headless", "--seconds", "1") == 1
    line = the_line(capsys.readouterr().err)
    assert line.endswith("did not load the world rse_0000.world, but one of the name default")


def test_open_says_why_a_world_was_not_loaded_though_that_is_printed_elsewhere(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Gazebo Classic prints to stdout that it takes an empty world, and to stderr why, in this order or the other."""
    put(programs, PROGRAMS["classic"])
    monkeypatch.setenv("STAYS", "60")
    monkeypatch.setenv("SAYS", "Falling back on worlds/empty.world\\n")
    monkeypatch.setenv("COMPLAINS", "[Err] [Server.cc:407] Unable to read sdf file[rse_0000.world]\\n")
    capsys.readouterr()
    assert opened(world, "--simulator", "classic", "--headless", "--seconds", "1") == 1
    *told, line = capsys.readouterr().err.splitlines()
    assert told == ["[Err] [Server.cc:407] Unable to read sdf file[rse_0000.world]"]
    assert line.endswith("did not load the world rse_0000.world")


@pytest.mark.parametrize("name", ["sim", "classic"])
def test_open_fails_if_the_server_never_tells_its_time(
    name: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """It prints no error, and does not end: that alone proves nothing."""
    put(programs, PROGRAMS[name])
    monkeypatch.setenv("STAYS", "60")
    capsys.readouterr()
    assert opened(world, "--simulator", name, "--headless", "--seconds", "1", "--timeout", "1") == 1
    assert "has not loaded the world" in the_line(capsys.readouterr().err)


@pytest.mark.parametrize(("name", "program"), [("sim", "gz"), ("classic", "gazebo")])
def test_open_opens_a_window_on_a_screen(
    name: str, program: str, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS[name])
    monkeypatch.setenv("DISPLAY", ":7")
    assert opened(world.parent) == 0
    did = start(programs / program)
    assert "-s" not in did.command
    assert did.variables["DISPLAY"] == ":7"
    assert did.variables["HOME"] == str(programs.parent / "home")


@pytest.mark.parametrize(("says", "code"), [("", 0), ("[Err] [a.cc:1] no display\\n", 1)])
def test_a_closed_window_is_no_failure_but_one_that_never_opened_is(
    says: str, code: int, programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["classic"])
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setenv("SAYS", says)
    monkeypatch.setenv("STAYS", "no time at all")  # sleep exits with 1
    assert opened(world) == code


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
@pytest.mark.parametrize("name", list(SIMULATORS))
def test_without_a_screen_it_offers_to_open_without_a_window(
    name: str, programs: Path, world: Path, capsys: Capture
) -> None:
    put(programs, PROGRAMS[name])
    capsys.readouterr()
    assert opened(world) == 2
    line = the_line(capsys.readouterr().err)
    assert line.startswith("rsegen: no screen here")
    assert line.endswith("; open the server alone with --headless")


def test_an_installation_without_its_window_is_reported(programs: Path, world: Path, capsys: Capture) -> None:
    put(programs, {"gzserver": PROGRAMS["classic"]["gzserver"]})
    capsys.readouterr()
    assert opened(world, "--print") == 2
    assert "Gazebo Classic 11.14.0 is installed without its window; install it" in the_line(capsys.readouterr().err)


def test_without_simulators_every_installation_is_explained(programs: Path, world: Path, capsys: Capture) -> None:
    capsys.readouterr()
    assert opened(world) == 2
    line = the_line(capsys.readouterr().err)
    assert all(simulator.how_to_install[0] in line for simulator in SIMULATORS.values())


def test_a_map_for_classic_opens_in_each(programs: Path, classic_world: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["sim"])
    capsys.readouterr()
    assert opened(classic_world, "--print", "--headless") == 0
    assert f"{programs}/gz sim " in capsys.readouterr().out


def test_the_target_simulator_is_chosen_else_the_newest(
    programs: Path, world: Path, classic_world: Path, capsys: Capture
) -> None:
    put(programs, {**PROGRAMS["classic"], **PROGRAMS["sim"]})
    capsys.readouterr()
    assert opened(world, "--print", "--headless") == 0
    assert f"{programs}/gz sim " in capsys.readouterr().out
    assert opened(classic_world, "--print", "--headless") == 0
    assert f"{programs}/gzserver " in capsys.readouterr().out


def test_print_opens_nothing(programs: Path, world: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["sim"])
    capsys.readouterr()
    assert opened(world, "--print") == 0
    assert capsys.readouterr().out.startswith(f"cd '{world.parent}' && GZ_SIM_RESOURCE_PATH='{world.parent.parent}' ")
    assert not Path(programs / "gz.started").exists()


def test_a_recipe_is_opened_as_a_world_that_then_goes(programs: Path, tmp_path: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["sim"])
    recipe = tmp_path / "course.yaml"
    recipe.write_text("name: course\nmaps: 3\nseed: 1\nchunk_size: 2\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STAYS", "60")
        with interrupted_when_started(programs / "gz"):
            assert opened(recipe, "--map", "2", "--headless") == 0
    world = Path(start(programs / "gz").command[-1])
    assert world.name == "course_0002.world"
    assert not world.parent.parent.exists()
    capsys.readouterr()
    assert opened(recipe, "--print") == 2
    assert "make one with rsegen generate" in the_line(capsys.readouterr().err)


NO_MESH = "[Err] [a.cc:1] no such mesh"


@pytest.mark.parametrize(
    ("says", "told", "words"),
    [
        (
            "[Err] [b.cc:1] Failed to find world [a]",
            "[Err] [b.cc:1] Failed to find world [a]",
            "did not load the world",
        ),
        (f"\\033[1;31m{NO_MESH}\\033[0m", NO_MESH, "printed an error: "),
        ("(2026) [error] no such mesh", "(2026) [error] no such mesh", "printed an error: "),
    ],
)
def test_an_error_of_the_server_is_printed_and_fails(
    says: str, told: str, words: str, programs: Path, world: Path, capsys: Capture
) -> None:
    put(programs, PROGRAMS["sim"])
    capsys.readouterr()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SAYS", f"[Msg] hello\\n{says}\\n")
        patch.setenv("STAYS", "60")
        assert opened(world, "--headless", "--seconds", "2", "--timeout", "1") == 1
    first, line = capsys.readouterr().err.splitlines()
    assert first == told
    assert words in line


def test_a_server_that_ends_by_itself_is_a_failure(programs: Path, world: Path, capsys: Capture) -> None:
    put(programs, PROGRAMS["sim"])
    capsys.readouterr()
    assert opened(world, "--headless") == 1
    assert "Gazebo Sim 8.9.0 ended by itself, with exit code 0" in the_line(capsys.readouterr().err)


def test_shared_leaves_the_address_to_the_user(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("GZ_PARTITION", "lab")
    monkeypatch.setenv("STAYS", "60")
    for flags, is_shared in ((["--shared"], True), ([], False)):
        with interrupted_when_started(programs / "gz"):
            assert opened(world, "--headless", *flags) == 0
        assert (start(programs / "gz").variables["GZ_PARTITION"] == "lab") == is_shared
        (programs / "gz.started").unlink()


def test_an_installed_simulator_that_does_not_answer_is_told_as_such(
    programs: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """On a busy machine Gazebo's programs may take long to say their version; then they are not "not installed"."""
    programs.mkdir(exist_ok=True)
    (programs / "gzserver").write_text("#!/bin/sh\nexec sleep 60\n")
    (programs / "gzserver").chmod(0o755)
    monkeypatch.setattr(process, "_SHORT_COMMAND", Patience(seconds=0.5))
    assert main(["sim"]) == 0
    why = f"{programs}/gzserver --version prints nothing, after 0.5 s without progress"
    assert f"Gazebo Classic {why}\n" in capsys.readouterr().out
    assert main(["open", "mixed-course", "--simulator", "classic", "--headless"]) == 1
    assert the_line(capsys.readouterr().err) == f"rsegen: {why}"
