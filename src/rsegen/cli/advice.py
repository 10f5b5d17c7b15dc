"""Translate advice in messages: what Python writes as `force=True` is `--force` in a shell.

    force=True                         --force
    tracks='LEFT,RIGHT'                --tracks LEFT,RIGHT
    at=[X, Y, Z]                       --at X,Y,Z
    rsegen.open('DIR', shared=True)    rsegen open DIR --shared

Every message recommends arguments of Python, in one of these forms. The flags are those that the parser of the command
declares, so a new parameter is translated without a word here. What breaks it: a text of a user's that has such a form.
"""

from __future__ import annotations

import re

from rsegen.cli.commands import COMMANDS, parser_of
from rsegen.cli.parser import FLAG

_ARGUMENT = re.compile(r"\b(\w+)=(True\b|'[^']*'|\[[^]]*\])")
_CALL = re.compile(r"\brsegen\.(\w+)\(([^()]*)\)")


def in_flags(message: str, command: str | None = None) -> str:
    """Return a message with the flags of `command` in place of arguments, and command lines in place of calls."""
    called = _CALL.sub(_command_line, message)
    return _with_flags(called, command) if command and command in COMMANDS else called


def _command_line(call: re.Match[str]) -> str:
    """Return the command line of a call; a call of what is no command stays."""
    name, arguments = call[1], call[2]
    if name == "load_plugin":
        return f"{FLAG} {_text(arguments)}"
    if name not in COMMANDS:
        return call[0]
    words = (_with_flags(argument.strip(), name) for argument in arguments.split(","))
    return " ".join(["rsegen", name, *map(_text, words)])


def _with_flags(text: str, command: str) -> str:
    if not _ARGUMENT.search(text):
        return text  # most messages have no advice, and no parser is made for them
    declared = ((getattr(action, "declared", None), action.option_strings) for action in parser_of(command)._actions)
    flags = {parameter.name.strip("_"): names[-1] for parameter, names in declared if parameter and names}

    def flag(argument: re.Match[str]) -> str:
        name, value = argument[1], argument[2]
        if name not in flags:
            return argument[0]
        return flags[name] if value == "True" else f"{flags[name]} {_text(value)}"

    return _ARGUMENT.sub(flag, text)


def _text(value: str) -> str:
    """Return a text, or a list, as a shell has it."""
    return value.strip("'[]").replace(", ", ",")
