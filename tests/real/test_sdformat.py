"""libsdformat, which new Gazebos read worlds with, finds nothing to say against any file."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

import rsegen
from tests.real.maps import (
    every_kind,
    example_of_each_shape,
    few,
    few_short,
    generated,
    map_name,
    textured,
    variants,
)

HARMLESS = "Library error: libignition-tools-backward.so not found"
"""Debian's ignition-tools says so of itself, whatever it is asked."""


def other_text(recipes: Iterable[rsegen.Recipe]) -> list[rsegen.Recipe]:
    """Return the recipes whose files differ in more than the meshes that they name."""
    return [recipe for recipe in recipes if recipe.mesh == "merged" and not recipe.tile]


@pytest.mark.parametrize(
    "recipe",
    few_short([*other_text(example_of_each_shape()), *few([*variants(), *textured()]), every_kind()]),
    ids=map_name,
)
def test_every_world_and_model_is_valid(
    recipe: rsegen.Recipe, check_sdf: Callable[[Path], str], tmp_path: Path
) -> None:
    made = generated(recipe, tmp_path)
    files = [made.world, *made.folder.glob("model.sdf")]

    assert len(files) == (2 if recipe.mesh_type == "single" else 1)
    assert {file.name: said(check_sdf(file)) for file in files} == {file.name: ["Valid."] for file in files}


def test_a_name_given_twice_is_not_valid(check_sdf: Callable[[Path], str], tmp_path: Path) -> None:
    model = '<model name="one"><link name="link"/></model>'
    twice = tmp_path / "twice.sdf"
    twice.write_text(f'<sdf version="1.6"><world name="world">{model}{model}</world></sdf>')

    assert "Valid." not in said(check_sdf(twice))


def said(command_output: str) -> list[str]:
    return [line for line in command_output.splitlines() if line and not line.startswith(HARMLESS)]
