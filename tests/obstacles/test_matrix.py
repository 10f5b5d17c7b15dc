"""Given levels lie where they are given, north up, and in any size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Matrix, Obstacle, Random, Recipe, build
from rsegen.errors import ParameterError
from rsegen.page.model.texts import command_line
from rsegen.recipe.codec import decode, decode_obstacle, encode

ROWS = ("0 1 2", "3 . 4")
"""3 x 2 cells; the upper row is the larger y."""


def built(*obstacles: Obstacle, chunk_size: int = 6) -> np.ndarray:
    return build(Recipe(chunk_size=chunk_size, boundary="none", seed=1, obstacles=obstacles)).levels


def test_the_top_row_is_the_largest_y() -> None:
    levels = built(Matrix(levels=5, rows=ROWS))
    assert levels[:3, 1].tolist() == [0, 1, 2]
    assert levels[:3, 0].tolist() == [3, 0, 4]
    assert levels.sum() == 10


def test_a_dot_keeps_the_level_below_and_a_zero_replaces_it() -> None:
    ground = Random(levels=3, weights=(0, 0, 1))
    levels = built(ground, Matrix(levels=5, rows=ROWS, first=(1, 2)))
    assert levels[1:4, 2:4].tolist() == [[3, 0], [2, 1], [4, 2]]
    assert (np.delete(levels.ravel(), [8, 9, 14, 15, 20, 21]) == 2).all()


def test_a_matrix_is_stretched_over_its_rectangle_and_mirrored_from_last_to_first() -> None:
    matrix = Matrix(levels=5, rows=("1 2",))
    assert built(replace(matrix, first=(0, 0), last=(5, 0)))[:, 0].tolist() == [1, 1, 1, 2, 2, 2]
    assert built(replace(matrix, first=(5, 0), last=(0, 0)))[:, 0].tolist() == [2, 2, 2, 1, 1, 1]
    assert built(replace(matrix, first=(2, 1), last=(2, 3)))[2].tolist() == [0, 2, 2, 2, 0, 0]


def test_a_matrix_at_random_ends_keeps_its_size_and_stays_on_the_map() -> None:
    matrix = Matrix(levels=5, rows=("4 4", "4 4"), first=("random", "random"))
    recipe = Recipe(boundary="none", seed=3, obstacles=(matrix,))
    fields = [build(recipe, index).levels for index in range(30)]
    assert {int((levels == 4).sum()) for levels in fields} == {4}
    assert len({levels.tobytes() for levels in fields}) > 15


def test_softness_reduces_the_levels_of_a_matrix_by_its_percentage() -> None:
    levels = built(Matrix(levels=11, softness=50, rows=("10 5 1 0",)))
    assert levels[:4, 0].tolist() == [5, 2, 0, 0]


@given(st.lists(st.lists(st.integers(-1, 40), min_size=3, max_size=3), min_size=1, max_size=6))
def test_levels_round_trip_through_rows_files_and_flags(content: list[list[int]]) -> None:
    levels = np.array(content)
    matrix = Matrix.of(levels)
    assert np.array_equal(matrix.cell_levels(), levels)
    recipe = Recipe(seed=1, obstacles=(matrix,))
    assert decode(encode(recipe)) == recipe
    rows = command_line(recipe, "worlds").split("rows=")[1:]
    spelled = rows[0].split()[0].strip("'") if rows else "1"
    again = decode_obstacle({"kind": "matrix", "levels": matrix.levels, "rows": spelled.split("/")})
    assert again == matrix


def test_rows_may_be_lists_of_numbers_in_which_null_is_a_dot() -> None:
    row = {"kind": "matrix", "levels": 5, "rows": [[0, 1, 2], [3, None, 4]]}
    assert decode_obstacle(row) == Matrix(levels=5, rows=ROWS)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "rows: [] is not a list of rows"),
        ("0 1", "rows: '0 1' is not a list of rows"),
        (["0 1", "2"], "rows[1]: has 1 cells, and rows[0] 2"),
        (["0 -1"], "rows[0]: '0 -1' is not a row of levels and dots"),
        (["0 x"], "rows[0]: '0 x' is not a row of levels and dots"),
        ([[0, 1.5]], "rows[0]: [0, 1.5] is not a row of levels and dots"),
        ([""], "rows[0]: '' is not a row of levels and dots"),
        (["7"], "levels: 5 has the levels 0..4, and rows has a 7"),
    ],
)
def test_malformed_rows_are_refused_with_their_place(rows: object, said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        decode_obstacle({"kind": "matrix", "levels": 5, "rows": rows})
    assert str(refused.value).startswith(said)


def test_a_matrix_that_does_not_fit_is_refused_unless_it_is_stretched() -> None:
    matrix = Matrix(levels=5, rows=("0 1 2 3",))
    with pytest.raises(ParameterError, match=r"obstacles\[0\].rows: 4 cells along x from 7 on do not fit into 0..9"):
        Recipe(obstacles=(replace(matrix, first=(7, 0)),))
    assert Recipe(obstacles=(replace(matrix, first=(7, 0), last=(9, 0)),)).obstacles


def test_a_matrix_has_one_level_more_than_its_highest_and_at_least_two() -> None:
    assert Matrix(rows=("0 4", ". 1")).levels == 5
    assert Matrix(rows=("0 .",)).levels == 2
    assert Matrix(rows=("0 4",)) == Matrix(rows=("0 4",), levels=5) != Matrix(rows=("0 4",), levels=6)


def test_too_few_levels_for_the_rows_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"^levels: 4 has the levels 0..3, and rows has a 4$"):
        Matrix(rows=("0 4",), levels=4)
    with pytest.raises(ParameterError, match=r"^levels: 32767 has the levels 0..32766, and rows has a 40000$"):
        Matrix(rows=("40000",))


def test_a_row_of_a_file_may_leave_out_the_levels_of_a_matrix_and_recipes_write_them() -> None:
    matrix = decode_obstacle({"kind": "matrix", "rows": ["0 4"], "first": [2, 2]})
    assert list(matrix.entry().items()) == [("kind", "matrix"), ("levels", 5), ("rows", ["0 4"]), ("first", [2, 2])]
