"""A recipe while it is edited, without a page."""

from __future__ import annotations

import pytest
from hypothesis import example, given

from rsegen import Peak, Recipe, build
from rsegen.page.model.actions import aligned
from rsegen.page.model.session import Session, draft_of
from tests.support.samples import FULL
from tests.support.strategies import recipes

PEAK = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}
RANDOM = {"kind": "random", "levels": 3}


@pytest.fixture
def session() -> Session:
    return Session.of()


def kinds(session: Session) -> list[str]:
    return [row["kind"] for row in session.draft.rows]


def test_a_new_session_is_level_ground(session: Session) -> None:
    assert not build(session.recipe).levels.any()
    assert not session.unsaved
    assert not session.can_undo


def test_rows_are_added_removed_and_moved(session: Session) -> None:
    session.add(PEAK)
    session.add(RANDOM)
    session.add(PEAK, 1)
    assert kinds(session) == ["peak", "peak", "random"]
    session.move(row=2, to=0)
    assert kinds(session) == ["random", "peak", "peak"]
    session.remove(row=1)
    assert kinds(session) == ["random", "peak"]
    session.clear()
    assert kinds(session) == []


def test_every_change_can_be_undone_and_redone(session: Session) -> None:
    drafts = [session.draft]
    for change in (
        lambda: session.add(PEAK),
        lambda: session.set(name="chunks", value=[2, 1]),
        lambda: session.change(row=0, entry={**PEAK, "softness": 40}),
        lambda: session.enable(row=0, enabled=False),
        session.clear,
    ):
        change()
        drafts.append(session.draft)
    for draft in reversed(drafts[:-1]):
        session.undo()
        assert session.draft == draft
    assert not session.can_undo
    for draft in drafts[1:]:
        session.redo()
        assert session.draft == draft
    assert not session.can_redo


def test_a_change_after_undo_clears_redo(session: Session) -> None:
    session.add(PEAK)
    session.undo()
    session.add(RANDOM)
    assert not session.can_redo


def test_a_gesture_is_undone_at_once(session: Session) -> None:
    session.add(PEAK)
    before = session.draft
    for x in range(3, 7):
        session.change(row=0, entry={**PEAK, "last": [x, 7]}, gesture="drag")
    session.undo()
    assert session.draft == before


def test_a_gesture_that_ends_where_it_began_leaves_nothing_to_undo(session: Session) -> None:
    session.add(PEAK)
    before = session.draft
    for x in (9, 5, 7):
        session.change(row=0, entry={**PEAK, "last": [x, 7]}, gesture="drag")
    assert session.draft == before
    session.undo()
    assert not session.draft.rows
    session.redo()
    session.change(row=0, entry={**PEAK, "levels": 3}, gesture="typed")
    session.change(row=0, entry=PEAK, gesture="typed")
    session.change(row=0, entry={**PEAK, "levels": 4}, gesture="typed")
    session.undo()
    assert session.draft == before


def test_an_error_is_shown_and_the_last_valid_recipe_stays(session: Session) -> None:
    session.add(RANDOM)
    right = session.recipe
    session.set(name="chunk_size", value=0)
    assert str(session.problem) == "chunk_size: 0 is outside 1..1000 blocks"
    assert session.recipe == right
    session.set(name="chunk_size", value=12)
    assert str(session.problem) == "None"
    assert session.recipe.chunk_size == 12


def test_a_problem_names_the_row_in_which_it_stands(session: Session) -> None:
    session.add(RANDOM)
    session.add(PEAK)
    session.enable(row=0, enabled=False)
    session.change(row=1, entry={**PEAK, "softness": 130})
    assert session.problem is not None
    assert session.problem.where == "obstacles[1].softness"


def test_a_row_that_is_switched_off_stays_in_the_recipe_and_is_not_in_the_map(session: Session) -> None:
    session.add(PEAK)
    session.add(RANDOM)
    alone = build(Recipe(seed=session.recipe.seed, obstacles=session.recipe.obstacles[1:]))
    session.enable(row=0, enabled=False)
    assert [obstacle.enabled for obstacle in session.recipe.obstacles] == [False, True]
    assert build(session.recipe) == alone
    session.enable(row=0, enabled=True)
    assert "enabled" not in session.draft.rows[0]


