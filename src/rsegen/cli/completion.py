"""Answers to a shell that asks at Tab what may follow: commands, flags, known words, and files.

    rsegen drive --robot j  ->  jackal        rsegen export x --to stl,m  ->  stl,mjcf

The shell asks argcomplete, and that each action of the parser. Files are offered with the words wherever one may be
named, as only bash looks for files by itself if there are no words.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from typing import Any

from rsegen.cli.command_line import load_plugins, parser, parser_of
from rsegen.cli.parser import Parser
from rsegen.errors import RsegenError
from rsegen.params.capabilities import commands, known_words
from rsegen.params.sorts import ListOf


def complete() -> None:
    """Answer a shell that asks what may follow, and end."""
    import argcomplete

    words = os.environ.get("COMP_LINE", "").split()[1:]
    with suppress(RsegenError):  # the command itself says why a plug-in cannot be loaded
        load_plugins(words)
    top, named = parser(), next((word for word in words if word in commands()), None)
    parsers = top.add_subparsers(parser_class=Parser)
    for name in commands():  # argcomplete looks into each parser
        empty = parsers.add_parser(name)
        if name == named:
            of_command = parser_of(name, empty)
            of_command.describe_flags()
            for action in of_command.actions:
                _give_completer(action)
    argcomplete.autocomplete(top, always_complete_options="long")


def _give_completer(action: Any) -> None:
    """Let an action complete the words that it knows, its own or those that a capability declares for its name."""
    if hasattr(action, "words"):
        action.completer = partial(_words_and_files, action.words)
    elif not hasattr(action, "completer") and (words := _words_of(action)) is not None:
        action.completer = words


def _words_of(action: Any) -> Callable[..., Iterable[str]] | None:
    """Return the completer of an action by its declaration; None if nothing is known of it, so that it takes files."""
    parameter = getattr(action, "declared", None)
    if parameter is not None:
        is_list = isinstance(parameter.sort, ListOf)
        element = parameter._replace(sort=parameter.sort.sort) if is_list else parameter
        known = parameter.shell.known or element.known_names
        if known or element.words:
            return partial(_parts_of_list if is_list else _only_words, known or (lambda: element.words))
    known = known_words().get(action.dest)
    if known is None:
        return None
    is_list = parameter is not None and parameter.sort.schema().get("type") == "array"
    return partial(_parts_of_list if is_list else _words_and_files, known)


def _only_words(words: Callable[[], Iterable[str]], **_: object) -> Iterable[str]:
    return words()


def _parts_of_list(words: Callable[[], Iterable[str]], *, prefix: str, **_: object) -> Iterable[str]:
    head = prefix[: prefix.rfind(",") + 1]
    return [head + word for word in words()]


def _words_and_files(words: Callable[[], Iterable[str]], *, prefix: str, **_: object) -> Iterable[str]:
    from argcomplete.completers import FilesCompleter

    return [*words(), *FilesCompleter()(prefix)]
