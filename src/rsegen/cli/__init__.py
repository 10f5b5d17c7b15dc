"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done, 2 the user's mistake (one line), 1 anything else.
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from rsegen.cli import generate, info, obstacles, preview, schema
from rsegen.errors import RsegenError, UserError
from rsegen.version import __version__

COMMANDS = (generate, preview, info, obstacles, schema)


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, and takes flags in full only."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_Help, **options)

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; gives the exit code."""
    signal.signal(signal.SIGTERM, _stop)
    parsed = parser().parse_args(arguments)
    try:
        parsed.run(parsed)
        sys.stdout.flush()
    except UserError as error:
        return _failed(2, str(error))
    except RsegenError as error:
        return _failed(1, str(error))
    except KeyboardInterrupt:
        return _failed(1, "stopped; the maps that were complete are there, nothing else is")
    except BrokenPipeError:
        sys.stderr.close()
        return 1
    return 0


def parser() -> Parser:
    """The parser of every command."""
    top = Parser(
        prog="rsegen",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random max_height=5' -o worlds",
    )
    top.add_argument("--version", action="version", version=f"rsegen {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add(commands)
    return top


class _Help(argparse.HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=26)


def _stop(signal_: int, frame: object) -> NoReturn:
    """A polite end (kill, shutdown) is taken as Ctrl-C: what is half written goes."""
    raise KeyboardInterrupt


def _failed(code: int, message: str) -> int:
    print(f"rsegen: {' '.join(message.split())}", file=sys.stderr)
    return code
