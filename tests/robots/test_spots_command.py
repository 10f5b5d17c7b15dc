"""rsegen spots: a table, a list for programs, a picture, and mistakes in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image

import rsegen
from rsegen.cli.edge import main


def test_the_table_has_a_row_for_each_spot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spots", "turtlebot", "--robot", "burger", "--count", "3", "--seed", "7"]) == 0
    first, head, *rows = capsys.readouterr().out.splitlines()
    assert first == "turtlebot_0000, seed 7:"
    assert head.split() == ["spot", "x", "[m]", "y", "[m]", "z", "[m]", "yaw", "[deg]", "tilt", "[deg]"]
    found = rsegen.spots("turtlebot", count=3, seed=7)
    assert [list(map(float, row.split()))[1:4] for row in rows] == [
        pytest.approx([spot.x, spot.y, spot.z], abs=1e-3) for spot in found
    ]


def test_spots_are_on_the_map_that_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "two.yaml"
    file.write_text("{maps: 2, seed: 3, unit_cm: 1, obstacles: [{kind: random, levels: 2}]}")
    assert main(["spots", str(file), "--map", "1", "--seed", "7", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (spot,) = rsegen.spots(file, map=1, seed=7)
    assert (found["map"], found["spots"][0]["x"], found["spots"][0]["z"]) == ("rse_0001", spot.x, spot.z)


def test_programs_get_a_list_and_people_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "spots.png"
    words = ["spots", "turtlebot", "--size", "0.3,0.2", "--max-tilt", "1", "--seed", "7"]
    assert main([*words, "--json", "-o", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["map"], found["seed"]) == ("turtlebot_0000", 7)
    (spot,) = found["spots"]
    assert spot["tilt"] <= 0.018
    assert spot["reason"] == ""
    with Image.open(picture) as image:
        assert image.size[0] == 900


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["peak", "--robot", "crawler"],
            "--robot: no spot on this map: at the best place it ",
        ),
        (["turtlebot", "--count", "0"], "--count: 0 is outside 1..1000"),
        (["turtlebot", "--count", "999"], "--count: found spots for"),
        (["turtlebot", "--size", "1"], "--size: [1.0] is not 2 values"),
        (["turtlebot", "--size", "9,9"], "--robot: too large for 22 x 22 cells; use a smaller robot or a larger map"),
        (["turtlebot", "--max-tilt", "-1"], "--max-tilt: -1.0 is outside"),
        (["turtlebot", "--robot", "burgr"], "--robot: unknown robot 'burgr'"),
        (["turtlebot", "-o", "spots.txt"], "spots.txt: a picture's name must end in"),
        ([], "RECIPE: no input"),
    ],
)
def test_a_mistake_is_one_line_and_nothing_is_written(
    words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["spots", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert list(tmp_path.iterdir()) == []


def test_the_size_of_a_robot_may_be_a_list() -> None:
    recipe = rsegen.Recipe(seed=1)
    assert rsegen.spots(recipe, size=[0.3, 0.2], seed=1) == rsegen.spots(recipe, size=(0.3, 0.2), seed=1)
