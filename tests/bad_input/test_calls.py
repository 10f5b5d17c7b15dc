"""The Python API says the same."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen import Recipe
from rsegen.errors import FileError, ParameterError, UserError
from tests.support.complaints import (
    MORE_DIGITS_THAN_PYTHON_WRITES,
)

CALLS: Mapping[str, tuple[Callable[[], object], str]] = {
    "a number that cannot be written": (
        lambda: Recipe(seed=MORE_DIGITS_THAN_PYTHON_WRITES),
        "seed: a number of thousands of digits is outside 0..",
    ),
    "a pair of such": (
        lambda: Recipe(chunks=(1, MORE_DIGITS_THAN_PYTHON_WRITES)),
        r"chunks: \(1, a number of thousands of digits\) is not",
    ),
    "an array": (lambda: Recipe(seed=np.zeros((3, 3))), "seed: .* is not a whole number"),  # type: ignore[arg-type]
    "nothing": (lambda: Recipe(maps=None), "maps: an empty value is not a whole number"),  # type: ignore[arg-type]
    "a truth": (lambda: Recipe(maps=True), "maps: True is not a whole number"),
    "obstacles in a word": (lambda: Recipe(obstacles="peak"), "obstacles: 'peak' is not a list"),  # type: ignore[arg-type]
    "a kind for an obstacle": (
        lambda: Recipe(obstacles=["peak"]),  # type: ignore[list-item]
        r"obstacles\[0\]: 'peak' is not an obstacle, such as rsegen.Peak",
    ),
    "a barrier askew": (
        lambda: rsegen.HorizontalBarrier(levels=5, first=(1, 2), last=(3, 4)),
        "share neither x nor y",
    ),
    "a height of ground only": (lambda: rsegen.Peak(levels=1), "levels: 1 is outside 2..32767"),
    "an index below 0": (lambda: rsegen.build(Recipe(), -1), "index: -1 is outside 0.."),
}


@pytest.mark.parametrize(("call", "words"), CALLS.values(), ids=CALLS)
def test_a_call(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ParameterError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["no.yaml", ".", "a\0b"], ids=ascii)
def test_a_file_that_cannot_be_loaded(name: str) -> None:
    with pytest.raises(FileError) as caught:
        rsegen.load(name)
    assert "\n" not in str(caught.value)


def test_a_call_that_is_refused_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(UserError):
        rsegen.generate(Recipe(chunks=(10**6, 10**6)), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
