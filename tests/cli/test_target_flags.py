"""Commands that look at maps take a recipe's flags: over a recipe, or in place of one."""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from types import SimpleNamespace

import pytest

import rsegen
import rsegen.driving.commands
import rsegen.simulators.commands
import rsegen.spawning.commands
from rsegen import Peak, Random
from rsegen.cli.command_line import parsed as parsed_words
from rsegen.cli.edge import main
from rsegen.cli.flags import obstacle_in, target_of
from rsegen.errors import ParameterError
from rsegen.obstacles.base import Obstacle
from rsegen.recipe.examples import EXAMPLES
from rsegen.simulators.open_world import OpenedWorld, OpenResult
from rsegen.simulators.poses import Pose
from rsegen.spawning.spawning import SpawnResult
from tests.support.complaints import exit_code, the_line
from tests.support.runs import contents

RANDOM = ["--obstacle", "random levels=5", "--chunk-size", "4", "--seed", "3"]
ROW = [rsegen.Random(levels=5)]
RECIPE = rsegen.Recipe(seed=3, chunk_size=4, obstacles=ROW)

COMMANDS = {
    "info": ["info", "--json"],
    "metrics": ["metrics", "--json"],
    "preview": ["preview", "-o", "made/map.svg"],
    "sheet": ["sheet", "-o", "made/map.csv"],
    "view": ["view", "-o", "made/map.html"],
    "export": ["export", "--to", "heightmap", "-o", "made"],
}


def made(capsys: pytest.CaptureFixture[str], *command: str) -> tuple[str, dict[str, bytes]]:
    """Output and files of a command."""
    capsys.readouterr()
    assert main(list(command)) == 0
    return capsys.readouterr().out, contents(Path("made"))


