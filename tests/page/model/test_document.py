"""The open recipe and its selected obstacle, without a window."""

from __future__ import annotations

import pytest

from rsegen.gui.model.document import Document
from rsegen.gui.model.painting import UNPAINTED
from rsegen.gui.model.session import Session

PEAK = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}
BARRIER = {"kind": "horizontal_barrier", "levels": 3}


@pytest.fixture
def document() -> Document:
    document = Document(Session.new())
    document.open(document.session)
    return document


def kinds(document: Document) -> list[str]:
    return [row.entry["kind"] for row in document.session.draft.rows]


def test_an_obstacle_that_is_added_is_selected(document: Document) -> None:
    document.add(PEAK)
    document.add(BARRIER)
    assert (kinds(document), document.selected) == (["peak", "horizontal_barrier"], 1)
    assert document.selected_entry is not None
    assert document.selected_entry["kind"] == "horizontal_barrier"


def test_the_selection_follows_a_row_that_is_moved_or_copied(document: Document) -> None:
    document.add(PEAK)
    document.add(BARRIER)
    document.shift(-1)
    assert (kinds(document), document.selected) == (["horizontal_barrier", "peak"], 0)
    document.duplicate()
    assert (kinds(document), document.selected) == (["horizontal_barrier", "horizontal_barrier", "peak"], 1)


def test_a_row_is_not_shifted_out_of_the_list(document: Document) -> None:
    document.add(PEAK)
    assert not document.can_shift(1)
    document.shift(1)
    document.shift(-1)
    assert (kinds(document), document.selected) == (["peak"], 0)


def test_the_selection_stays_in_a_list_that_becomes_shorter(document: Document) -> None:
    document.add(PEAK)
    document.add(BARRIER)
    document.remove_selected_or_last()
    assert document.selected == 0
    document.session.clear()
    assert (document.selected, document.selected_entry) == (-1, None)


def test_without_a_selection_nothing_is_edited_copied_or_removed(document: Document) -> None:
    document.add(PEAK)
    document.select(-1)
    before = document.session.draft
    document.edit(BARRIER)
    document.duplicate()
    document.remove()
    assert document.session.draft == before


def test_edits_of_one_gesture_are_undone_together(document: Document) -> None:
    document.add(PEAK)
    for softness in (10, 20, 30):
        document.edit({**PEAK, "softness": softness})
    document.session.undo()
    assert "softness" not in document.session.draft.rows[0].entry
    for x in (8, 9):
        document.move_end(0, "last", (x, 9))
    document.session.undo()
    assert document.session.draft.rows[0].entry["last"] == [7, 7]


def test_an_obstacle_that_is_drawn_is_axis_aligned_where_its_kind_must_be(document: Document) -> None:
    document.draw(BARRIER, (1, 1), (8, 3))
    assert document.selected_entry is not None
    assert document.selected_entry["last"] == [8, 1]
    document.move_end(0, "last", (2, 9))
    assert document.session.problem is None


def test_an_obstacle_is_moved_by_its_middle_within_the_map(document: Document) -> None:
    document.add({**BARRIER, "first": [2, 4], "last": [7, 4]})
    for middle, first, last in (((5, 6), [3, 6], [8, 6]), ((9, 0), [4, 0], [9, 0]), ((0, 9), [0, 9], [5, 9])):
        document.move_end(0, "both", middle)
        entry = document.session.draft.rows[0].entry
        assert (entry["first"], entry["last"]) == (first, last)
    document.session.undo()
    assert document.session.draft.rows[0].entry["first"] == [2, 4]


def test_cells_are_painted_into_the_selected_matrix_or_into_a_new_one(document: Document) -> None:
    document.paint([(0, 0)], UNPAINTED, 1)
    assert kinds(document) == []
    document.paint([(2, 2), (3, 2)], 3, 2)
    document.paint([(4, 2)], 1, 3)
    assert document.session.draft.rows[0].entry["rows"] == ["3 3 1"]
    document.select(-1)
    document.paint([(9, 9)], 2, 4)
    assert (kinds(document), document.selected) == (["matrix", "matrix"], 1)


def test_every_change_and_every_opening_is_signalled(document: Document) -> None:
    told: list[str] = []
    document.changed, document.opened = lambda: told.append("changed"), lambda: told.append("opened")
    document.add(PEAK)
    document.select(-1)
    document.open(Session.new())
    document.session.undo()
    document.add(PEAK)
    assert told == ["changed", "changed", "opened", "changed"]
