"""A parser of flags that refuses in one short line, and whose help is made only when it is asked for."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, NoReturn

from rsegen.cli.plugins import add_plugin_flag
from rsegen.errors import UnknownName, line_of, nearest, shown


class HelpRow(NamedTuple):
    """A name with its explanation, in a group of the help that is there to be read only."""

    name: str
    help: str


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, with the nearest flag or command, and takes flags in full only."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_Help, **options)
        self._rows: list[tuple[str, Callable[[], Iterable[HelpRow]]]] = []
        add_plugin_flag(self)

    def add_rows(self, title: str, rows: Callable[[], Iterable[HelpRow]]) -> None:
        """Add a group of names to the help; `rows` is called when the help is shown."""
        self._rows.append((title, rows))

    def format_help(self) -> str:
        """Return the help: how to call it, the groups of flags, the names, and the options of all commands last."""
        formatter = self._get_formatter()
        self._add_usage(formatter)
        formatter.add_text(self.description)
        positionals, options, *groups = self._action_groups
        flags = [(group.title, group.description, group._group_actions) for group in (positionals, *groups)]
        names = [(title, None, list(map(_action, rows()))) for title, rows in self._rows]
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
        parsed, unknown = super().parse_known_args(args, namespace)
        for text in unknown[:1]:
            if text.startswith("-"):
                name = text.partition("=")[0]
                flags = [flag for action in self._actions for flag in action.option_strings]
                self.error(f"unknown flag {shown(name)}{nearest(name, flags)}")
            self.error(f"unexpected argument {shown(text)}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            self.error(str(UnknownName.among("", "command", value, action.choices)))


def _action(row: HelpRow) -> argparse.Action:
    """Return a row of the help as argparse lays it out, though it is no argument."""
    return argparse.Action([], row.name, metavar=row.name, help=row.help.replace("%", "%%"))


class _Help(argparse.HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=26)