@pytest.mark.parametrize("command", COMMANDS)
def test_flags_alone_make_the_map_of_their_recipe(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rsegen.save(RECIPE, "recipe.yaml")
    of_file = made(capsys, *COMMANDS[command], "recipe.yaml")
    shutil.rmtree("made", ignore_errors=True)
    assert made(capsys, *COMMANDS[command], *RANDOM) == of_file


@pytest.mark.parametrize("command", COMMANDS)
def test_flags_override_the_recipe(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rsegen.save(rsegen.Recipe(seed=8, chunk_size=4), "plain.yaml")
    rsegen.save(RECIPE, "recipe.yaml")
    of_file = made(capsys, *COMMANDS[command], "recipe.yaml")
    shutil.rmtree("made", ignore_errors=True)
    assert made(capsys, *COMMANDS[command], "plain.yaml", *RANDOM) == of_file


def test_flags_override_every_map_of_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rsegen.generate(rsegen.Recipe(seed=8, maps=2, chunk_size=4, obstacles=ROW), tmp_path)
    assert main(["metrics", str(tmp_path), "--seed", "3", "--json"]) == 0
    assert [one["seed"] for one in json.loads(capsys.readouterr().out)] == [3, 3]


def test_a_map_of_flags_is_chosen_by_its_index(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", *RANDOM, "--maps", "3", "--map", "2"]) == 0
    assert capsys.readouterr().out.startswith("rse_0002, seed 3\n")
    assert exit_code("info", *RANDOM, "--map", "2") == 2
    assert "there is no map '2' in the recipe of the flags" in the_line(capsys.readouterr().err)


def without_a_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the commands that need a simulator return at once, as if they had found one."""

    @wraps(rsegen.drive)
    def drive(*_: object, **__: object) -> SimpleNamespace:
        return SimpleNamespace(report=lambda: iter(["driven"]), as_json={})

    @wraps(rsegen.open)
    def open_world(*_: object, on_start: Callable[[OpenedWorld], None], **__: object) -> OpenResult:
        world = OpenedWorld(simulator="Gazebo", file=Path("a.world"), address=())
        on_start(world)
        return OpenResult(world=world, exit_code=0, errors=())

    @wraps(rsegen.spawn)
    def spawn(*_: object, **__: object) -> SpawnResult:
        return SpawnResult(name="model", simulator="sim", at=Pose(x=0, y=0, z=0))

    monkeypatch.setattr(rsegen.driving.commands, "drive", drive)
    monkeypatch.setattr(rsegen.simulators.commands, "open", open_world)
    monkeypatch.setattr(rsegen.spawning.commands, "spawn", spawn)


@pytest.mark.parametrize("command", ["info", "preview", "sheet", "spots", "compare", "open", "drive", "spawn"])
def test_the_first_map_of_a_folder_is_taken_with_a_note(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    without_a_simulator(monkeypatch)
    for folder, maps in (("own", 3), ("alone", 1)):
        rsegen.generate(rsegen.Recipe(seed=8, maps=maps, chunk_size=4), folder)
    words = [*COMMANDS.get(command, [command]), *(["alone"] if command == "compare" else [])]
    words += ["--force"] if "-o" in words else []

    def noted(*target: str) -> str:
        capsys.readouterr()
        assert main([*words, *target]) == 0
        printed = capsys.readouterr()
        lines = (printed.err if "--json" in words else printed.out).splitlines()
        return "; ".join(line for line in lines if "note:" in line)

    assert noted("own") == "note: rse_0000 is the first of 3 maps in own; --map selects another"
    assert noted("own/rse_0001") == noted("alone") == ""
    if command != "compare":  # of which --map is a map of both
        assert noted("own", "--map", "1") == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_nothing_to_look_at_is_refused_in_one_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*COMMANDS[command], "--seed", "3") == 2
    line = the_line(capsys.readouterr().err)
    assert "no input; pass a recipe, a folder or --obstacle 'random levels=5'" in line


def parsed(*command: str) -> argparse.Namespace:
    found: argparse.Namespace = parsed_words(command)
    return found


@pytest.mark.parametrize("command", ["open", "drive", "spawn"])
def test_commands_of_the_simulation_take_a_recipe_of_flags_alone_or_over_one(command: str) -> None:
    without = {"open": ("simulator",), "drive": (), "spawn": ("simulator", "name")}[command]
    assert target_of(parsed(command, *RANDOM), without) == RECIPE
    assert target_of(parsed(command, "peak", "--chunk-size", "11", "--map", "0"), without) == replace(
        rsegen.load(EXAMPLES["peak"]), chunk_size=11
    )
    assert target_of(parsed(command, "peak"), without) == "peak"


def test_the_seed_of_a_drive_leaves_the_map_of_a_recipe_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[object, int]] = []

    @wraps(rsegen.drive)
    def drive(target: object, *, seed: int, **_: object) -> None:
        asked.append((target, seed))
        raise rsegen.UserError("that is enough")

    monkeypatch.setattr(rsegen.driving.commands, "drive", drive)
    assert main(["drive", "peak", "--seed", "5"]) == 2
    assert main(["drive", *RANDOM]) == 2
    assert asked == [("peak", 5), (RECIPE, 3)]


def test_the_name_of_a_spawned_model_and_the_simulator_are_not_the_recipe_s(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    @wraps(rsegen.spawn)
    def spawn(target: object, *, name: str, simulator: str, **_: object) -> None:
        asked.extend([target, name, simulator])
        raise rsegen.UserError("that is enough")

    monkeypatch.setattr(rsegen.spawning.commands, "spawn", spawn)
    assert main(["spawn", *RANDOM, "--name", "field", "--simulator", "classic"]) == 2
    assert asked == [RECIPE, "field", "classic"]


def test_the_page_opens_a_recipe_of_flags(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from rsegen.page.service import Service

    opened: list[object] = []
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def run(service: Service) -> None:
        opened.extend(document.session.recipe for document in service.host.all())
        service.close()

    monkeypatch.setattr(Service, "run", run)
    assert main(["gui", "--no-browser", "--port", "0", *RANDOM]) == 0
    assert opened == [RECIPE]
    assert "&doc=d1" in capsys.readouterr().out


def test_the_page_of_a_folder_of_maps_says_how_to_open_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from rsegen.page.service import Service

    monkeypatch.setattr(Service, "run", Service.close)
    monkeypatch.chdir(tmp_path)
    rsegen.generate(rsegen.Recipe(seed=8, maps=12, chunk_size=1), "my maps")

    def printed(*words: str) -> list[str]:
        assert main(["gui", *words, "--no-browser", "--port", "0"]) == 0
        return capsys.readouterr().out.splitlines()[1:]

    home, title, first, *others = printed("my maps")
    assert home.endswith("/my maps. To stop, close the page or press Ctrl-C.")
    assert (title, first, others[-1]) == (
        "No map is open. Maps in my maps:",
        "  rsegen gui 'my maps/rse_0000'",
        "  and 2 more",
    )
    assert len(printed("my maps/rse_0000")) == 1
    assert printed("--keep") == [f"The page edits files in {tmp_path}. To stop, press Ctrl-C."]


def test_the_page_plays_the_drive_of_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from rsegen.page.service import Service

    monkeypatch.setattr(Service, "run", Service.close)
    monkeypatch.chdir(tmp_path)
    for name in ("map", "drive"):
        (tmp_path / name).mkdir()
        rsegen.save(RECIPE, tmp_path / name / "recipe.json")
    (tmp_path / "drive" / "drive.json").write_text("{}")
    for name, plays in (("drive", True), ("map", False)):
        assert main(["gui", name, "--no-browser", "--port", "0"]) == 0
        assert ("&play=drive" in capsys.readouterr().out) == plays


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("peak levels=5 first=[2, 2] last=[4,4]", Peak(levels=5, first=(2, 2), last=(4, 4))),
        ("peak levels=5 first=2, 2", Peak(levels=5, first=(2, 2))),
        ("random levels=3 weights=[ 1 ,2, 1 ]", Random(levels=3, weights=(1, 2, 1))),
    ],
)
def test_lists_of_an_obstacle_may_have_blanks_as_recipes_have_them(written: str, meant: Obstacle) -> None:
    assert obstacle_in(written) == meant


def test_blanks_in_quotation_marks_stay() -> None:
    with pytest.raises(ParameterError, match="key: invalid value 'a, b'"):
        obstacle_in("peak levels=5 key='a, b'")
