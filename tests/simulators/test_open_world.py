"""`rsegen.open` in Python, with stand-ins for the simulators."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import rsegen
from rsegen.errors import NoSimulator, ParameterError, SimulatorFailed, UnknownName, UserError
from rsegen.simulators import open_world
from rsegen.simulators.open_world import OpenedWorld
from tests.simulators.standins import PROGRAMS, interrupted_when_started, put, start

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
COURSE = rsegen.Recipe(name="course", seed=1, chunk_size=2, maps=3)
TARGETS: dict[str, Callable[[Path], rsegen.Recipe | rsegen.Scene | str | Path]] = {
    "recipe": lambda _: COURSE,
    "scene": lambda _: rsegen.compose(COURSE, 0),
    "recipe file": lambda folder: saved(folder / "course.yaml"),
    "world file": lambda folder: rsegen.generate(COURSE, folder).maps[0].world,
    "folder of a map": lambda folder: str(rsegen.generate(COURSE, folder).maps[0].folder),
    "folder of maps": lambda folder: rsegen.generate(COURSE, folder / "maps").folder,
}


def saved(file: Path) -> Path:
    rsegen.save(COURSE, file)
    return file


@pytest.mark.parametrize("name", TARGETS)
def test_every_target_is_opened(name: str, programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "600")
    started: list[OpenedWorld] = []
    target = TARGETS[name](tmp_path)
    with interrupted_when_started(programs / "gz", while_read=True):
        result = rsegen.open(target, headless=True, on_start=started.append)
    assert started == [result.world]
    assert result.world.file
    assert result.world.file.name == "course_0000.world"
    assert result.world.simulator == "Gazebo Sim 8.9.0"
    assert (result.exit_code, result.errors) == (None, ())
    did = start(programs / "gz")
    assert Path(did.command[-1]) == result.world.file
    assert dict(result.world.address).items() <= did.variables.items()
    assert result.world.file.exists() == (name not in ("recipe", "scene", "recipe file"))


def test_a_map_of_a_recipe_is_chosen_by_index_or_name(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "600")
    monkeypatch.setattr(open_world, "_running_world", lambda _, launch: Path(launch.command[-1]).stem)
    for which in (2, "2", "course_0002"):
        result = rsegen.open(COURSE, map=which, headless=True, seconds=0)
        assert result.world.file
        assert result.world.file.name == "course_0002.world"
    for target in (COURSE, saved(tmp_path / "course.yaml")):
        with pytest.raises(
            ParameterError, match=r"^map: there is no map .*; use an index or name, course_0000\.\.course_0002$"
        ):
            rsegen.open(target, map=3, headless=True)


@pytest.fixture
def maps_of_a_lost_plugin(tmp_path: Path) -> Path:
    """A folder of maps that somebody made with a plug-in which is not installed here."""
    made = rsegen.generate(COURSE, tmp_path / "maps")
    for generated in made.maps:
        file = generated.folder / "recipe.json"
        content = json.loads(file.read_text("utf-8"))
        content |= {"plugins": {"ramp": "rsegen-ramps 1.2"}, "obstacles": [{"kind": "ramp", "levels": 5}]}
        file.write_text(json.dumps(content), "utf-8")
    return made.folder


@pytest.mark.parametrize(
    ("target", "which", "opened"),
    [
        ("", None, "course_0000"),
        ("", "course_0001", "course_0001"),
        ("", 2, "course_0002"),
        ("course_0001", None, "course_0001"),
        ("course_0001/course_0001.world", None, "course_0001"),
    ],
)
def test_a_world_is_opened_without_the_plugin_that_made_it(
    maps_of_a_lost_plugin: Path,
    programs: Path,
    monkeypatch: pytest.MonkeyPatch,
    target: str,
    which: str | int | None,
    opened: str,
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "600")
    monkeypatch.setattr(open_world, "_running_world", lambda _, launch: Path(launch.command[-1]).stem)
    result = rsegen.open(maps_of_a_lost_plugin / target, map=which, headless=True, seconds=0)
    assert result.world.file == maps_of_a_lost_plugin / opened / f"{opened}.world"


def test_what_needs_the_heights_of_a_world_names_the_plugin_that_made_it(maps_of_a_lost_plugin: Path) -> None:
    for target in ("", "course_0001", "course_0001/course_0001.world"):
        with pytest.raises(UserError, match=r"recipe.json: the obstacle kind 'ramp' of rsegen-ramps 1.2 is not"):
            rsegen.open(maps_of_a_lost_plugin / target, simulator="mujoco", headless=True, seconds=0)
    with pytest.raises(UserError, match="ramp"):
        rsegen.open(maps_of_a_lost_plugin, map=7, simulator="classic", headless=True, seconds=0)


def test_error_lines_are_passed_on_and_a_failure_of_a_server(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["sim"])
    monkeypatch.setenv("STAYS", "600")
    monkeypatch.setenv("SAYS", "[Err] [a.cc:1] no such mesh\\n")
    lines: list[str] = []

    def note_and_stop(line: str) -> None:
        lines.append(line)
        raise KeyboardInterrupt

    with pytest.raises(SimulatorFailed, match="printed an error: "):
        rsegen.open(world, headless=True, on_error=note_and_stop)
    assert lines == ["[Err] [a.cc:1] no such mesh"]


def test_error_lines_that_differ_in_numbers_alone_are_passed_on_once_and_counted(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(programs, PROGRAMS["classic"])
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setenv("COMPLAINS", "".join(f"[Err] [a.cc:1] no entity [{number}]\\n" for number in range(40)))
    lines: list[str] = []
    result = rsegen.open(world, simulator="classic", on_error=lines.append)
    counted = "[Err] [a.cc:1] no entity [0] (40 times)"
    assert lines == ["[Err] [a.cc:1] no entity [0]", counted]
    assert (result.exit_code, result.errors) == (0, (counted,))


def test_a_file_without_a_world_is_named(programs: Path, tmp_path: Path) -> None:
    put(programs, PROGRAMS["sim"])
    model = tmp_path / "model.sdf"
    model.write_text('<sdf version="1.6"><model name="one"/></sdf>')
    with pytest.raises(SimulatorFailed, match=r"ended by itself, because there is no <world> in .*model\.sdf"):
        rsegen.open(model, headless=True)


def test_an_installation_whose_libraries_do_not_fit_is_told_with_the_reason(
    programs: Path, world: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the line a user would read an exit code alone."""
    put(programs, PROGRAMS["sim"])
    told = "Library error for [/opt/lib/libgz-sim8-gz.so]: /opt/lib/libgz-sim8.so.8: undefined symbol: _ZTIN2gz"
    monkeypatch.setenv("SAYS", f"{told}\\n")
    lines: list[str] = []
    with pytest.raises(SimulatorFailed, match=r"^Gazebo Sim 8\.9\.0 did not load the world "):
        rsegen.open(world, headless=True, on_error=lines.append)
    assert lines == [told]


def test_wrong_values_name_the_parameter(programs: Path, world: Path) -> None:
    with pytest.raises(ParameterError, match=r"^seconds: -1 is outside"):
        rsegen.open(world, seconds=-1)
    with pytest.raises(UnknownName, match=r"^simulator: unknown simulator 'clasic'; did you mean 'classic'"):
        rsegen.open(world, simulator="clasic")
    with pytest.raises(NoSimulator, match="is not installed"):
        rsegen.open(world)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
def test_a_window_needs_a_screen(programs: Path, world: Path) -> None:
    put(programs, PROGRAMS["sim"])
    with pytest.raises(UserError, match=r"^no screen here .*; open the server alone with headless=True$"):
        rsegen.open(world)
