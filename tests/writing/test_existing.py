"""Maps of a run that was stopped are kept, and the rest is as if it had never been stopped."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Recipe
from rsegen.errors import OutputError, ParameterError
from rsegen.recipe.building import placed_obstacles
from rsegen.recipe.codec import map_json, to_json
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.runs import contents, ended, started, until_there
from tests.support.strategies import recipes

OBSTACLE = ["--obstacle", "random levels=5", "--chunk-size", "4", "--seed", "7"]

LARGER = ["--chunks", "10"]
"""Threshold from which workers are started; it is lower, so that there are fewer files."""


def generated(folder: Path, *arguments: str) -> object:
    return exit_code("generate", *OBSTACLE, *arguments, "-o", folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a run that nobody stops."""
    folder = tmp_path_factory.mktemp("whole")
    assert generated(folder, *LARGER, "--maps", "80") == 0
    return contents(folder)


def stamps(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_ino for path in folder.iterdir()}


def hidden(folder: Path) -> list[Path]:
    return list(folder.glob(".*"))


@given(recipes(), st.integers(0, 20_000), st.integers(0, 9))
def test_recipe_json_is_foretold(recipe: Recipe, first: int, further: int) -> None:
    recipe = replace(recipe, first_map=first, maps=10, description='"first_map": 0, \\n  "first_map": 0,')
    expected = to_json(replace(recipe, first_map=first + further, maps=1)).encode()
    text = map_json(recipe, first + further)
    rows = [*placed_obstacles(recipe, first + further, only_by_chance=True)]
    if not rows:
        assert text == expected
        return
    assert text.startswith(expected.removesuffix(b"\n}\n") + b',\n  "placed": [')
    assert json.loads(text) == json.loads(expected) | {"placed": rows}


@pytest.mark.slow
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGKILL], ids=lambda stop: stop.name)
def test_a_run_that_was_stopped_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: dict[str, bytes], stop: signal.Signals
) -> None:
    maps = [*LARGER, "--maps", "80", "--workers", "2"]
    process = started("generate", *OBSTACLE, *maps, "-o", tmp_path / "out")
    until_there(process, tmp_path / "out", 20)
    process.send_signal(stop)
    _, err = ended(process)
    before = stamps(tmp_path / "out")
    assert stop is signal.SIGKILL or f"stopped; {len(before)} of 80 maps are complete" in err
    assert generated(tmp_path / "out", *maps, "--resume") == 0
    after = stamps(tmp_path / "out")
    kept = {name for name in before if not name.startswith(".")}
    assert {name: after[name] for name in kept} == {name: before[name] for name in kept}
    assert f"{len(kept)} maps already exist, seed 7\n{80 - len(kept)} maps of 40 x 40 blocks" in capsys.readouterr().out
    assert hidden(tmp_path / "out") == []
    assert contents(tmp_path / "out") == whole


@pytest.mark.slow
def test_the_message_of_a_stopped_run_says_how_to_go_on(tmp_path: Path) -> None:
    command: list[str | Path] = ["generate", "--obstacle", "peak levels=3", "--maps", "200", "-o", tmp_path / "out"]
    process = started(*command)
    until_there(process, tmp_path / "out", 3)
    process.send_signal(signal.SIGINT)
    match = re.search("the same command with (--seed [0-9]+ --resume) makes the others", the_line(ended(process)[1]))
    assert match
    assert exit_code(*command, *match[1].split()) == 0
    assert len(list((tmp_path / "out").iterdir())) == 200


