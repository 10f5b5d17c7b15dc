"""The recipe that is open in the window, the obstacle that is selected in it, and what the user does to both."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rsegen.field.stepfield import StepField
from rsegen.gui.model.obstacle_ends import Grip, Handle, aligned, cells_between, handles_of, moved, other_end
from rsegen.gui.model.painting import UNPAINTED, can_paint, is_inside, painted
from rsegen.gui.model.session import Entry, Session
from rsegen.params.sorts import Cell


class Document:
    """A session and the row of its selected obstacle, -1 if none is.

    changed: called after every change of either; opened: called after another session was opened.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.selected = -1
        self._proposes = False
        self.changed: Callable[[], None] = lambda: None
        self.opened: Callable[[], None] = lambda: None

    @property
    def selected_entry(self) -> Entry | None:
        """The obstacle that is selected, as a recipe file has it."""
        return self.session.draft.rows[self.selected].entry if self.selected >= 0 else None

    @property
    def is_proposing(self) -> bool:
        """Return whether the form has a new obstacle for a ghost: one was edited there, or the list is empty."""
        return self.selected < 0 and (self._proposes or not self.session.draft.rows)

    def keyed(self, entry: Entry) -> Entry:
        """An entry with the key of the selected obstacle, or with the one that it gets when it is added."""
        key = (self.selected_entry or {}).get("key")
        return {**entry, "key": key} if key else self.session.keyed(entry)

    def handles(self, shape: Cell) -> list[Handle]:
        """The ends of all obstacles on a map of this number of blocks along x and y."""
        return handles_of(self.session.draft.rows, shape)

    def open(self, session: Session) -> None:
        """Edit another session, such as that of a file."""
        self.session, self.selected, self._proposes = session, -1, False
        session.changed = self._session_changed
        self.opened()

    def select(self, row: int) -> None:
        """Select an obstacle; -1 selects none."""
        self.selected, self._proposes = row, False
        self.changed()

    def select_at(self, cell: Cell | None, field: StepField) -> None:
        """Select the last obstacle with a field cell between its ends; none if there is none, or no cell."""
        handles = self.handles(field.blocks.shape) if cell else []
        found = [each.row for each in handles if cell and is_inside(cell, cells_between(each, field))]
        self.select(found[-1] if found else -1)

    # Changes of the list.

    def add(self, entry: Entry) -> None:
        """Add an obstacle at the end of the list, and select it."""
        self.selected, self._proposes = len(self.session.draft.rows), False
        self.session.add(entry)

    def draw(self, entry: Entry, first: Cell, last: Cell) -> None:
        """Add an obstacle with these ends, in line where its kind must be axis-aligned."""
        self.add(aligned({**entry, "first": list(first), "last": list(last)}, "last"))

    def move(self, row: int, to: int) -> None:
        """Move an obstacle in the list, and select it."""
        self.selected = to
        self.session.move(row, to)

    def can_shift(self, by: int) -> bool:
        """Return whether the selected obstacle can be moved by this number of rows."""
        return self.selected >= 0 and 0 <= self.selected + by < len(self.session.draft.rows)

    def shift(self, by: int) -> None:
        """Move the selected obstacle by this number of rows."""
        if self.can_shift(by):
            self.move(self.selected, self.selected + by)

    def duplicate(self) -> None:
        """Copy the selected obstacle to the row below it, and select the copy."""
        if self.selected >= 0:
            row, self.selected = self.selected, self.selected + 1
            self.session.duplicate(row)

    def remove(self) -> None:
        """Remove the selected obstacle."""
        if self.selected >= 0:
            self.session.remove(self.selected)

    def remove_selected_or_last(self) -> None:
        """Remove the selected obstacle; if none is selected, the last one."""
        if rows := self.session.draft.rows:
            self.session.remove(self.selected if self.selected >= 0 else len(rows) - 1)

    # Changes of one obstacle; those of one gesture are undone together.

    def edit(self, entry: Entry) -> None:
        """Replace the parameters of the selected obstacle; without one, propose this entry as a new obstacle."""
        if self.selected >= 0:
            self.session.change(self.selected, entry, gesture=("form", self.selected))
        else:
            self._proposes = True
            self.changed()

    def move_end(self, row: int, end: str, cell: Cell) -> None:
        """Move the first or the last end of an obstacle, or the middle of both, to a cell, and select the obstacle."""
        entry, shape = self.session.draft.rows[row].entry, self.session.recipe.grid.shape
        self.selected = row
        if end == "both":
            (handle,) = moved([each for each in self.handles(shape) if each.row == row], Grip(row, "both"), cell, shape)
            ends = {"first": list(handle.first or ()), "last": list(handle.last or ())}
            self.session.change(row, {**entry, **ends}, gesture=("drag", row, end))
        else:
            self.session.change(row, aligned({**entry, end: list(cell)}, other_end(end)), gesture=("drag", row, end))

    def paint(self, cells: Sequence[Cell], level: int, stroke: int) -> None:
        """Give cells a level: in the selected matrix, or else in a new one."""
        rows, gesture, entry = self.session.draft.rows, ("paint", stroke), self.selected_entry
        if entry is not None and can_paint(entry):
            self.session.change(self.selected, painted(entry, cells, level), gesture=gesture)
        elif level != UNPAINTED:
            self.selected = len(rows)
            self.session.add(painted(None, cells, level), gesture=gesture)

    def _session_changed(self) -> None:
        self.selected = min(self.selected, len(self.session.draft.rows) - 1)
        self.changed()
