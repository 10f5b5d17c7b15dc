"""Places at which chance put each obstacle of a map, in info and in the recipe.json of the map."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given

import rsegen
from rsegen.cli.edge import main
from rsegen.recipe.building import owners, placed_obstacles
from rsegen.recipe.codec import decode, map_json, schema
from tests.support.strategies import recipes

COURSE = rsegen.Recipe(
    seed=11,
    maps=4,
    chunk_size=8,
    chunks=(2, 1),
    obstacles=[
        rsegen.Random(levels=3),
        rsegen.Peak(levels=5, softness=60),
        rsegen.DiagonalBarrier(levels=4, first=(0, "random"), last=(15, 3)),
        rsegen.Peak(levels=4, first=(1, 1), last=(3, 3)),
        rsegen.HorizontalBarrier(levels=3, enabled=False),
        rsegen.Pallet(levels=4, first=("random", "random"), last=("random", "random")),
    ],
)


def fixed_at(recipe: rsegen.Recipe, placed: list[dict[str, Any]]) -> rsegen.Recipe:
    """Return a recipe with the obstacles at the places that were said, under the keys that they have."""
    rows = list(recipe.obstacles)
    for place in placed:
        row = place["row"]
        rows[row] = replace(rows[row], first=place["first"], last=place["last"])
    return replace(recipe, obstacles=rows)


@pytest.mark.parametrize("index", [0, 1, 3])
def test_obstacles_fixed_at_the_places_of_recipe_json_make_the_same_map(index: int) -> None:
    shaped = replace(COURSE, obstacles=[row for row in COURSE.obstacles if row.kind not in ("pallet", "random")])
    placed = json.loads(map_json(shaped, index))["placed"]
    assert [place["kind"] for place in placed] == ["peak", "diagonal_barrier"]
    fixed = fixed_at(shaped, placed)
    assert "random" not in [at for row in fixed.obstacles[:2] for end in (row.first, row.last) for at in end or ()]
    assert (rsegen.build(fixed, index).levels == rsegen.build(shaped, index).levels).all()
    assert (rsegen.build(fixed, index + 1).levels != rsegen.build(shaped, index + 1).levels).any()


def test_a_patch_is_the_rectangle_of_the_blocks_that_an_obstacle_covers_alone() -> None:
    for row, kind in ((1, "peak"), (2, "diagonal_barrier")):
        alone = replace(COURSE, boundary="none", obstacles=[COURSE.obstacles[row]])
        (place,) = placed_obstacles(alone, 2)
        x, y = np.nonzero(owners(alone, 2) == 0)
        corners = {"from": [x.min(), y.min()], "to": [x.max(), y.max()]}
        assert (place["kind"], place["patch"]) == (kind, {**corners, "blocks": len(x)})


def test_a_recipe_of_fixed_places_has_no_such_record() -> None:
    fixed = replace(COURSE, obstacles=[COURSE.obstacles[0], COURSE.obstacles[3]])
    assert b"placed" not in map_json(fixed, 1)
    assert [place["kind"] for place in placed_obstacles(fixed, 1)] == ["random", "peak"]


@given(recipes())
def test_a_recipe_json_with_places_is_read_as_the_recipe_of_its_map(recipe: rsegen.Recipe) -> None:
    assert decode(json.loads(map_json(recipe, recipe.first_map))) == recipe.alone(recipe.first_map)


def test_the_schema_knows_the_places() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    content = json.loads(map_json(COURSE, 1))
    assert len(content["placed"]) == 3
    jsonschema.validate(content, schema())
    with pytest.raises(rsegen.UserError, match="placed: 5 is not a list of obstacles"):
        decode(content | {"placed": 5})


def test_info_says_where_chance_put_obstacles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rsegen.save(COURSE, tmp_path / "course.yaml")
    assert main(["info", str(tmp_path / "course.yaml"), "--map", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["placed"]
    assert told == list(placed_obstacles(COURSE, 2))
    assert [place["row"] for place in told] == [0, 1, 2, 3, 5]
    assert main(["info", str(tmp_path / "course.yaml"), "--map", "2"]) == 0
    said = [line.strip() for line in capsys.readouterr().out.splitlines() if line.strip().startswith("drawn: ")]
    assert len(said) == 3
    first, last, patch = (told[1][name] for name in ("first", "last", "patch"))
    (x1, y1), (x2, y2) = patch["from"], patch["to"]
    assert said[0] == (
        f"drawn: first={first[0]},{first[1]} last={last[0]},{last[1]}; "
        f"covers {patch['blocks']} blocks within {x1},{y1}..{x2},{y2}"
    )


def test_the_recipe_json_of_each_map_has_its_own_places(tmp_path: Path) -> None:
    rsegen.generate(COURSE, tmp_path)
    placed = [
        json.loads((tmp_path / COURSE.map_name(index) / "recipe.json").read_text())["placed"]
        for index in COURSE.indices
    ]
    assert len({json.dumps(rows) for rows in placed}) == COURSE.maps
    assert placed[3] == json.loads(map_json(COURSE, 3))["placed"]
