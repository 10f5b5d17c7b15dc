"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done; 2 the user's mistake, and nothing was changed; 130 stopped by Ctrl-C (else 128 and the number of the
signal); 1 anything else, of `compare` also that maps differ. Each but 0 comes with one line on stderr.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rsegen.cli.bar import quiet
from rsegen.cli.commands import COMMANDS, OVERVIEW, complete, parser
from rsegen.cli.edge import failed, printable_output, short_warnings
from rsegen.cli.plugins import load_plugins
from rsegen.cli.stop import Signals
from rsegen.errors import RsegenError

__all__ = ["COMMANDS", "main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, and return the exit code."""
    signals = Signals()
    with short_warnings(), printable_output():
        try:
            return _run(arguments, signals)
        except (KeyboardInterrupt, Exception) as error:
            ours = not isinstance(error, (RsegenError, KeyboardInterrupt, OSError))
            if ours and sys.flags.dev_mode:
                raise
            return failed(error, signals.number)


def _run(arguments: Sequence[str] | None, signals: Signals) -> int:
    try:
        top = parser()
        complete(top)
        parsed = top.parse_args(load_plugins(sys.argv[1:] if arguments is None else arguments))
        if not hasattr(parsed, "run"):
            print(OVERVIEW, end="")
            return 0
        with signals.stop_it(), quiet(is_asked_for=parsed.quiet):
            outcome = parsed.run(parsed)
            return outcome.show(parsed) if outcome else 0
    finally:
        if sys.stdout:
            sys.stdout.flush()
