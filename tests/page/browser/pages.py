"""Content of a page, read back out of its HTML as a browser does."""

from __future__ import annotations

import json
import re
from base64 import b64decode
from html.parser import HTMLParser
from typing import Any

import numpy as np

from rsegen.field.stepfield import Array


class Tags(HTMLParser):
    """The tags of a page with their attributes, and the text in each element of data."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.data = ""
        self.title = ""
        self._inside = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = "data" if ("id", "data") in attrs else tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside in ("data", "title"):
            setattr(self, self._inside, getattr(self, self._inside) + data)


def maps_of(html: bytes) -> list[dict[str, Any]]:
    """The maps of a page, as its scripts get them."""
    found: list[dict[str, Any]] = json.loads(Tags(html.decode()).data)["maps"]
    return found


def cells_of(shown: dict[str, Any]) -> Any:
    """The number of each cell's entry in the palette, (n_x, n_y)."""
    numbers = np.frombuffer(b64decode(shown["content"]), dtype=f"<u{shown['bytes']}")
    return numbers.reshape(shown["cells"])


def heights_of(shown: dict[str, Any]) -> Array:
    """The height of each cell in metres, (n_x, n_y)."""
    heights: Array = np.array([entry["height"] for entry in shown["palette"]])[cells_of(shown)]
    return heights


def addresses(html: bytes) -> set[str]:
    """Addresses that the tags of a page load from elsewhere."""
    loaded = {
        value for _, attrs in Tags(html.decode()).tags for name, value in attrs.items() if name in ("src", "href")
    }
    return {value for value in loaded if value} | set(re.findall(r"@import|url\(", html.decode().partition("<body")[0]))
