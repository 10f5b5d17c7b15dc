"""rsegen terrain: a world of all tiles, and a file that says where each is and how hard."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen import Terrain, load
from rsegen.cli.edge import main
from rsegen.recipe.examples import EXAMPLES

ROUGH = rsegen.Random(levels=20)
SMALL = ("peak", "figure-7", "--rows", "3", "--columns", "4", "--gap", "1", "--border", "2")


def test_it_is_the_terrain_of_the_recipes(tmp_path: Path) -> None:
    main(["terrain", *SMALL, "--spots", "0.3,0.2", "--formats", "arrays", "-o", str(tmp_path)])
    expected = Terrain(recipes=[load(EXAMPLES[name]) for name in SMALL[:2]], rows=3, columns=4, gap=1, border=2)
    assert rsegen.build(load(tmp_path / "terrain_0000" / "recipe.json")) == expected.field
    said = json.loads((tmp_path / "terrain_0000.json").read_text())
    assert said["kinds"] == list(expected.kinds)
    assert said["difficulty"] == [0, 0.5, 1]
    assert np.array_equal(said["origins"], expected.origins)
    assert np.shape(said["spots"]) == (3, 4, 4)
    assert (tmp_path / "terrain_0000" / "arrays").is_dir()


@pytest.mark.slow
def test_rows_rise_by_a_metric_of_a_robot(tmp_path: Path) -> None:
    flags = ("--by", "reach.west_east.cost", "--robot", "7")
    recipe = rsegen.Recipe(name="a", seed=1, unit_cm=2, boundary="none", obstacles=[ROUGH])
    rsegen.save(recipe, tmp_path / "a.yaml")
    made = [str(tmp_path / "a.yaml"), *SMALL[2:], *flags, "-o", str(tmp_path / "out")]
    assert main(["terrain", *made]) == 0
    usual = Terrain(recipes=recipe, rows=3, columns=4, gap=1, border=2)
    expected = replace(usual, by=flags[1], robot=rsegen.StepLimits(climb_cm=7))
    assert rsegen.build(load(tmp_path / "out" / "terrain_0000" / "recipe.json")) == expected.field
    assert expected.field != usual.field


def test_progress_counts_tiles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for flags in ((), ("--spots", "0.3,0.2")):
        assert main(["terrain", *SMALL, *flags, "--force", "--progress", "json", "-o", str(tmp_path)]) == 0
        said = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
        tile = [each for each in said if each["unit"] == "tile"]
        assert [tile[0]["done"], tile[-1]["done"], tile[-1]["total"]] == [0, 12, 12]


def test_a_seed_is_that_of_all_recipes(tmp_path: Path) -> None:
    for seed in ("1", "2", "3"):
        main(["terrain", *SMALL, "--seed", seed, "--name", f"of-{seed}", "-o", str(tmp_path)])
    fields = [rsegen.build(load(tmp_path / f"of-{seed}_0000" / "recipe.json")) for seed in "123"]
    assert fields[0] != fields[1] != fields[2]


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (("--by", "reach.coverage"), "by: reach.coverage needs a robot; set robot too"),
        (("--rows", "0"), "--rows: 0 is outside 1..1000"),
        (("--difficulty", "0.5"), "--difficulty: [0.5] is not 2 values"),
        (("--columns", "1"), "recipes: 2 for 1 columns"),
        (("--spots", "1"), "--spots: "),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value),
)
def test_impossible_values_are_refused_in_a_line(
    flags: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["terrain", *SMALL, *flags, "-o", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_existing_files_are_not_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "terrain_0000.json").write_text("mine")
    assert main(["terrain", *SMALL, "-o", str(tmp_path)]) == 2
    assert "terrain_0000.json" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["terrain_0000.json"]


def test_force_replaces_a_terrain_and_its_tiles_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["terrain", *SMALL, "-o", str(tmp_path)]
    assert main(command) == 0
    assert main([*command, "--gap", "2"]) == 2
    assert "exists already" in capsys.readouterr().err
    (tmp_path / "notes.txt").write_text("mine")
    assert main([*command, "--gap", "2", "--force"]) == 0
    tiles = json.loads((tmp_path / "terrain_0000.json").read_text())
    peak, figure = (load(EXAMPLES[name]) for name in SMALL[:2])
    assert np.array_equal(tiles["origins"], Terrain(recipes=[peak, figure], rows=3, columns=4, gap=2, border=2).origins)
    (tmp_path / "terrain_0000.json").write_text("mine")
    assert main([*command, "--force"]) == 2
    assert (tmp_path / "terrain_0000.json").read_text() == "mine"
    assert (tmp_path / "notes.txt").read_text() == "mine"
