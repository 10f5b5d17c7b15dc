"""The parser of the command line, which refuses in one short line.

Its commands are those that capabilities declare (`params/capabilities.py`). Help is made only when it is asked for, and
a command's module is imported when the command is named. Plug-ins are loaded before the command line is parsed, as they
may add to what it takes.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from importlib import import_module
from itertools import takewhile
from typing import Any, NoReturn

from rsegen import __version__
from rsegen.errors import UnknownName, did_you_mean, line_of, shown
from rsegen.params.capabilities import commands


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]  # argparse has no public name for it
    """The commands, of which the module of the named one adds its parser, and no other."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.choices = {name: command.help for name, command in commands().items()}

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: Any = None) -> None:
        self.add(values[0])
        super().__call__(parser, namespace, values, option_string)

    def add(self, name: str) -> Parser:
        """Return the parser of a command, with the function that runs it; add it if it is not there yet."""
        if name not in self._name_parser_map:
            module, command = import_module(commands()[name].module), self.add_parser(name)
            import_module("rsegen.cli.report").add_shared_flags(command, getattr(module, f"add_{name}"))
            command.set_defaults(run=getattr(module, f"run_{name}"))
        made: Parser = self._name_parser_map[name]
        return made


def parser() -> Parser:
    """Return the parser of the whole command line."""
    top = Parser(
        prog="rsegen",
        usage="rsegen COMMAND [options]",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random levels=5' -o worlds",
    )
    top.add_argument("-V", "--version", action="version", version=f"rsegen {__version__}")
    top.commands = top.add_subparsers(  # type: ignore[assignment]  # typeshed gives its base
        action=_Commands, prog="rsegen", metavar="COMMAND", help=argparse.SUPPRESS
    )
    for title in dict.fromkeys(command.group for command in commands().values()):
        top.add_rows(title, partial(_rows_of, title))
    return top


def _rows_of(title: str) -> list[tuple[str, str]]:
    return [(command.name, command.help) for command in commands().values() if command.group == title]


def parser_of(command: str) -> Parser:
    """Return the parser of one command."""
    return parser().commands.add(command)


OVERVIEW = """\
rsegen makes Random Step Environments (NIST stepfields) as worlds and models for robot simulators.

  rsegen generate --obstacle 'random levels=5' -o worlds   make a world
  rsegen open worlds/rse_0000                              open it in Gazebo
  rsegen examples                                          list recipes to start from
  rsegen gui                                               shape a map with the mouse
  rsegen --help                                            list all commands
"""
"""What `rsegen` alone prints."""


def complete(top: Parser) -> None:
    """Answer a shell that asks what may follow, and end; return if none asks (`_ARGCOMPLETE` is argcomplete's own)."""
    if "_ARGCOMPLETE" not in os.environ:
        return
    import argcomplete

    parsers = top.commands
    words = os.environ.get("COMP_LINE", "").split()[1:]
    named = next((word for word in words if word in commands()), None)
    if named:
        parsers.add(named)
    for name in commands():  # argcomplete looks into each parser
        if name not in parsers._name_parser_map:
            parsers._name_parser_map[name] = Parser(prog=f"rsegen {name}")
    parsers.choices = parsers._name_parser_map
    argcomplete.autocomplete(top, always_complete_options="long")


FLAG = "--plugin"
VARIABLE = "RSEGEN_PLUGINS"
"""Of the environment: the same for every command, separated like PATH."""


def load_plugins(arguments: Sequence[str]) -> list[str]:
    """Load the plug-ins that the environment and the arguments name; gives the arguments without them."""
    rest, named = _parted(arguments)
    for name in (*filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)), *named):
        from rsegen.params.plugins import load_plugin

        load_plugin(name)
    return rest


