"""The help of all commands and kinds of obstacles as one page, which the page links to.

It is made of the parsers and registries that are here, plug-ins included, so it needs no internet and is never older
than the commands. The folder docs of the source has more, and pictures, and is no part of an installed package.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from html import escape
from pathlib import Path

import rsegen
from rsegen.cli.command_line import parsers
from rsegen.cli.reference import run_obstacles
from rsegen.page.shown_map import source_of
from rsegen.params.capabilities import commands

OBSTACLES = "obstacles-list"
"""The anchor of the list of obstacles; those of commands are their names."""


def manual_page() -> str:
    """Return the page as HTML."""
    return "\n".join(_lines())


def _lines() -> Iterator[str]:
    yield '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
    yield f"<title>Manual of rsegen {rsegen.__version__}</title><style>{source_of('page.min.css')}</style></head>"
    yield f'<body><main class="manual"><h1>Commands and obstacles of rsegen {rsegen.__version__}</h1>'
    yield f"<p>{_whole()}</p><nav>"
    for group in dict.fromkeys(command.group for command in commands().values()):
        own = [command for command in commands().values() if command.group == group]
        yield f"<h3>{escape(group)}</h3><ul>"
        yield from (f"<li>{_link(command.name)} {escape(command.help)}</li>" for command in own)
        yield "</ul>"
    yield f'<h3>obstacles</h3><ul><li><a href="#{OBSTACLES}">all kinds</a> with their parameters</li></ul></nav>'
    for name, parser in parsers():
        yield _section(name, f"rsegen {name}", parser.format_help())
    yield _section(OBSTACLES, "Obstacles", "\n".join(run_obstacles(argparse.Namespace(kind=None)).lines))
    yield "</main></body></html>"


def _whole() -> str:
    """Return where the manual with its pictures is, as HTML: here, if rsegen runs from its source."""
    index = Path(rsegen.__file__).parents[2] / "docs" / "index.md"
    place = f": <code>{escape(str(index))}</code>" if index.is_file() else ""
    return f"The whole manual, with pictures, is the folder docs of rsegen's source{place}."


def _link(name: str) -> str:
    return f'<a href="#{escape(name)}">{escape(name)}</a>'


def _section(anchor: str, title: str, text: str) -> str:
    return f'<section id="{escape(anchor)}"><h2>{escape(title)}</h2><pre tabindex="0">{escape(text)}</pre></section>'
