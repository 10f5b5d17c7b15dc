"""The page on the paper names all that is rsegen's own, and the paper's words."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs import records
from rsegen import KINDS, Recipe
from rsegen.gazebo import MESH_TYPES
from rsegen.obstacles.base import PLACING
from rsegen.params.capabilities import commands
from rsegen.params.sorts import parameters

PAGE = (Path(records.__file__).parent / "paper.md").read_text("utf-8")
WORDS, REST = PAGE.split("## Where rsegen differs")
OWN = REST.split("## What is not in the paper")[1]

OF_THE_PAPER = {"horizontal_barrier", "diagonal_barrier", "peak", "random", "normal_random"}
PARAMETERS_OF_THE_PAPER = {"chunk_size", "unit_cm", "mesh_type", "boundary", "maps", "chunks"}
"""With values that it does not have, which the page names."""


def words(text: str) -> set[str]:
    """All that stands in backticks, or first in them."""
    return {word for part in re.findall(r"`([^`]+)`", text) for word in (part, part.split(":")[0])}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_obstacle_is_the_paper_s_or_not(kind: str) -> None:
    assert (kind in words(OWN)) == (kind not in OF_THE_PAPER)
    assert kind in words(WORDS) or kind not in OF_THE_PAPER


@pytest.mark.parametrize("name", sorted(parameters(Recipe)))
def test_every_parameter_of_maps_is_the_paper_s_or_not(name: str) -> None:
    assert name in words(WORDS if name in PARAMETERS_OF_THE_PAPER else OWN)


def test_every_parameter_that_places_an_obstacle_is_the_paper_s_or_not() -> None:
    for name in PLACING:
        assert name in words(WORDS if name in ("first", "last") else OWN), name


def test_values_that_the_paper_does_not_have_are_named() -> None:
    others = set(MESH_TYPES) - {"single", "multi"}
    assert {f"mesh_type: {name}" for name in others} | {"boundary: outer"} <= words(OWN)
    assert others == {"pallet"}


def test_every_command_but_generate_is_named() -> None:
    named = {word.removeprefix("rsegen ") for word in words(OWN) if word.startswith("rsegen ")}
    assert set(commands()) - named == {"generate"}
    assert "rsegen generate" in words(WORDS)


@pytest.mark.parametrize("what", ["poses", "drives", "ROS 2", "ground_level", "MuJoCo", "learning"])
def test_large_parts_are_named(what: str) -> None:
    assert what in OWN


@pytest.mark.parametrize("word", ["Random Gaussian", "Start", "Help", "progress bar", "max height", "softness"])
def test_the_paper_s_words_are_in_the_table(word: str) -> None:
    assert re.search(rf"^\| [^|]*{word}[^|]* \| [^|]*[`*\w]", WORDS, re.M)
