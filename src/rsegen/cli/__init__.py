"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done, 2 the user's mistake (one line), 1 anything else.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence

from rsegen.cli.commands import COMMANDS, parser
from rsegen.cli.edge import failed, short_warnings, stoppable
from rsegen.cli.plugins import load_plugins
from rsegen.errors import RsegenError

__all__ = ["COMMANDS", "main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; gives the exit code."""
    with stoppable(), short_warnings():
        try:
            return _run(arguments)
        except (KeyboardInterrupt, Exception) as error:
            if sys.flags.dev_mode and not isinstance(error, (RsegenError, KeyboardInterrupt, OSError)):
                raise
            return failed(error)


def _run(arguments: Sequence[str] | None) -> int:
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # a folder may have a name that cannot be printed
    try:
        parsed = parser().parse_args(load_plugins(sys.argv[1:] if arguments is None else arguments))
        parsed.run(parsed)
        return 0
    finally:
        if sys.stdout:
            sys.stdout.flush()
