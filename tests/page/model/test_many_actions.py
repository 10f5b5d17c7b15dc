"""Very many actions in one edit: as if each was an edit of its own, in a time that grows with their number alone."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.errors import ParameterError
from rsegen.page.model.actions import Action, act
from rsegen.page.model.session import Session
from rsegen.recipe.recipe import Recipe
from tests.support.long import long_unless

MANY, SECONDS = 2000, 5.0
PEAK = {"kind": "peak", "levels": 3, "first": [0, 0], "last": [2, 2]}
RANDOM = {"kind": "random", "levels": 4}
ADD: Action = {"do": "add", "entry": PEAK}


@pytest.mark.parametrize(
    "actions",
    [
        [ADD] * MANY,
        [ADD, *[{"do": "duplicate", "row": 0}] * (MANY - 1)],
        [{"do": "add", "entry": PEAK, "at": 0}] * MANY,
        [{"do": "add", "entry": {**PEAK, "levels": 0}}] * MANY,
    ],
    ids=["at the end", "copies", "at the beginning", "not valid"],
)
def test_two_thousand_obstacles_are_added_within_seconds(actions: Sequence[Action]) -> None:
    session, began = Session.of(), time.process_time()
    act(session, actions, 0)
    assert len(session.draft.rows) == MANY
    assert time.process_time() - began < SECONDS


WRONG: Action = {"do": "add", "entry": {**PEAK, "levels": 0}}


@pytest.mark.parametrize(
    "before",
    long_unless(bool, [[], [WRONG]], reason="a valid list too"),
    ids=["valid", "beside a row that is not valid"],
)
@pytest.mark.parametrize("row", [-1, 0], ids=["each a row of its own", "into one row"])
def test_a_thousand_strokes_are_painted_within_seconds(row: int, before: Sequence[Action]) -> None:
    """Each row is checked once, whatever was painted before it."""
    session, began = Session.of(Recipe(seed=1, chunk_size=40)), time.process_time()
    first: Action = {"do": "paint", "row": -1, "cells": [[0, 0], [39, 39]], "level": 2}
    cells = [[at % 40, at // 40 % 40] for at in range(MANY // 2)]
    act(session, [first, *before, *({"do": "paint", "row": row, "cells": [cell], "level": 3} for cell in cells)], 0)
    assert time.process_time() - began < SECONDS
    assert len(session.draft.rows) == 1 + len(before) + (len(cells) if row < 0 else 0)
    assert bool(session.problem) is bool(before)
    painted = session.draft.rows[0 if row == 0 else -1]["rows"]
    assert "3" in " ".join(painted)


def test_a_stroke_sees_the_size_that_the_same_edit_gave_the_map() -> None:
    larger: Sequence[Action] = [{"do": "set", "name": "chunks", "value": [2, 1]}, ADD]
    stroke: Action = {"do": "paint", "row": -1, "cells": [[15, 2]], "level": 1}
    session = Session.of(Recipe(seed=1))
    act(session, [*larger, stroke], 0)
    assert session.draft.rows[-1]["first"] == [15, 2]
    with pytest.raises(ParameterError, match="outside the map"):
        act(Session.of(Recipe(seed=1)), [ADD, stroke], 0)
    with pytest.raises(ParameterError, match="outside the map"):  # the map stays as it was
        act(Session.of(Recipe(seed=1)), [{"do": "set", "name": "chunks", "value": [2, 0]}, stroke], 0)


def test_many_changes_of_a_long_list_take_seconds() -> None:
    session = Session.of()
    act(session, [ADD] * 500, 0)
    began = time.process_time()
    act(session, [{"do": "change", "row": row, "entry": {**PEAK, "levels": 4}} for row in range(500)], 0)
    act(session, [{"do": "enable", "row": row, "enabled": False} for row in range(500)], 0)
    act(session, [{"do": "move", "row": 499, "to": 0}] * 500, 0)
    act(session, [{"do": "remove", "row": 0}] * 500, 0)
    assert session.draft.rows == ()
    assert time.process_time() - began < SECONDS


FIXED: Sequence[Action] = [{"do": "fix", "row": row, "index": 3} for row in range(500)]
MOVED: Sequence[Action] = [{"do": "move_end", "row": row, "end": "last", "cell": [4, row % 7]} for row in range(500)]
LARGER: Action = {"do": "set", "name": "chunks", "value": [2, 2]}


@pytest.mark.parametrize(
    "actions",
    [
        FIXED,
        [*reversed(FIXED)],
        MOVED,
        [{**action, "row": 7} for action in MOVED],
        [action for pair in zip(MOVED[::2], FIXED[1::2], strict=True) for action in pair],
        [LARGER, *MOVED],
    ],
    ids=["fixed", "fixed from below", "moved", "one row moved", "both", "on a larger map"],
)
@pytest.mark.parametrize("more", [[], [WRONG]], ids=["valid", "beside a row that is not valid"])
def test_ends_of_a_long_list_are_fixed_and_moved_within_seconds(
    actions: Sequence[Action], more: Sequence[Action]
) -> None:
    """Rows that are alike have keys that are numbered by their place in the list, from which their places follow."""
    session = Session.of(Recipe(seed=1))
    act(session, [*[{"do": "add", "entry": {"kind": "peak", "levels": 3}}] * 500, *more], 0)
    began = time.process_time()
    act(session, actions, 0)
    assert time.process_time() - began < SECONDS
    moved = {action["row"] for action in actions if "row" in action}
    assert all(("last" in row) == (place in moved) for place, row in enumerate(session.draft.rows[:500]))
    assert bool(session.problem) is bool(more)


def test_a_long_history_is_undone_within_seconds() -> None:
    session = Session.of(Recipe(seed=1))
    act(session, [ADD] * 500, 0)
    before = session.draft
    act(session, [{"do": "enable", "row": row, "enabled": False} for row in range(500)], 0)
    after, began = session.draft, time.process_time()
    act(session, [{"do": "undo"}] * 500, 0)
    assert session.draft == before
    act(session, [{"do": "redo"}] * 500, 0)
    assert session.draft == after
    assert time.process_time() - began < SECONDS


ACTIONS: Sequence[Action] = [
    ADD,
    ADD,
    {"do": "add", "entry": RANDOM, "at": 1},
    {"do": "set", "name": "chunks", "value": [2, 1]},
    {"do": "duplicate", "row": 1},
    {"do": "move_end", "row": 0, "end": "last", "cell": [14, 4]},
    {"do": "change", "row": 2, "entry": {**RANDOM, "levels": 6}},
    {"do": "undo"},
    {"do": "enable", "row": 3, "enabled": False},
    {"do": "paint", "row": -1, "cells": [[19, 3]], "level": 2},
    {"do": "paint", "row": 4, "cells": [[18, 3]], "level": 2, "gesture": "a"},
    {"do": "paint", "row": 4, "cells": [[17, 3]], "level": 2, "gesture": "a"},
    {"do": "paint", "row": 4, "cells": [[17, 3]], "level": 2},
    {"do": "paint", "row": 2, "cells": [[0, 0]], "level": 1},
    {"do": "move", "row": 0, "to": 3},
    {"do": "remove", "row": 1},
    {"do": "undo"},
    {"do": "redo"},
]


def test_actions_of_one_edit_make_what_they_make_one_by_one() -> None:
    together, apart = Session.of(Recipe(seed=7)), Session.of(Recipe(seed=7))
    selected = act(together, ACTIONS, 0)
    for action in ACTIONS:
        last = act(apart, [action], 0)
    assert selected == last
    assert together.draft == apart.draft
    assert together.recipe.obstacles == apart.recipe.obstacles
    assert all("key" in row for row in together.draft.rows)
    while apart.can_undo:
        assert together.can_undo
        together.undo()
        apart.undo()
        assert together.draft == apart.draft
        assert together.recipe == apart.recipe
    assert not together.can_undo


ENTRIES: Sequence[dict[str, Any]] = [
    PEAK,
    RANDOM,
    {"kind": "peak", "levels": 3},
    {"kind": "pit", "levels": 3},
    {"kind": "horizontal_barrier", "levels": 3, "first": [0, 0], "last": [0, 9]},
]


def _given(do: str, **of: Any) -> st.SearchStrategy[Action]:
    return st.fixed_dictionaries({"do": st.just(do), **{key: _drawn(value) for key, value in of.items()}})


def _drawn(value: Any) -> st.SearchStrategy[Any]:
    return value if isinstance(value, st.SearchStrategy) else st.sampled_from(value)


ROW, CELL = st.integers(0, 3), st.lists(st.integers(0, 9), min_size=2, max_size=2)
CHANGES: st.SearchStrategy[Action] = st.one_of(
    _given("add", entry=ENTRIES),
    _given("set", name=["seed"], value=[1, 2]),
    _given("change", row=ROW, entry=ENTRIES),
    _given("fix", row=ROW, index=[0, 1]),
    _given("move_end", row=ROW, end=["first", "last", "both"], cell=CELL, gesture=[None, "a"]),
    _given("move", row=ROW, to=ROW),
    _given("enable", row=ROW, enabled=[True, False]),
    _given("paint", row=[-1, 0, 1], cells=st.lists(CELL, min_size=1, max_size=3), level=[-1, 1, 2]),
    _given("duplicate", row=ROW),
    _given("undo"),
    _given("redo"),
)


@given(st.lists(CHANGES, max_size=12))
def test_any_actions_of_one_edit_make_what_they_make_one_by_one(actions: Sequence[Action]) -> None:
    """Four rows are alike, and two; none of the actions makes one that is not valid."""
    together, apart = Session.of(Recipe(seed=7)), Session.of(Recipe(seed=7))
    start: Sequence[Action] = [*[{"do": "add", "entry": {"kind": "peak", "levels": 3}}] * 4, ADD, ADD]
    actions = [*start, *actions]
    for number, action in enumerate(actions):
        try:
            act(apart, [action], 0)
        except ParameterError:  # a row that is not there after some are undone
            actions = actions[:number]
            break
    act(together, actions, 0)
    assert apart.problem is None
    assert (together.draft, together.recipe) == (apart.draft, apart.recipe)
    while apart.can_undo:
        assert together.can_undo
        together.undo()
        apart.undo()
        assert (together.draft, together.recipe) == (apart.draft, apart.recipe)
    assert not together.can_undo


def test_an_edit_that_fails_after_many_actions_changes_nothing() -> None:
    session = Session.of()
    act(session, [ADD], 0)
    before, recipe = session.draft, session.recipe
    with pytest.raises(ParameterError, match=r"actions\[2\]\.row"):
        act(session, [ADD, ADD, {"do": "remove", "row": 9}], 0)
    assert (session.draft, session.recipe) == (before, recipe)
    act(session, [ADD], 0)
    assert len(session.recipe.obstacles) == 2


def test_pages_hear_once_of_an_edit() -> None:
    session, heard = Session.of(), list[int]()
    session.changed = lambda: heard.append(session.revision)
    act(session, [ADD, ADD, {"do": "reroll"}], 0)
    assert heard == [session.revision]
