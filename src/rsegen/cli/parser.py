"""The parser of a command, which refuses in one short line and gives what its help, a shell and a form show of it."""

from __future__ import annotations

import argparse
import os
import re
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import takewhile
from typing import TYPE_CHECKING, Any, NoReturn

from rsegen.errors import did_you_mean, line_of, shown

if TYPE_CHECKING:
    from rsegen.params.command import HelpText

FLAG = "--plugin"
VARIABLE = "RSEGEN_PLUGINS"
"""Environment variable with the plug-ins of every command, separated like PATH."""


_HELP = partial(argparse.HelpFormatter, max_help_position=26)
"""The layout of help: `argparse` leaves two columns less for flags, and breaks the line of more of them."""


class Group:
    """Flags under a title of the help; of those that exclude each other the help says what must be given."""

    def __init__(self, title: str, text: str | None, into: Any, whole: Group | None = None) -> None:
        self.title, self.text = title, text
        self.actions: list[argparse.Action] = []
        self._whole = whole
        self.exclusive: list[tuple[Any, list[argparse.Action]]] = []
        self._into = into

    def add_argument(self, *names: str, **options: Any) -> argparse.Action:
        """Add a flag or an argument, as `argparse` takes it."""
        action: argparse.Action = self._into.add_argument(*names, **options)
        for group in filter(None, (self, self._whole)):
            group.actions.append(action)
        return action

    def one_of(self) -> Group:
        """Return a part of this group, of whose flags one must be given."""
        real = self._into.add_mutually_exclusive_group(required=True)
        part = Group(self.title, None, real, self)
        self.exclusive.append((real, part.actions))
        return part


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, with the nearest flag or command, and takes flags in full only.

    groups: flags under titles; of its own it has arguments, and options that all commands have
    """

    def __init__(self, **options: Any) -> None:
        self.groups: list[Group] = []
        self._own: list[argparse.Action] = []
        self._rows: list[tuple[str, Callable[[], Iterable[tuple[str, str]]]]] = []
        self._paragraphs: list[HelpText] = []
        self._more: Callable[[], str] = str
        super().__init__(allow_abbrev=False, formatter_class=_HELP, **options)
        # As Python has it from 3.14 on: what begins with a negative number is no flag, such as -1,0 and -1e-3.
        self._negative_number_matcher = re.compile(r"-\.?\d")
        text = f"load obstacles, formats, ... from file.py or a module, may be repeated (or set {VARIABLE})"
        self.add_argument(FLAG, metavar="MODULE", help=text)  # for --help; `load_plugins` has read it before

    def add_argument(self, *names: Any, **options: Any) -> argparse.Action:
        """Add an argument, or an option, to no group."""
        action = super().add_argument(*names, **options)
        self._own.append(action)
        return action

    def group(self, title: str, text: str | None = None) -> Group:
        """Add a group of flags."""
        self.groups.append(Group(title, text, self.add_argument_group(title, text)))
        return self.groups[-1]

    @property
    def actions(self) -> list[argparse.Action]:
        """Arguments and flags of the command, as `argparse` has them."""
        return [*self._own, *(action for group in self.groups for action in group.actions)]

    @property
    def flags(self) -> Mapping[str, argparse.Action]:
        """The action of every flag, by the flag."""
        return {flag: action for action in self.actions for flag in action.option_strings}

    def explain(self, text: str | None, epilog: str = "", more: Callable[[], str] = str) -> None:
        """Set what the help says first, which is the first line of a docstring, and what it says last.

        more: the rest of the epilog, made only if the help is shown
        """
        self.description, self.epilog, self._more = (text or "").partition("\n")[0], epilog, more

    def add_rows(self, title: str, rows: Callable[[], Iterable[tuple[str, str]]]) -> None:
        """Add a group of names, each with its explanation, to the help; `rows` is called when the help is shown."""
        self._rows.append((title, rows))

    def add_paragraph(self, title: str, text: Callable[[], str]) -> None:
        """Add a text under a title to the help; `text` is called when the help is shown."""
        self._paragraphs.append((title, text))

    def describe_flags(self) -> None:
        """Give the flags of declared parameters what help, shells and forms show of them, and parsing does not need."""
        for action in self.actions:
            if parameter := getattr(action, "declared", None):
                _describe(action, parameter)

    def format_help(self) -> str:
        """Return the help: how to call it, the groups of flags, the names, and the options of all commands last."""
        self.describe_flags()
        formatter = self.formatter_class(prog=self.prog)
        self._add_usage(formatter)
        formatter.add_text(self.description)
        arguments = [action for action in self._own if not action.option_strings]
        options = [action for action in self._own if action.option_strings]
        groups = [(group.title, group.text, group.actions) for group in self.groups]
        # The order that argparse has not: positional arguments, groups, rows laid out as arguments are, then options.
        names = [(title, None, [_row(*row) for row in rows()]) for title, rows in self._rows]
        for title, text, actions in [
            ("positional arguments", None, arguments),
            *groups,
            *names,
            *[(title, text(), []) for title, text in self._paragraphs],
            ("options", None, options),
        ]:
            formatter.start_section(title)
            formatter.add_text(text)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(" ".join(filter(None, (self.epilog, self._more()))))
        return formatter.format_help()

    def print_help(self, file: Any = None) -> None:
        """Print the help; argparse would not say that the output is full, if the help is longer than a buffer."""
        print(self.format_help(), end="", file=file)

    def _add_usage(self, formatter: argparse.HelpFormatter) -> None:
        """Add what must be given; of all the rest, that there is more."""
        exclusive = [pair for group in self.groups for pair in group.exclusive]
        either = [action for _, actions in exclusive for action in actions]
        needed = [action for action in self.actions if action.required or not action.option_strings]
        options = argparse.Action([], "options", nargs="?", metavar="options")
        formatter.add_usage(self.usage, [*either, *needed, options], [real for real, _ in exclusive])

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: error: {line_of(message)} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse what is unknown in the parser of the command itself, which has the flags to compare it with."""
        for obstacle in _unquoted(args or ()) if "--obstacle" in self.flags else ():
            self.error(f"put quotes around the obstacle: --obstacle {obstacle}")
        known, unknown = super().parse_known_args(args, namespace)
        for text in unknown[:1]:
            if text.startswith("-"):
                name = text.partition("=")[0]
                self.error(f"unknown flag {shown(name)}{self._stands_alone(name) or did_you_mean(name, self.flags)}")
            self.error(f"unexpected argument {shown(text)}")
        for action in self.actions:
            if problem := _problem_of_output(action, getattr(known, action.dest, None)):
                self.error(f"{'/'.join(action.option_strings)}: {problem}")
        return known, unknown

    def _stands_alone(self, flag: str) -> str:
        """Return that what a flag means stands without one in this command, in words; an empty text if it does not."""
        for action in self.actions:
            place = str(action.metavar or action.dest)
            if not action.option_strings and flag.removeprefix("--") in re.split(
                "[^a-z]+", f"{place} {action.dest}".lower()
            ):
                return f"; {place} stands without a flag here"
        return ""


def _problem_of_output(action: argparse.Action, value: object) -> str:
    """Return why a flag that names a file or folder to write cannot have a value; an empty text if it can."""
    parameter = getattr(action, "declared", None)
    metavar = parameter.metavar if parameter else action.metavar
    is_file = metavar in ("FILE", "PICTURE")
    if value == "-" and "--output" in action.option_strings:
        return f"nothing is written to the standard output; use the name of a {'file' if is_file else 'folder'}"
    if is_file and isinstance(value, str) and value.endswith(("/", os.sep)):
        return f"{shown(value)} names a folder; use the name of a file"
    return ""


def _describe(action: Any, parameter: Any) -> None:
    """Give the action of a declared parameter the help and metavar that it lacks."""
    if action.help is None:
        action.help = parameter.help.replace("%", "%%")
    if action.metavar is None and action.nargs != 0:
        action.metavar = parameter.metavar


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
