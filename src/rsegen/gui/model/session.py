"""A recipe while it is edited, with undo and redo.

    draft --recipe--> Recipe --compose--> Scene

A draft may be invalid while the user types; the session then keeps the last valid recipe, and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from rsegen.errors import ParameterError
from rsegen.io.recipe_file import load
from rsegen.io.targets import recipe_in
from rsegen.params.sorts import Json
from rsegen.params.streams import fresh_seed
from rsegen.recipe.codec import decode
from rsegen.recipe.recipe import Recipe
from rsegen.run.single_files import save

Entry = Mapping[str, Json]
"""An obstacle as a recipe file has it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ObstacleRow:
    """A row of the list: an obstacle, and whether it is switched on."""

    entry: Entry
    enabled: bool = True


@dataclass(frozen=True, kw_only=True, slots=True)
class Draft:
    """Everything that undo restores: the global parameters as a recipe file has them, and the list of obstacles."""

    values: Entry
    rows: tuple[ObstacleRow, ...] = ()

    def recipe(self) -> Recipe:
        """The recipe of the rows that are switched on; a ParameterError counts all rows, also those switched off."""
        enabled = [number for number, row in enumerate(self.rows) if row.enabled]
        try:
            return decode({**self.values, "obstacles": [dict(self.rows[number].entry) for number in enabled]})
        except ParameterError as error:
            raise _with_all_rows_counted(error, enabled) from None


