"""What a browser may ask for: each is a function here called by its name, with JSON values as arguments.

    POST /api/pose {"doc": "d1", "index": 0, "robot": "burger", "x": 0.1, ...} --> pose(document, index=0, ...) --> JSON

A function takes the document of the page first, or, with `@call_of_host`, the host, which has all documents. What is
wrong with the arguments is a UserError, which the page shows where it belongs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

OF_DOCUMENT: dict[str, Callable[..., Any]] = {}
"""Functions of a document, by the name by which a page calls them."""

OF_HOST: dict[str, Callable[..., Any]] = {}
"""Functions of the host of all documents, by the name by which a page calls them."""


def call(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let pages call a function of a document."""
    OF_DOCUMENT[function.__name__] = function
    return function


def call_of_host(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let pages call a function of the host."""
    OF_HOST[function.__name__] = function
    return function
