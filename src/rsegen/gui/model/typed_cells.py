"""Cells of the list of obstacles as text: what is shown in them, what is typed into them, and which one is wrong."""

from __future__ import annotations

from rsegen.errors import ParameterError
from rsegen.field.obstacles import KINDS, Obstacle
from rsegen.gui.model.session import Entry
from rsegen.params.places import CellRef
from rsegen.params.sorts import Float, Json, Parameter, parameters
from rsegen.recipe.codec import OTHER_NAMES
from rsegen.recipe.placement import Placement

TITLES = {"kind": "type", "max_height": "height"}
"""What the window calls parameters whose name says less."""


def kind_words(kind: str) -> str:
    """The name of a kind in plain words: diagonal barrier."""
    return kind.replace("_", " ")


_DEFAULTS = {"softness": 0}
"""What is shown of keys that a recipe may leave out."""


def cell_text(entry: Entry, key: str) -> str:
    """A value of an entry as the text of a cell, kinds in plain words; empty for one that is missing, of no default."""
    value = entry.get(key, _DEFAULTS.get(key))
    if value is None:
        return ""
    if isinstance(value, str) and value in KINDS:
        return kind_words(value)
    if isinstance(value, float):
        return f"{value:g}"
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def with_typed(entry: Entry, key: str, text: str) -> Entry:
    """An entry after a text was typed into the cell of a key; an empty text removes the value.

    What is typed may be invalid: the draft then says so. Another kind takes over the parameters that it has too.
    """
    text = text.strip()
    if key == "kind":
        return _with_kind(entry, next((kind for kind in KINDS if text in {kind, kind_words(kind)}), text))
    rest = {name: value for name, value in entry.items() if name != key}
    return {**rest, key: _parsed(entry["kind"], key, text)} if text else rest


def wrong_cell(problem: ParameterError | None) -> tuple[int, str]:
    """The row and the key that a problem is about: -1 if it is about no row, an empty key if about the whole row."""
    head, _, rest = (problem.where if problem else "").partition("obstacles[")
    number, closing, after = rest.partition("]")
    if head or not closing or not number.isdigit():
        return -1, ""
    key = after.removeprefix(".").partition("[")[0]
    return int(number), OTHER_NAMES.get(key, key)


def problem_text(problem: ParameterError | None) -> str:
    """A problem as the window says it: `Row 4, X first: 99 is outside 0..29`; empty if there is none."""
    if problem is None:
        return ""
    row, key = wrong_cell(problem)
    return f"Row {row + 1}, {_words(key, problem.where)}: {problem.problem}" if row >= 0 else str(problem)


def _words(key: str, where: str) -> str:
    """A parameter of an obstacle in plain words: X first for `obstacles[0].first[0]`."""
    axis = {"[0]": "X ", "[1]": "Y "}.get(where[-3:], "") if key in {"first", "last"} else ""
    number = where[where.rindex("[") :] if key and not axis and where.endswith("]") and "." in where else ""
    return f"{axis}{TITLES.get(key, key).replace('_', ' ')}{number}" if key else "the obstacle"


def _with_kind(entry: Entry, kind: str) -> Entry:
    known = {**parameters(KINDS[kind]), **parameters(Placement)} if kind in KINDS else entry
    return {"kind": kind} | {name: value for name, value in entry.items() if name != "kind" and name in known}


def typed_value(parameter: Parameter, text: str) -> object:
    """The value of a text as on the command line, unchecked; a comma in a number that is no list is a decimal mark."""
    number = parameter.parse(text.replace(",", ".")) if isinstance(parameter, Float) else text
    return number if isinstance(number, float) else parameter.parse(text)


def _parsed(kind: str, key: str, text: str) -> Json:
    """The value of a text; a place may be in brackets, as messages write it. The kind may be unknown."""
    sort = {**parameters(KINDS.get(kind, Obstacle)), **parameters(Placement)}[key]
    found = typed_value(sort, text.replace(" ", "").strip("[]") if isinstance(sort, CellRef) else text)
    return list(found) if isinstance(found, tuple) else found
