"""Recipes as files."""

from __future__ import annotations

import json
import time
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings

import rsegen
from rsegen import Random, Recipe, build
from rsegen.cli.edge import main
from rsegen.errors import ParameterError
from rsegen.recipe.codec import decode, encode, schema, to_json
from rsegen.recipe.map_design import MapDesign
from rsegen.recipe.recipe_file import to_yaml
from tests.support.strategies import recipes


@given(recipes())
def test_recipes_round_trip_through_json(recipe: Recipe) -> None:
    assert decode(json.loads(to_json(recipe))) == recipe


@pytest.mark.parametrize("suffix", [".yaml", ".yml", ".json", ""])
@given(recipe=recipes())
def test_recipes_round_trip_through_files(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, recipe: Recipe
) -> None:
    path = tmp_path_factory.mktemp("recipe") / f"recipe{suffix}"
    rsegen.save(recipe, path)
    assert rsegen.load(path) == recipe


def test_a_file_for_people_has_the_keys_that_were_given_alone(tmp_path: Path) -> None:
    """A derived key would keep the draw of a row whose parameters somebody changes in the file."""
    path = tmp_path / "recipe.yaml"
    rsegen.save(Recipe(seed=1, obstacles=[Random(levels=3), Random(levels=4, key="mine")]), path)
    text = path.read_text("utf-8")
    assert [line for line in text.splitlines() if "key" in line] == ["- {kind: random, levels: 4, key: mine}"]
    path.write_text(text.replace("levels: 3", "levels: 5"), "utf-8")
    assert rsegen.load(path) == Recipe(seed=1, obstacles=[Random(levels=5), Random(levels=4, key="mine")])


@pytest.mark.slow
@given(recipes())
@settings(max_examples=10)
def test_schema_accepts_every_recipe(recipe: Recipe) -> None:
    jsonschema.validate(json.loads(to_json(recipe)), schema())


@pytest.mark.parametrize("difficulty", [[0.5], [0, 0.5, 1], [0.5, 1.5], -0.1, "hard"])
def test_the_schema_refuses_a_difficulty_that_is_refused(difficulty: object) -> None:
    content = {"difficulty": difficulty, "obstacles": []}
    with pytest.raises(ParameterError, match="difficulty"):
        decode(content)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, schema())
    jsonschema.validate(content | {"difficulty": [0.2, 0.5]}, schema())


def test_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


def test_yaml_and_json_mean_the_same(tmp_path: Path) -> None:
    recipe = Recipe(seed=3, obstacles=(rsegen.Peak(levels=5, first=("random", 3)),))
    (tmp_path / "a.yaml").write_text(to_yaml(recipe))
    (tmp_path / "a.json").write_text(to_json(recipe))
    assert rsegen.load(tmp_path / "a.yaml") == rsegen.load(tmp_path / "a.json") == recipe


@pytest.mark.parametrize("number", ["1e3", "1.0e+3", "1E+3", "+1.e3", "10000.0e-1"])
def test_a_number_with_an_exponent_is_one_in_files_and_flags(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], number: str
) -> None:
    (tmp_path / "a.yaml").write_text(f"unit_cm: {number}\nmaps: {number}\nseed: 1\n")
    recipe = rsegen.load(tmp_path / "a.yaml")
    assert recipe == Recipe(seed=1, unit_cm=1000, maps=1000)
    (tmp_path / "empty.yaml").write_text("seed: 1\n")
    assert main(["info", str(tmp_path / "empty.yaml"), f"--unit-cm={number}", "--json"]) == 0
    assert '"unit_cm": 1000' in capsys.readouterr().out


def test_texts_that_look_like_numbers_are_quoted_in_yaml(tmp_path: Path) -> None:
    recipe = Recipe(seed=3, name="1e3", obstacles=[rsegen.Peak(levels=5, key="1.5E3")])
    text = to_yaml(recipe)
    assert "name: '1e3'" in text
    (tmp_path / "a.yaml").write_text(text)
    assert rsegen.load(tmp_path / "a.yaml") == recipe


def test_a_recipe_without_a_seed_gets_one_that_its_file_keeps() -> None:
    drawn = decode({})
    assert drawn.seed != decode({}).seed
    assert decode(encode(drawn)).seed == drawn.seed


def test_comments_and_a_schema_line_are_read_over(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("# for the small robot\n$schema: recipe.schema.json\nseed: 3 # drawn by dice\nobstacles: []\n")
    assert rsegen.load(path) == Recipe(seed=3)


def test_a_recipe_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    rsegen.save(Recipe(seed=3), path)
    with pytest.raises(rsegen.UserError, match="exists already"):
        rsegen.save(Recipe(seed=4), path)
    assert rsegen.load(path).seed == 3
    rsegen.save(Recipe(seed=4), path, force=True)
    assert rsegen.load(path).seed == 4


def test_derived_keys_equal_keys_of_recipes_with_max_height() -> None:
    recipe = decode({"seed": 1, "obstacles": [{"kind": "peak", "levels": 5}, {"kind": "matrix", "rows": ["0 1"]}]})
    assert [obstacle.key for obstacle in recipe.obstacles] == ["peak-469fe3ad", "matrix-b2ab4d71"]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"levels": 1}, r"obstacles\[0\].levels: 1 is outside 2..32767"),
        ({"max_height": 5}, r"obstacles\[0\]: unknown parameter of peak 'max_height'.*known: .*levels"),
        ({}, r"obstacles\[0\].levels: missing; expected 2..32767"),
    ],
)
def test_wrong_missing_and_misnamed_levels_are_refused(row: dict[str, int], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        decode({"obstacles": [{"kind": "peak", **row}]})


def test_a_file_has_only_the_seed_and_what_differs_from_the_defaults() -> None:
    content = encode(Recipe(seed=7))
    assert content == {"version": 2, "generator": f"rsegen {rsegen.__version__}", "seed": 7, "obstacles": []}
    assert encode(Recipe(seed=7, unit_cm=10, chunks=(2, 2))) == content | {"chunks": [2, 2]}


def test_the_map_design_of_a_recipe_decides_its_levels_alone() -> None:
    recipe = Recipe(seed=7, maps=3, mesh_type="multi", unit_cm=5, obstacles=[Random(levels=5)])
    design = MapDesign(**{field.name: getattr(recipe, field.name) for field in fields(MapDesign)})
    assert build(design, 2) == build(recipe, 2)


def test_an_alias_stands_for_its_anchor(tmp_path: Path) -> None:
    short, long = tmp_path / "short.yaml", tmp_path / "long.yaml"
    short.write_text("seed: 3\nobstacles:\n- &hill {kind: peak, levels: 5, first: &a [2, 2], last: *a}\n- *hill\n")
    long.write_text("seed: 3\nobstacles:\n" + "- {kind: peak, levels: 5, first: [2, 2], last: [2, 2]}\n" * 2)
    assert rsegen.load(short) == rsegen.load(long)


@pytest.mark.slow
def test_many_plug_ins_are_looked_up_among_many_obstacles_in_a_moment() -> None:
    start = time.process_time()
    plugins = {f"k{number}": "x 1" for number in range(20_000)}
    decode({"plugins": plugins, "obstacles": [{"kind": "peak", "levels": 5}] * 20_000})
    assert time.process_time() - start < 8
