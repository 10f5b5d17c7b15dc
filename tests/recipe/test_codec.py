"""Recipes as files."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given

import rsegen
from rsegen import Recipe
from rsegen.io.recipe_file import to_yaml
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode, encode, schema, to_json
from tests.support.strategies import recipes


@given(recipes())
def test_json_round_trip(recipe: Recipe) -> None:
    assert decode(json.loads(to_json(recipe))) == recipe


@pytest.mark.parametrize("suffix", [".yaml", ".yml", ".json", ""])
@given(recipe=recipes())
def test_file_round_trip(tmp_path_factory: pytest.TempPathFactory, suffix: str, recipe: Recipe) -> None:
    path = tmp_path_factory.mktemp("recipe") / f"recipe{suffix}"
    rsegen.save(recipe, path)
    assert rsegen.load(path) == recipe


@given(recipes())
def test_schema_accepts_every_recipe(recipe: Recipe) -> None:
    jsonschema.validate(json.loads(to_json(recipe)), schema())


def test_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


def test_a_file_says_everything(tmp_path: Path) -> None:
    content = encode(Recipe(seed=3, difficulty=0.5))
    open_ = {field.name for field in fields(Recipe) if field.default is None}
    assert set(content) == {"version", "generator", "obstacles", *parameters(Recipe)} - open_
    material = {"frame_friction", "level_friction", "frame_colour", "level_colours"}
    assert open_ == material | {"max_step", "crossable_by", "inventory"}
    assert content["seed"] == 3
    assert content["generator"] == f"rsegen {rsegen.__version__}"


def test_a_file_says_nothing_of_a_difficulty_that_changes_nothing() -> None:
    content = encode(Recipe(seed=3))
    assert "difficulty" not in content
    assert decode(content).difficulty == 1


def test_yaml_and_json_mean_the_same(tmp_path: Path) -> None:
    recipe = Recipe(seed=3, obstacles=(rsegen.Placement(obstacle=rsegen.Peak(max_height=5), first=("random", 3)),))
    (tmp_path / "a.yaml").write_text(to_yaml(recipe))
    (tmp_path / "a.json").write_text(to_json(recipe))
    assert rsegen.load(tmp_path / "a.yaml") == rsegen.load(tmp_path / "a.json") == recipe


def test_a_recipe_without_a_seed_gets_one_that_its_file_keeps() -> None:
    drawn = decode({})
    assert drawn.seed != decode({}).seed
    assert decode(encode(drawn)).seed == drawn.seed


def test_comments_and_a_schema_line_are_no_trouble(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("# for the small robot\n$schema: recipe.schema.json\nseed: 3 # drawn by dice\nobstacles: []\n")
    assert rsegen.load(path) == Recipe(seed=3)


def test_a_recipe_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    rsegen.save(Recipe(seed=3), path)
    with pytest.raises(rsegen.UserError, match="is there already"):
        rsegen.save(Recipe(seed=4), path)
    assert rsegen.load(path).seed == 3
    rsegen.save(Recipe(seed=4), path, force=True)
    assert rsegen.load(path).seed == 4
