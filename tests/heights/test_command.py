"""rsegen import, as a person types it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rsegen import build, load
from rsegen.cli.edge import main


def test_heights_become_a_world_with_the_flags_of_a_recipe(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "my pallet.csv").write_text("0,10\n20,30\n", "utf-8")
    words = ["import", str(tmp_path / "my pallet.csv"), "-o", str(tmp_path / "worlds"), "--boundary", "outer"]
    assert main(words) == 0
    assert "1 map of 2 x 2 blocks (4 x 4 cells with frames)" in capsys.readouterr().out
    folder = tmp_path / "worlds" / "my_pallet_0000"
    assert (folder / "my_pallet_0000.world").is_file()
    assert build(load(folder / "recipe.json")).blocks.tolist() == [[2, 0], [3, 1]]


def test_heights_in_whole_units_add_no_line_to_the_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.csv").write_text("0,10\n20,30\n", "utf-8")
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "worlds")]) == 0
    assert "" not in capsys.readouterr().out.splitlines()


def test_an_image_is_read_with_its_options(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 255]], dtype=np.uint8)).save(tmp_path / "a.png")
    words = ["import", str(tmp_path / "a.png"), "-o", str(tmp_path), "--levels", "3", "--invert", "--size", "4x2"]
    assert main([*words, "--unit-cm", "5", "--chunk-size", "1"]) == 0
    recipe = load(tmp_path / "a_0000" / "recipe.json")
    assert build(recipe).levels.tolist() == [[2, 2], [2, 2], [0, 0], [0, 0]]
    assert (recipe.unit_cm, recipe.chunk_size, recipe.chunks) == (5, 1, (4, 2))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--invert"], "--invert: is not for this file, which is read as table (known: --rounded, --any-heights, "),
        (["--values", "miles"], "--values: 'miles' is not one of auto, cm, mm, m, in, ft, levels"),
        (["--unit-cm", "0"], "--unit-cm: 0.0 is outside 0.001..100000 cm"),
        (["--chunk-size", "3"], "--chunk-size: 3 does not divide 2 x 2 cells; 2 does"),
        (["--chunks", "1", "--chunk-size", "1"], "obstacles[0].rows: 2 cells along x from 0 on do not fit into 0..0"),
    ],
)
def test_impossible_values_are_refused_in_one_line_and_nothing_is_written(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.csv").write_text("0,10\n20,30\n", "utf-8")
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "worlds"), *words]) == 2
    assert capsys.readouterr().err.startswith(f"rsegen: {said}")
    assert not (tmp_path / "worlds").exists()


def test_heights_of_a_recipe_in_inches_are_inches(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0,3.5\n7,10.5\n", "utf-8")
    words = ["import", str(tmp_path / "a.csv"), "-o", str(tmp_path), "--units", "in", "--unit-cm", "3.5in"]
    assert main(words) == 0
    recipe = load(tmp_path / "a_0000" / "recipe.json")
    assert (recipe.unit_cm, build(recipe).blocks.tolist()) == (8.89, [[2, 0], [3, 1]])