def test_a_row_that_does_not_fit_can_be_switched_off(session: Session) -> None:
    session.add(PEAK)
    session.set(name="chunk_size", value=5)
    assert session.problem is not None
    session.enable(row=0, enabled=False)
    assert session.problem is None


def test_what_a_form_says_switches_nothing_on_and_changes_no_key(session: Session) -> None:
    session.add(PEAK)
    session.enable(row=0, enabled=False)
    session.change(row=0, entry={**PEAK, "softness": 10, "key": "other", "enabled": True})
    (obstacle,) = Recipe(seed=1, obstacles=[Peak(levels=5, first=(2, 2), last=(7, 7), softness=10)]).obstacles
    assert session.draft.rows[0] == {**PEAK, "softness": 10, "key": obstacle.key, "enabled": False}


def test_none_gives_a_parameter_its_default(session: Session) -> None:
    session.set(name="unit_cm", value=5)
    session.set(name="unit_cm", value=None)
    assert session.problem is None
    assert session.recipe.unit_cm == 10


def test_changes_are_taken_back_together_if_one_fails(session: Session) -> None:
    session.add(PEAK)
    before = session.draft, session.recipe, session.can_redo

    def fail() -> None:
        with session.all_or_nothing():
            session.clear()
            session.undo()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert (session.draft, session.recipe, session.can_redo) == before


def test_parameters_may_change_and_random_draws_of_a_row_with_a_key_stay() -> None:
    session = Session.of(Recipe(chunks=(3, 3), obstacles=[Peak(levels=5, key="mine")]))
    before = build(session.recipe).levels
    session.change(row=0, entry={"kind": "peak", "levels": 4})
    after = build(session.recipe).levels
    assert (before.nonzero()[0].min(), before.nonzero()[1].min()) == (
        after.nonzero()[0].min(),
        after.nonzero()[1].min(),
    )


def test_somebody_is_notified_of_every_change(session: Session) -> None:
    told: list[int] = []
    session.changed = lambda: told.append(len(session.draft.rows))
    session.add(PEAK)
    session.undo()
    session.redo()
    assert told == [1, 0, 1]


BARRIER = {"kind": "horizontal_barrier", "levels": 3}


@pytest.mark.parametrize(
    ("first", "last", "end", "expected"),
    [
        ([1, 1], [8, 3], "last", ([1, 1], [8, 1])),
        ([1, 1], [3, 8], "last", ([1, 1], [1, 8])),
        ([1, 1], [8, 3], "first", ([1, 3], [8, 3])),
        ([2, 1], [2, 7], "last", ([2, 1], [2, 7])),
    ],
)
def test_a_barrier_that_must_follow_an_axis_is_straightened(
    first: list[int], last: list[int], end: str, expected: tuple[list[int], list[int]]
) -> None:
    found = aligned({**BARRIER, "first": first, "last": last}, end)
    assert (found["first"], found["last"]) == expected


def test_ends_of_kinds_that_need_no_axis_stay_unchanged() -> None:
    assert aligned(PEAK, "last") == PEAK


@given(recipes())
@example(FULL)
def test_a_draft_is_its_recipe(recipe: Recipe) -> None:
    assert draft_of(recipe).recipe() == recipe


def test_an_obstacle_with_holes_raises_the_ground_as_far_as_it_needs_and_undo_lowers_it(session: Session) -> None:
    session.add(PEAK)
    pit = {"kind": "pit", "levels": 4, "first": [2, 2], "last": [7, 7]}
    row = session.add(pit)
    assert session.problem is None
    assert session.recipe.ground_level == 3
    assert build(session.recipe).blocks[2:8, 2:8].max() == 0
    session.change(row=row, entry={**pit, "levels": 6})
    assert session.recipe.ground_level == 5
    session.change(row=row, entry={**pit, "levels": 3})
    assert session.recipe.ground_level == 5  # a deck may be higher than its holes are deep
    for _ in range(3):
        session.undo()
    assert session.recipe.ground_level == 0
