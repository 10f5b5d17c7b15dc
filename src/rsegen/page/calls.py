"""Calls of a browser: functions that it calls by their names, with JSON values as arguments.

    POST /api/pose {"doc": "d1", "index": 0, "robot": "burger", "x": 0.1, ...} --> pose(document, index=0, ...) --> JSON

A function takes the document of the page first, or, with `@call_of_host`, the host, which has all documents. What is
wrong with the arguments is a UserError, which the page shows where it belongs.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import NoneType, UnionType
from typing import Any, Literal, TypedDict, TypeVar, Union, get_args, get_origin, get_type_hints

from rsegen.errors import ParameterError, UnknownName, UserError, shown
from rsegen.params.capabilities import hooks


class OfQuestion(TypedDict, total=False):
    """The additional key of a failure that is a question: repeat with replace: true."""

    kind: Literal["exists", "changed"]


class Failure(OfQuestion):
    """The reason why a call failed."""

    where: str  # the parameter, as in obstacles[2].softness
    text: str


OF_DOCUMENT: dict[str, Callable[..., Any]] = {}
"""Functions of a document, by the name by which a page calls them."""

OF_HOST: dict[str, Callable[..., Any]] = {}
"""Functions of the host of all documents, by the name by which a page calls them."""

AT_ONCE: set[str] = set()
"""Functions of a document that run while others of it do."""

_F = TypeVar("_F", bound=Callable[..., Any])


class Question(UserError):
    """A request to be repeated with `replace: true` if a person says so; kind: "exists" or "changed"."""

    def __init__(self, text: str, kind: Literal["exists", "changed"]) -> None:
        super().__init__(text)
        self.kind = kind


def call_of_document(function: _F) -> _F:
    """Let pages call a function of a document; of one document, one such function runs at a time."""
    OF_DOCUMENT[function.__name__] = function
    return function


def call_at_once(function: _F) -> _F:
    """Let pages call a function of a document that changes nothing, and takes what it reads under the document's lock.

    So what takes seconds holds up no change.
    """
    AT_ONCE.add(function.__name__)
    return call_of_document(function)


def call_of_host(function: _F) -> _F:
    """Let pages call a function of the host."""
    OF_HOST[function.__name__] = function
    return function


def load_calls() -> None:
    """Import every module of this package, and those that capabilities declare, each of which registers its calls."""
    for module in iter_modules([str(Path(__file__).parent)], f"{__package__}."):
        import_module(module.name)
    for _ in hooks("calls"):
        pass


def checked_arguments(function: Callable[..., Any], arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments for the keyword parameters of a function; a ParameterError for wrong names, types, or missing
    ones.
    """
    known, needed = keywords(function)
    for name in arguments:
        if name not in known:
            raise UnknownName.among("", "argument", name, known)
    for name in needed:
        if name not in arguments:
            raise ParameterError(name, "is missing")
    return {name: _checked(name, value, known[name]) for name, value in arguments.items()}


@cache
def keywords(function: Callable[..., Any]) -> tuple[Mapping[str, Any], Sequence[str]]:
    """Return the types of a function's keyword parameters, and the names of those that must be given."""
    hints = get_type_hints(function)
    only = inspect.Parameter.KEYWORD_ONLY
    parameters = [known for known in inspect.signature(function).parameters.values() if known.kind is only]
    needed = [known.name for known in parameters if known.default is inspect.Parameter.empty]
    return {known.name: hints[known.name] for known in parameters}, needed


def _checked(where: str, value: Any, wanted: Any) -> Any:
    """Return a JSON value as a type has it, lists as tuples where it is one; a ParameterError if it is of another."""
    if wanted is Any or wanted is object:
        return value
    origin, parts = get_origin(wanted) or wanted, get_args(wanted)
    if origin in (Union, UnionType):
        if value is None and NoneType in parts:
            return None
        return _checked_union(where, value, [part for part in parts if part is not NoneType])
    if origin is Literal:
        if value in parts and not isinstance(value, bool):
            return value
        raise ParameterError(where, f"{shown(value)} is none of {', '.join(map(str, parts))}")
    if wanted in _PLAIN:
        types, words = _PLAIN[wanted]
        with suppress(OverflowError):  # a whole number of hundreds of digits as a float
            if isinstance(value, types) and (wanted is bool or not isinstance(value, bool)):
                return wanted(value)
        raise ParameterError(where, f"{shown(value)} is not {words}")
    return _checked_container(where, value, origin, parts)


def _checked_union(where: str, value: Any, parts: Sequence[Any]) -> Any:
    """Return a value of the first type that it is of; the error of the last one if it is of none."""
    for part in parts[:-1]:
        with suppress(ParameterError):
            return _checked(where, value, part)
    return _checked(where, value, parts[-1])


def _checked_container(where: str, value: Any, origin: Any, parts: tuple[Any, ...]) -> Any:
    """Return a list, pair or object whose parts are checked too."""
    if origin in (dict, Mapping):
        if not isinstance(value, dict):
            raise ParameterError(where, f"{shown(value)} is not an object")
        return value
    if not isinstance(value, list):
        raise ParameterError(where, f"{shown(value)} is not a list")
    if origin is tuple and Ellipsis not in parts:
        if len(value) != len(parts):
            raise ParameterError(where, f"{shown(value)} is not a list of {len(parts)}")
    else:
        parts = (parts[0] if parts else Any,) * len(value)
    pairs = zip(value, parts, strict=True)
    entries = [_checked(f"{where}[{index}]", entry, part) for index, (entry, part) in enumerate(pairs)]
    return tuple(entries) if origin is tuple else entries


_PLAIN: Mapping[Any, tuple[Any, str]] = {
    bool: (bool, "true or false"),
    int: (int, "a whole number"),
    float: ((int, float), "a number"),
    str: (str, "a text"),
}
