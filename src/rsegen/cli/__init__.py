"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done, 2 the user's mistake (one line), 1 anything else; of `compare` also that maps differ.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rsegen.cli.commands import COMMANDS, parser
from rsegen.cli.edge import failed, printable_output, short_warnings
from rsegen.cli.plugins import load_plugins
from rsegen.cli.stop import Stop, stoppable
from rsegen.errors import RsegenError

__all__ = ["COMMANDS", "main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; gives the exit code."""
    with stoppable() as stop, short_warnings(), printable_output():
        try:
            return _run(arguments, stop)
        except (KeyboardInterrupt, Exception) as error:
            ours = not isinstance(error, (RsegenError, KeyboardInterrupt, OSError))
            if ours and sys.flags.dev_mode:
                raise
            return failed(KeyboardInterrupt() if ours and stop.happened else error)


def _run(arguments: Sequence[str] | None, stop: Stop) -> int:
    try:
        parsed = parser().parse_args(load_plugins(sys.argv[1:] if arguments is None else arguments))
        stop.heed()
        return int(parsed.run(parsed) or 0)
    finally:
        if sys.stdout:
            sys.stdout.flush()
