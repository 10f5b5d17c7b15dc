"""The recipes to start from, by their names."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import or_example


def test_examples_are_listed_with_their_descriptions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(maxsplit=1) for line in lines] == [
        [name, rsegen.load(path).description] for name, path in EXAMPLES.items()
    ]


def test_copies_of_examples_are_byte_identical(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", "-o", str(tmp_path / "new")]) == 0
    made = sorted((tmp_path / "new").glob("*.yaml"))
    assert capsys.readouterr().out.splitlines() == [str(path) for path in made]
    assert {path.stem: path.read_bytes() for path in made} == {n: path.read_bytes() for n, path in EXAMPLES.items()}


def test_an_existing_file_keeps_all_examples_from_being_copied(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "turtlebot.yaml").write_text("mine")
    assert main(["examples", "-o", str(tmp_path)]) == 2
    assert "turtlebot.yaml: exists already" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["turtlebot.yaml"]
    assert (tmp_path / "turtlebot.yaml").read_text() == "mine"
    assert main(["examples", "-o", str(tmp_path), "--force"]) == 0
    assert {path.stem: path.read_bytes() for path in tmp_path.iterdir()} == {
        name: path.read_bytes() for name, path in EXAMPLES.items()
    }


@pytest.mark.parametrize("command", [["info", "--json"], ["info", "--json", "--map", "2"]])
def test_an_example_is_loaded_by_its_name(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    said = []
    for target in ("mixed-course", str(EXAMPLES["mixed-course"])):
        assert main([*command, target]) == 0
        said.append(json.loads(capsys.readouterr().out))
    assert said[0] == said[1]


def test_python_loads_an_example_by_its_name_too() -> None:
    assert rsegen.load("mixed-course") == rsegen.load(EXAMPLES["mixed-course"])
    with pytest.raises(FileError, match=r"did you mean 'mixed-course'\?"):
        rsegen.load("mixed-corse")


def test_a_map_is_made_of_a_name_and_flags(tmp_path: Path) -> None:
    assert main(["generate", "peak", "--seed", "9", "-o", str(tmp_path)]) == 0
    assert rsegen.load(tmp_path / "peak_0000" / "recipe.json").seed == 9


def test_a_file_on_disk_goes_before_an_example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert or_example("peak") == EXAMPLES["peak"]
    Path("peak").write_text("mine")
    assert or_example("peak") == Path("peak")


def test_a_name_of_neither_file_nor_example_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["generate", "paek", "-o", str(tmp_path)]) == 2
    assert capsys.readouterr().err == "rsegen: paek: neither a file nor the name of an example; did you mean 'peak'?\n"
