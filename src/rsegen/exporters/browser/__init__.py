"""Maps as a page for browsers: one HTML file with 3D view, plan, metrics and recipe, which needs no internet.

The page is page.html with its style and scripts, which are files of this folder, and the maps as JSON. Names and
recipes may have any letters: in the HTML they are escaped, in the JSON there is no `<`, and the scripts set text as
text.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from html import escape
from importlib.resources import files

from rsegen import __version__
from rsegen.exporters.browser.content import ShownMap, content

_SCRIPTS = ("field.js", "solid.js", "plan.js", "page.js")

__all__ = ["ShownMap", "page"]


def page(maps: Sequence[ShownMap]) -> bytes:
    """The page that shows maps, one at a time, as the bytes of an HTML file; the same maps give the same bytes."""
    title = maps[0].name if len(maps) == 1 else f"{maps[0].name} and {len(maps) - 1} more"
    parts = {
        "title": escape(title),
        "generator": f"rsegen {__version__}",
        "css": _source("page.css"),
        "data": _json({"maps": [content(each) for each in maps]}),
        "licence": _source("three.LICENSE"),
        "three": _source("three.min.js"),
        "script": "\n".join(map(_source, _SCRIPTS)),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _source("page.html")).encode()


def _source(name: str) -> str:
    """A file of this folder."""
    return files(__name__).joinpath(name).read_text("utf-8")


def _json(value: object) -> str:
    """JSON of ASCII letters in which no tag of HTML can begin or end."""
    text = json.dumps(value, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
