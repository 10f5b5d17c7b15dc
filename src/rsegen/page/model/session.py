"""A recipe while it is edited, with undo and redo.

    draft --recipe--> Recipe --compose--> Scene

A draft may be invalid while the user types; the session then keeps the last valid recipe, and says what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from types import MappingProxyType
from typing import Annotated

from rsegen.errors import ParameterError, RsegenError, UnknownName
from rsegen.params.sorts import Json, parameters
from rsegen.params.streams import fresh_seed
from rsegen.recipe.codec import decode, decode_obstacle
from rsegen.recipe.map_design import MapDesign, derived_keys, key_stem, with_keys, without_derived_keys
from rsegen.recipe.recipe import Recipe

Entry = Annotated[Mapping[str, Json], "Entry"]
"""An obstacle as a recipe file has it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Draft:
    """Everything that undo restores: the global parameters as a recipe file has them, and the list of obstacles.

    own: keys that were given; other rows have those that follow from their content, as everywhere, and get another one
    with each change.
    """

    values: Entry
    rows: tuple[Entry, ...] = ()
    own: frozenset[str] = frozenset()

    def keyed(self) -> Draft:
        """Return the draft with the keys that follow from the content of its rows."""
        rows, places, obstacles = [*self.rows], [], []
        own = frozenset(key for row in rows if (key := _own_key(row, self.own)))
        for place, row in enumerate(rows):
            with suppress(RsegenError):  # a row that is not valid is said with the whole draft
                obstacles.append(decode_obstacle(_bare(row, own)))
                places.append(place)
        with suppress(ParameterError):  # two rows of one key too
            for place, obstacle in zip(places, with_keys(tuple(obstacles)), strict=True):
                if rows[place].get("key") != obstacle.key:
                    rows[place] = MappingProxyType({**rows[place], "key": obstacle.key})
        return replace(self, rows=tuple(rows), own=own)

    def says(self, other: Draft) -> bool:
        """Return whether it is like another draft, but for keys that follow from the content of rows."""
        if (self.values, self.own, len(self.rows)) != (other.values, other.own, len(other.rows)):
            return False
        pairs = zip(self.rows, other.rows, strict=True)
        return all(row is old or row == old or _bare(row, self.own) == _bare(old, self.own) for row, old in pairs)

    def recipe(self) -> Recipe:
        """Return the recipe of the draft; a ParameterError if it is invalid."""
        return decode({**self.values, "obstacles": [dict(row) for row in self.rows]})


def _own_key(row: Entry, own: frozenset[str]) -> str:
    """Return the key of a row if it is one that was given; else an empty text."""
    key = row.get("key")
    return key if isinstance(key, str) and key in own else ""


def _bare(row: Entry, own: frozenset[str]) -> Entry:
    """Return a row without a key that follows from its content."""
    bare = dict(row)
    if not _own_key(row, own):
        bare.pop("key", None)
    return bare


def _stem(row: Entry, own: frozenset[str]) -> str:
    """Return what the key of a row begins with; an empty text if it was given one, or is not valid."""
    with suppress(RsegenError):
        return "" if _own_key(row, own) else key_stem(decode_obstacle(row))
    return ""


def draft_of(recipe: Recipe, own: frozenset[str] | None = None) -> Draft:
    """Return the draft of a recipe.

    own: keys that were given, as those in its file; by default those that do not follow from the content of their rows
    """
    if own is None:
        own = frozenset(obstacle.key for obstacle in without_derived_keys(recipe.obstacles) if obstacle.key)
    rows = tuple(MappingProxyType(obstacle.entry()) for obstacle in recipe.obstacles)
    return Draft(values=MappingProxyType(recipe.values()), rows=rows, own=own)


def _raised(draft: Draft, entry: Entry) -> Draft:
    """Return a draft whose ground is as high as the holes of an obstacle are deep, which end at the floor."""
    try:
        depth = -decode_obstacle(entry).level_range[0] if is_enabled(entry) else 0
    except RsegenError:  # a row that is not valid is said with the whole draft
        return draft
    ground = draft.values.get("ground_level", 0)
    if not isinstance(ground, int) or depth <= ground:
        return draft
    return replace(draft, values=MappingProxyType({**draft.values, "ground_level": depth}))


