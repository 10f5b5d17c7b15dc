"""--plugin MODULE: files and modules that are loaded before the command line is parsed, as they add flags to it."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

FLAG = "--plugin"
VARIABLE = "RSEGEN_PLUGINS"
"""Of the environment: the same for every command, separated like PATH."""


def add_plugin_flag(command: argparse.ArgumentParser) -> None:
    """The flag, for --help; `load_plugins` has read it before."""
    text = f"load obstacles, formats, ... from file.py or a module, may be repeated (or set {VARIABLE})"
    command.add_argument(FLAG, metavar="MODULE", help=text)


def load_plugins(arguments: Sequence[str]) -> list[str]:
    """Load the plug-ins that the environment and the arguments name; gives the arguments without them."""
    rest, named = _parted(arguments)
    for name in (*filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)), *named):
        from rsegen.params.plugins import load_plugin

        load_plugin(name)
    return rest


def _parted(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """The arguments without `--plugin MODULE`, and the modules; what follows `--` is left alone."""
    rest: list[str] = []
    named: list[str] = []
    waiting = list(arguments)
    while waiting:
        each = waiting.pop(0)
        if each == "--":
            return [*rest, each, *waiting], named
        if each == FLAG and waiting:
            named.append(waiting.pop(0))
        elif each.startswith(f"{FLAG}="):
            named.append(each.partition("=")[2])
        else:
            rest.append(each)
    return rest, named