@dataclass(kw_only=True)
class Session:
    """A draft and its history.

    changed: called after every change; path: the recipe's file, if it has one; copy_of: the name of the recipe that
    was copied; seed_kept: Start draws no other seed;
    problem: why the draft is invalid; recipe: the last valid one.
    """

    draft: Draft
    path: Path | None = None
    copy_of: str = ""
    seed_kept: bool = True
    changed: Callable[[], None] = lambda: None
    problem: ParameterError | None = None
    recipe: Recipe = field(default_factory=lambda: Recipe(seed=0))
    _undone: list[Draft] = field(default_factory=list)
    _done: list[Draft] = field(default_factory=list)
    _saved: Draft | None = None
    _gesture: object = None

    def __post_init__(self) -> None:
        self._saved = self.draft
        self._check()

    @classmethod
    def new(cls) -> Session:
        """A session with one flat pallet."""
        return cls(draft=draft_of(Recipe()))

    @classmethod
    def opened(cls, path: Path) -> Session:
        """A session with the recipe of a file, or of DIR#17, a map of a data set; the latter has no path."""
        return cls(draft=draft_of(recipe_in(path)), path=path if path.exists() else None)

    @classmethod
    def copied(cls, path: Path) -> Session:
        """A session with a copy of the recipe of a file; it has no path."""
        return cls(draft=draft_of(load(path)), copy_of=path.stem)

    @classmethod
    def imported(cls, recipe: Recipe) -> Session:
        """A session with a recipe that is in no file yet."""
        session = cls(draft=draft_of(recipe))
        session._saved = None
        return session

    @property
    def title(self) -> str:
        """What the window calls the recipe."""
        if self.path:
            return self.path.name
        return f"copy of {self.copy_of}" if self.copy_of else "untitled"

    # Global parameters.

    def set(self, name: str, value: Json, *, gesture: object = None) -> None:
        """Change a global parameter."""
        self._put(replace(self.draft, values={**self.draft.values, name: value}), gesture)

    def reroll(self) -> None:
        """Draw another seed."""
        self.set("seed", fresh_seed())

    # The list of obstacles.

    def add(self, entry: Entry, at: int | None = None, *, gesture: object = None) -> int:
        """Add an obstacle, at the end by default; gives its row."""
        at = len(self.draft.rows) if at is None else at
        row = ObstacleRow(entry=MappingProxyType(self.keyed(entry)))
        self._put_rows((*self.draft.rows[:at], row, *self.draft.rows[at:]), gesture)
        return at

    def keyed(self, entry: Entry) -> dict[str, Json]:
        """An entry with the key that it gets when it is added."""
        return {**entry, "key": self._free_key()}

    def duplicate(self, row: int) -> int:
        """Copy a row to the row below it; gives that row."""
        return self.add(self.draft.rows[row].entry, row + 1)

    def remove(self, row: int) -> None:
        """Remove a row."""
        self._put_rows((*self.draft.rows[:row], *self.draft.rows[row + 1 :]))

    def clear(self) -> None:
        """Remove all rows."""
        self._put_rows(())

    def move(self, row: int, to: int) -> None:
        """Move a row in the list; later obstacles are imposed on earlier ones."""
        rows = list(self.draft.rows)
        rows.insert(to, rows.pop(row))
        self._put_rows(tuple(rows))

    def enable(self, row: int, *, enabled: bool) -> None:
        """Switch a row on or off."""
        self._change(row, replace(self.draft.rows[row], enabled=enabled), None)

    def change(self, row: int, entry: Entry, *, gesture: object = None) -> None:
        """Replace the parameters of a row; changes of one gesture, such as a drag, are undone together."""
        key = self.draft.rows[row].entry.get("key")
        named = {**entry, "key": key} if key else dict(entry)
        self._change(row, replace(self.draft.rows[row], entry=MappingProxyType(named)), gesture)

    # History and files.

    def undo(self) -> None:
        """Undo the last change."""
        if self._done:
            self._undone.append(self.draft)
            self._show(self._done.pop())

    def redo(self) -> None:
        """Redo the change that was undone last."""
        if self._undone:
            self._done.append(self.draft)
            self._show(self._undone.pop())

    @property
    def can_undo(self) -> bool:
        """Return whether there is anything to undo."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Return whether there is anything to redo."""
        return bool(self._undone)

    @property
    def unsaved(self) -> bool:
        """Return whether the draft differs from its file."""
        return self.draft != self._saved

    @property
    def switched_off(self) -> int:
        """The number of rows that are switched off, which a recipe file cannot hold."""
        return sum(not row.enabled for row in self.draft.rows)

    def save(self, path: Path) -> None:
        """Write the recipe to a file; rows that are switched off are left out, so ask first."""
        save(self.draft.recipe(), path, confirmed=True)
        self.path, self._saved = path, self.draft
        self.changed()

    def _put_rows(self, rows: tuple[ObstacleRow, ...], gesture: object = None) -> None:
        self._put(replace(self.draft, rows=rows), gesture)

    def _change(self, number: int, row: ObstacleRow, gesture: object) -> None:
        rows = (*self.draft.rows[:number], row, *self.draft.rows[number + 1 :])
        self._put(replace(self.draft, rows=rows), gesture)

    def _put(self, draft: Draft, gesture: object) -> None:
        if draft == self.draft:
            return
        if gesture is None or gesture != self._gesture:
            self._done.append(self.draft)
        self._undone.clear()
        self._show(draft)
        self._gesture = gesture

    def _show(self, draft: Draft) -> None:
        self.draft, self._gesture = draft, None
        self._check()
        self.changed()

    def _check(self) -> None:
        """Take over a valid draft as the recipe; keep the problem of an invalid one."""
        try:
            self.recipe, self.problem = self.draft.recipe(), None
        except ParameterError as error:
            self.problem = error

    def _free_key(self) -> str:
        taken = {row.entry.get("key") for row in self.draft.rows}
        return next(key for number in range(1, len(taken) + 2) if (key := f"obstacle-{number}") not in taken)


def draft_of(recipe: Recipe) -> Draft:
    """The draft of a recipe."""
    rows = tuple(ObstacleRow(entry=MappingProxyType(obstacle.entry())) for obstacle in recipe.obstacles)
    return Draft(values=recipe.values(), rows=rows)


def _with_all_rows_counted(error: ParameterError, enabled: Sequence[int]) -> ParameterError:
    """The error with the row in the list: `obstacles[1]` counts only the rows that are switched on."""
    head, bracket, rest = error.where.partition("obstacles[")
    number, closing, after = rest.partition("]")
    if not (bracket and closing and not head):
        return error
    return type(error)(f"obstacles[{enabled[int(number)]}]{after}", error.problem)
