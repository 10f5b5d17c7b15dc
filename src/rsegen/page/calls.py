"""What a browser may ask for: each is a function here called by its name, with JSON values as arguments.

    POST /api/pose {"doc": "d1", "index": 0, "robot": "burger", "x": 0.1, ...} --> pose(document, index=0, ...) --> JSON

A function takes the document of the page first, or, with `@call_of_host`, the host, which has all documents. What is
wrong with the arguments is a UserError, which the page shows where it belongs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeVar

from rsegen.errors import UserError

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


def call(function: _F) -> _F:
    """Let pages call a function of a document; of one document, one such function runs at a time."""
    OF_DOCUMENT[function.__name__] = function
    return function


def call_at_once(function: _F) -> _F:
    """Let pages call a function of a document that changes nothing, and takes what it reads under the document's lock.

    So what takes seconds holds up no change.
    """
    AT_ONCE.add(function.__name__)
    return call(function)


def call_of_host(function: _F) -> _F:
    """Let pages call a function of the host."""
    OF_HOST[function.__name__] = function
    return function
