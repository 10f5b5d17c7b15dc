"""The command `rsegen gui`, which opens the window."""

from __future__ import annotations

import argparse
import os
import sys

from rsegen.cli.flags import add_target_recipe_flags, has_recipe_flags, recipe_from
from rsegen.cli.report import Subparsers, add_command
from rsegen.errors import FileError, pip_install
from rsegen.params.extras import GUI


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = add_command(
        commands, "gui", text="Open a window in which maps are edited with the mouse. Needs rsegen[gui]."
    )
    where = "YAML or JSON file, the name of an example, a data set, or one of its maps as DIR#17"
    command.add_argument("recipe", nargs="?", metavar="RECIPE-or-DIR", help=where)
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Open the window, and end the program when it is closed."""
    try:
        from rsegen.gui.application import run as run_window
    except ImportError as error:
        raise FileError(f"gui: the window cannot be opened ({error}); {pip_install([GUI.name])}") from None
    if sys.platform == "linux" and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"))):
        raise FileError("gui: there is no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set)")
    if has_recipe_flags(arguments):
        sys.exit(run_window(recipe_from(arguments)))
    from rsegen.recipe.examples import or_example

    sys.exit(run_window(or_example(arguments.recipe) if arguments.recipe else None))