def test_maps_anywhere_in_the_row_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert generated(tmp_path, "--first-map", "3", "--maps", "2") == 0
    before = stamps(tmp_path)
    capsys.readouterr()
    assert generated(tmp_path, "--maps", "8", "--resume", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["already"] == ["rse_0003", "rse_0004"]
    assert [one["index"] for one in told["maps"]] == [0, 1, 2, 5, 6, 7]
    assert before.items() <= stamps(tmp_path).items()


def test_no_map_is_made_if_all_exist(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert generated(tmp_path, "--maps", "2") == 0
    before = stamps(tmp_path)
    capsys.readouterr()
    assert generated(tmp_path, "--maps", "2", "--resume") == 0
    assert capsys.readouterr().out == "2 maps already exist, seed 7\n"
    assert stamps(tmp_path) == before


def test_nothing_to_resume_is_a_run_from_the_start(tmp_path: Path) -> None:
    assert generated(tmp_path / "new", "--maps", "2", "--resume") == 0
    assert generated(tmp_path / "plain", "--maps", "2") == 0
    assert contents(tmp_path / "new") == contents(tmp_path / "plain")


@pytest.mark.parametrize(
    "other",
    [["--seed", "8"], ["--mesh-type", "pallet"], ["--obstacle", "peak levels=2"]],
    ids=lambda flags: flags[0],
)
def test_a_map_of_another_recipe_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], other: Sequence[str]
) -> None:
    assert generated(tmp_path, "--first-map", "2") == 0
    (tmp_path / ".rse_0001.0123abcd").mkdir()
    before = snapshot(tmp_path)
    capsys.readouterr()
    assert generated(tmp_path, "--maps", "4", *other, "--resume") == 2
    assert "rse_0002: exists already and is not this map" in the_line(capsys.readouterr().err)
    assert snapshot(tmp_path) == before


@pytest.mark.parametrize("name", ["recipe.json", "thesis.tex"])
def test_a_folder_that_is_no_map_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "rse_0000").mkdir()
    (tmp_path / "rse_0000" / name).write_text("years of work")
    with pytest.raises(OutputError, match="is not this map"):
        rsegen.generate(Recipe(seed=7), tmp_path, resume=True)
    assert contents(tmp_path) == {f"rse_0000/{name}": b"years of work"}


def test_to_keep_and_to_replace_exclude_each_other(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="resume: resume=True and force=True exclude each other"):
        rsegen.generate(Recipe(seed=7), tmp_path, resume=True, force=True)
    assert list(tmp_path.iterdir()) == []


def test_only_the_hidden_folder_of_rsegen_is_cleared_away(tmp_path: Path) -> None:
    spared = [".rsegen.0123abcd", ".rsegen.old", ".rsegen.next", ".other", ".git"]
    for name in [".rsegen", *spared]:
        (tmp_path / name / "new").mkdir(parents=True)
        (tmp_path / name / "new" / "recipe.json").write_text("{}")
    assert generated(tmp_path, "--maps", "2") == 0
    assert {path.name for path in tmp_path.iterdir()} == {*spared, "rse_0000", "rse_0001"}


@pytest.mark.slow
@pytest.mark.parametrize("flag", ["--preview", "--sheet"])
def test_a_map_without_a_requested_sidecar_is_made_again(tmp_path: Path, flag: str) -> None:
    assert generated(tmp_path / "a", flag) == 0
    assert generated(tmp_path / "a", "--first-map", "1") == 0
    before = stamps(tmp_path / "a")
    assert generated(tmp_path / "a", "--maps", "2", flag, "--resume") == 0
    assert generated(tmp_path / "b", "--maps", "2", flag) == 0
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert stamps(tmp_path / "a")["rse_0000"] == before["rse_0000"]


@pytest.mark.slow
def test_what_earlier_runs_added_to_a_map_is_kept(tmp_path: Path) -> None:
    assert generated(tmp_path / "a", "--sheet") == 0
    assert generated(tmp_path / "a", "--preview", "--resume") == 0
    (tmp_path / "a" / "rse_0000" / "rse_0000.world").unlink()
    assert generated(tmp_path / "a", "--resume") == 0
    assert generated(tmp_path / "b", "--preview", "--sheet") == 0
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_without_preview_a_map_with_a_picture_is_complete(tmp_path: Path) -> None:
    assert generated(tmp_path, "--preview") == 0
    before = snapshot(tmp_path)
    assert generated(tmp_path, "--resume") == 0
    assert snapshot(tmp_path) == before


def test_what_is_left_of_a_run_that_was_killed_before_its_first_journal_is_cleared_away(tmp_path: Path) -> None:
    """A kill while the journal of the new data set is written, from a trial of tests/crash."""
    arguments = ["dataset", *OBSTACLE, "--maps", "20", "-o", str(tmp_path / "set")]
    assert exit_code(*arguments) == 0
    before = contents(tmp_path / "set")
    left = tmp_path / "set" / ".rsegen.next" / ".rsegen"
    (left / "new").mkdir(parents=True)
    (left / "lock").write_text("{}")
    (left / "new" / ".rsegen.jsonl").write_text("{")
    assert exit_code(*arguments, "--force") == 0
    assert contents(tmp_path / "set") == before