def short_seed() -> int:
    """Return a fresh seed of at most nine digits, which people can read and type."""
    return fresh_seed() % 10**9


def is_enabled(entry: Entry) -> bool:
    """Return whether an obstacle is switched on."""
    return entry.get("enabled", True) is not False


@dataclass(kw_only=True)
class Session:
    """A draft and its history.

    changed: called after every change; revision: counts them, undo included; problem: why the draft is invalid;
    recipe: the last valid one; saved: the draft that is in the file, None without a file.
    """

    draft: Draft
    changed: Callable[[], None] = lambda: None
    revision: int = 0
    problem: ParameterError | None = None
    recipe: Recipe = field(default_factory=lambda: Recipe(seed=0))
    saved: Draft | None = None
    _undone: list[Draft] = field(default_factory=list)
    _done: list[Draft] = field(default_factory=list)
    _gesture: str | None = None
    _is_waiting: bool = False
    _is_unsettled: bool = False
    _checked: Draft = field(init=False)
    _stems: dict[int, tuple[Entry, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._check()

    @classmethod
    def of(cls, recipe: Recipe | None = None, own: frozenset[str] | None = None) -> Session:
        """Return a session with a recipe, or with one flat pallet, that counts as saved; own: as of a draft."""
        draft = draft_of(recipe or Recipe(), own)
        return cls(draft=draft, saved=draft)

    def set(self, *, name: str, value: Json, gesture: str | None = None) -> None:
        """Change a global parameter; None gives it back its default, of which a seed has none."""
        if name not in parameters(Recipe):
            raise UnknownName.among("name", "parameter", name, parameters(Recipe))
        values = {**self.draft.values, name: value}
        if value is None and name != "seed":
            del values[name]
        self._put(replace(self.draft, values=MappingProxyType(values)), gesture)

    def reroll(self) -> None:
        """Draw another seed, short enough to be read out and typed."""
        self.set(name="seed", value=short_seed())

    def add(self, entry: Entry, at: int | None = None, *, gesture: str | None = None) -> int:
        """Add an obstacle, at the end by default; return its row."""
        at = len(self.draft.rows) if at is None else at
        self._put(self._with_row(entry, at), gesture)
        return at

    def with_row(self, entry: Entry) -> Draft:
        """Return the draft with another obstacle at the end; its key follows from its content."""
        return self._with_row(entry, len(self.draft.rows)).keyed()

    def _with_row(self, entry: Entry, at: int) -> Draft:
        row = MappingProxyType({name: value for name, value in entry.items() if name != "key"})
        return _raised(replace(self.draft, rows=(*self.draft.rows[:at], row, *self.draft.rows[at:])), row)

    def remove(self, *, row: int) -> None:
        """Remove a row."""
        self._put(replace(self.draft, rows=(*self.draft.rows[:row], *self.draft.rows[row + 1 :])))

    def clear(self) -> None:
        """Remove all rows."""
        self._put(replace(self.draft, rows=()))

    def move(self, *, row: int, to: int) -> None:
        """Move a row in the list; later obstacles are imposed on earlier ones."""
        rows = list(self.draft.rows)
        rows.insert(to, rows.pop(row))
        self._put(replace(self.draft, rows=tuple(rows)))

    def enable(self, *, row: int, enabled: bool) -> None:
        """Switch a row on or off."""
        entry = {name: value for name, value in self.draft.rows[row].items() if name != "enabled"}
        self._replace(row, entry if enabled else {**entry, "enabled": False})

    def change(self, *, row: int, entry: Entry, gesture: str | None = None) -> None:
        """Replace the parameters of a row; a key that it was given stays, and whether it is switched on.

        Changes of one gesture, such as a drag, are undone together.
        """
        before = self.draft.rows[row]
        stays = {name: before[name] for name in ("key", "enabled") if name in before}
        changed = {name: value for name, value in entry.items() if name not in ("key", "enabled")}
        self._replace(row, {**changed, **stays}, gesture)

    def undo(self) -> None:
        """Undo the last change."""
        if self._done:
            self._undone.append(self.draft)
            self._show(self._keyed(self._done.pop()))

    def redo(self) -> None:
        """Redo the change that was undone last."""
        if self._undone:
            self._done.append(self.draft)
            self._show(self._keyed(self._undone.pop()))

    def restore(self, draft: Draft) -> None:
        """Take over a draft as one change, which undo takes back."""
        self._put(draft)

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
        return self.draft != self.saved

    @contextmanager
    def all_or_nothing(self) -> Iterator[None]:
        """Take back the changes that were made inside if they end with an error."""
        before = {**vars(self), "_done": [*self._done], "_undone": [*self._undone]}
        try:
            yield
        except Exception:
            revision = self.revision
            vars(self).update(before)  # pages that saw a change in between need a newer revision for its end
            if revision != self.revision:
                self.revision = revision + 1
                self.changed()
            raise

    @contextmanager
    def together(self) -> Iterator[None]:
        """Check the list of obstacles once for all changes that are made inside, at their end, or when `settle` asks.

        Each check goes over the whole list. Until then the draft and its history lack keys, and the recipe is older.
        """
        self._is_waiting = True
        try:
            yield
            self.settle()
        finally:
            self._is_waiting = False
            self._stems.clear()

    @property
    def design(self) -> MapDesign:
        """The recipe; obstacles that wait may not be in it yet, its seed and the size of its maps are."""
        known = self.recipe.values()
        differs = any(known[name] != self.draft.values.get(name) for name in ("seed", "chunk_size", "chunks"))
        if differs and not self._is_still_wrong():
            self.settle()
        return self.recipe

    def keyed_row(self, row: int) -> Entry:
        """Return a row with its key, also if that waits: the key of its content, numbered after the rows above it."""
        entry, rows, own = self.draft.rows[row], self.draft.rows, self.draft.own
        if not self._is_unsettled:
            return entry
        known = self._stems
        for other in rows[: row + 1]:
            if id(other) not in known:
                known[id(other)] = other, _stem(other, own)  # which keeps the row, so that no other one has its id
        stem = known[id(entry)][1]
        if not stem:
            return entry
        above = sum(known[id(other)][1] == stem for other in rows[:row])
        taken = {key for other in rows if (key := _own_key(other, own))} if own else set[str]()
        return {**entry, "key": next(islice(derived_keys(stem, taken), above, None))}

    def _is_still_wrong(self) -> bool:
        """Return whether the draft is surely invalid: by its values alone, or by the row that was wrong before."""
        try:
            decode(self.draft.values)
        except RsegenError:
            return True
        row = re.match(r"obstacles\[(\d+)\](?!\.key)", self.problem.where) if self.problem else None
        if not row or self.draft.values != self._checked.values:
            return False
        return any(other is self._checked.rows[int(row[1])] for other in self.draft.rows)

    def settle(self) -> None:
        """Give rows their keys, and take over the recipe, if changes made `together` wait for that."""
        if self._is_unsettled:
            self.draft, self._is_unsettled = self.draft.keyed(), False
            self._check()
            self.changed()

    def _keyed(self, draft: Draft) -> Draft:
        return draft if self._is_waiting else draft.keyed()

    def _replace(self, row: int, entry: Entry, gesture: str | None = None) -> None:
        rows = (*self.draft.rows[:row], MappingProxyType(dict(entry)), *self.draft.rows[row + 1 :])
        self._put(_raised(replace(self.draft, rows=rows), entry), gesture)

    def _put(self, draft: Draft, gesture: str | None = None) -> None:
        if draft.rows is not self.draft.rows:
            draft = self._keyed(draft)
        if draft.says(self.draft):
            return
        if gesture is None or gesture != self._gesture:
            self._done.append(self.draft)
        elif draft.says(self._done[-1]):  # a gesture that ends where it began leaves nothing to undo
            self._done.pop()
            gesture = None
        self._undone.clear()
        self._show(draft)
        self._gesture = gesture

    def _show(self, draft: Draft) -> None:
        self.draft, self._gesture = draft, None
        self.revision += 1
        if self._is_waiting:
            self._is_unsettled = True
            return
        self._check()
        self.changed()

    def _check(self) -> None:
        """Take over a valid draft as the recipe; keep the problem of an invalid one."""
        self._checked = self.draft
        try:
            self.recipe, self.problem = self.draft.recipe(), None
        except ParameterError as error:
            self.problem = error
        except RsegenError as error:  # such as a plug-in that cannot be loaded
            self.problem = ParameterError("", str(error))
