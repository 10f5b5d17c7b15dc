"""Pictures, looked at by another library."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from rsegen import Placement, Random, Recipe, compose
from rsegen.exporters.pictures.preview import DRAWN, FORMATS, preview_image
from rsegen.recipe.codec import decode

RECIPE = Recipe(seed=1, obstacles=(Placement(obstacle=Random(max_height=5)),))


def image(recipe: Recipe) -> Image.Image:
    return Image.open(io.BytesIO(preview_image(compose(recipe))))


def share(found: Image.Image, colour: tuple[float, float, float]) -> float:
    """How much of a picture has a colour, about."""
    pixels = np.asarray(found.convert("RGB")).astype(float) / 255
    return float((np.abs(pixels - colour).max(axis=2) < 0.02).mean())


def test_a_picture_shows_every_level_and_the_frames() -> None:
    found, scene = image(RECIPE), compose(RECIPE)
    for material in range(5):
        assert share(found, scene.colour(material)) > 0.01


def test_a_map_without_frames_is_drawn_without_frames() -> None:
    bare = replace(RECIPE, boundary="none")
    assert share(image(bare), compose(bare).colour(0)) == 0


def test_a_picture_carries_its_recipe() -> None:
    assert decode(json.loads(image(RECIPE).info["Description"])) == RECIPE


@pytest.mark.parametrize("format_", FORMATS)
def test_same_map_same_bytes_in_every_format(format_: str) -> None:
    assert preview_image(compose(RECIPE), format_) == preview_image(compose(RECIPE), format_)


@pytest.mark.parametrize(
    "recipe", [Recipe(seed=1, boundary="none"), replace(RECIPE, chunk_size=1)], ids=["flat", "one"]
)
def test_the_smallest_maps_can_be_drawn(recipe: Recipe) -> None:
    assert image(recipe).size == (1400, 660)


def test_a_large_map_is_drawn_coarser_but_whole() -> None:
    large = replace(RECIPE, chunk_size=DRAWN + 50, boundary="none")
    assert share(image(large), compose(large).colour(4)) > 0.01