def _parted(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments without `--plugin MODULE`, and the modules; what follows `--` is left alone."""
    rest: list[str] = []
    named: list[str] = []
    waiting = list(arguments)
    while waiting:
        part = waiting.pop(0)
        if part == "--":
            return [*rest, part, *waiting], named
        if part == FLAG and waiting:
            named.append(waiting.pop(0))
        elif part.startswith(f"{FLAG}="):
            named.append(part.partition("=")[2])
        else:
            rest.append(part)
    return rest, named


_HELP = partial(argparse.HelpFormatter, max_help_position=26)
"""The layout of help: `argparse` leaves two columns less for flags, and breaks the line of more of them."""


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, with the nearest flag or command, and takes flags in full only."""

    commands: _Commands

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_HELP, **options)
        self._rows: list[tuple[str, Callable[[], Iterable[tuple[str, str]]]]] = []
        text = f"load obstacles, formats, ... from file.py or a module, may be repeated (or set {VARIABLE})"
        self.add_argument(FLAG, metavar="MODULE", help=text)  # for --help; `load_plugins` has read it before

    def explain(self, text: str | None, epilog: str = "") -> None:
        """Set what the help says first, which is the first line of a docstring, and what it says last."""
        self.description, self.epilog = (text or "").partition("\n")[0], epilog

    def add_rows(self, title: str, rows: Callable[[], Iterable[tuple[str, str]]]) -> None:
        """Add a group of names, each with its explanation, to the help; `rows` is called when the help is shown."""
        self._rows.append((title, rows))

    def format_help(self) -> str:
        """Return the help: how to call it, the groups of flags, the names, and the options of all commands last."""
        formatter = self._get_formatter()
        self._add_usage(formatter)
        formatter.add_text(self.description)
        positionals, options, *groups = self._action_groups
        flags = [(group.title, group.description, group._group_actions) for group in (positionals, *groups)]
        # Rows are laid out as arguments are.
        names = [(title, None, [_row(*row) for row in rows()]) for title, rows in self._rows]
        for title, text, actions in [*flags, *names, (options.title, None, options._group_actions)]:
            formatter.start_section(title)
            formatter.add_text(text)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()

    def _add_usage(self, formatter: argparse.HelpFormatter) -> None:
        """Add what must be given; of all the rest, that there is more."""
        groups = [group for group in self._mutually_exclusive_groups if group.required]
        either = [action for group in groups for action in group._group_actions]
        needed = [action for action in self._actions if action.required or not action.option_strings]
        options = argparse.Action([], "options", nargs="?", metavar="options")
        formatter.add_usage(self.usage, [*either, *needed, options], groups)

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: error: {line_of(message)} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse what is unknown in the parser of the command itself, which has the flags to compare it with."""
        for obstacle in _unquoted(args or ()) if "--obstacle" in self._option_string_actions else ():
            self.error(f"put quotes around the obstacle: --obstacle {obstacle}")
        parsed, unknown = super().parse_known_args(args, namespace)
        for text in unknown[:1]:
            if text.startswith("-"):
                name = text.partition("=")[0]
                flags = [flag for action in self._actions for flag in action.option_strings]
                self.error(f"unknown flag {shown(name)}{did_you_mean(name, flags)}")
            self.error(f"unexpected argument {shown(text)}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            self.error(str(UnknownName.among("", "command", value, action.choices)))


def _row(name: str, text: str) -> argparse.Action:
    """Return a row of the help as argparse lays it out, though it is no argument."""
    return argparse.Action([], name, metavar=name, help=text.replace("%", "%%"))


def _unquoted(arguments: Sequence[str]) -> Iterator[str]:
    """Yield, in quotes, each obstacle that a shell split into words, as in `--obstacle peak levels=5`."""

    def is_pair(word: str) -> bool:  # a parameter of an obstacle, and no file of that name
        return bool(re.match("[a-z_]+=", word)) and not os.path.lexists(word)

    words = [part for word in arguments for part in re.split("(?<=^--obstacle)=", word, maxsplit=1)]
    for place, word in enumerate(words):
        if word == "--obstacle" and (pairs := [*takewhile(is_pair, words[place + 2 :])]):
            yield shlex.quote(" ".join([words[place + 1], *pairs]))
