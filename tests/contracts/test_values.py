"""Functions in Python say what they take when they are given another value, such as a field in place of a recipe."""

from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Callable, Iterator
from dataclasses import fields
from inspect import Parameter, signature, unwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.geometry import boxes, surface

RECIPE = rsegen.Recipe(seed=1, obstacles=[rsegen.Random(levels=3)])
VALUES = {
    "Recipe": RECIPE,
    "StepField": rsegen.build(RECIPE),
    "Scene": rsegen.compose(RECIPE),
    "None": None,
    "Path": "there-is-none.yaml",
    "": 3,
}
"""Values by the classes in annotations that take them."""

OTHERS = {
    "x": 0.0,
    "y": 0.0,
    "heading": 0.0,
    "indices": [0],
    "levels": RECIPE.chunks,
    "certainty": 0.9,
    "robot": "burger",
    "map": RECIPE,
    "recipe": RECIPE,
    "stands": RECIPE,
    "wanted": RECIPE,
}
"""Values of the other parameters that a call has to have."""

KNOWN = re.compile(r"\b(Recipe|MapDesign|StepField|Scene|Target)\b|^str \| Path$")
TAKES = {"MapDesign": ("Recipe",), "Target": ("Recipe", "Scene", "Path"), "str": ("Path",)}


def cases() -> Iterator[tuple[str, str]]:
    for name in rsegen.__all__:
        function = getattr(rsegen, name)
        if callable(function) and (name in ("Ground", "Dataset") or not isinstance(function, type)):
            for parameter in signature(unwrap(function)).parameters.values():
                if parameter.default is Parameter.empty and KNOWN.search(str(parameter.annotation)):
                    yield name, parameter.name


@pytest.mark.parametrize(("name", "parameter"), list(cases()))
def test_another_value_is_refused_in_one_line(
    name: str, parameter: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function: Any = getattr(rsegen, name)
    arguments = signature(unwrap(function)).parameters
    annotation = str(arguments[parameter].annotation)
    words = re.findall(r"\w+", annotation)
    taken = {kind for word in words for kind in TAKES.get(word, (word,))}
    required = [each for each in arguments.values() if each.default is Parameter.empty and each.kind < 4]
    call = {each.name: OTHERS.get(each.name, "out") for each in required if each.kind != Parameter.VAR_POSITIONAL}
    if name == "export_maps":
        call["formats"] = [rsegen.FORMATS["stl"]()]
    for kind, value in VALUES.items():
        if kind in taken:
            continue
        with pytest.raises(rsegen.UserError) as refusal:
            function(**{**call, parameter: value})
        assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


def arrays_of(value: Any) -> list[np.ndarray[Any, Any]]:
    parts = [getattr(value, field.name) for field in fields(value)]
    return [part for each in parts for part in (each if isinstance(each, tuple) else (each,)) if hasattr(part, "flags")]


def pickled(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))  # noqa: S301  # our own


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickled])
def test_arrays_are_read_only_in_copies_and_pickles(copied: Callable[[Any], Any]) -> None:
    scene = rsegen.compose(RECIPE)
    for value in (scene.field, copied(scene).field, surface(scene.field), boxes(scene.field)):
        arrays, again = arrays_of(value), arrays_of(copied(value))
        assert arrays
        assert not any(array.flags.writeable for array in [*arrays, *again])
        assert all(np.array_equal(array, same) for array, same in zip(arrays, again, strict=True))


def test_lists_are_taken_where_tuples_are() -> None:
    """Also by type checkers: mypy checks this file."""
    place = rsegen.Peak(levels=5, first=[2, 3], last=["random", 5])
    assert place == rsegen.Peak(levels=5, first=(2, 3), last=("random", 5))
    rows = rsegen.Matrix(levels=3, rows=["0 1 2", "2 1 0"])
    weights, counts = rsegen.Random(levels=3, weights=[1, 2, 1]), rsegen.Random(levels=3, counts=[300, 200, 100])
    pallet, platform = rsegen.Pallet(levels=5, turns=[0, 1]), rsegen.Platform(levels=3, size=[2, 3])
    recipe = rsegen.Recipe(
        chunks=[2, 3],
        obstacles=[place, rows, weights, counts, pallet, platform],
        difficulty=[0.2, 1],
        crossable_by=[10, 10, 30],
        inventory=[900] * 4,
        level_friction=[0.5, 0.6],
        level_colours=["#ff0000"],
    )
    canonical: list[object] = [
        recipe.chunks,
        recipe.difficulty,
        recipe.crossable_by,
        recipe.inventory,
        recipe.level_friction,
    ]
    canonical += [recipe.level_colours, rows.rows, weights.weights, counts.counts, pallet.turns, platform.size]
    assert all(isinstance(value, tuple) for value in canonical)
