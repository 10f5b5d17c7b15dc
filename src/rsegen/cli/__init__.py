"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done; 2 the user's mistake, and nothing was changed; 130 stopped by Ctrl-C (else 128 and the number of the
signal); 1 anything else, of `compare` also that maps differ. Each but 0 comes with one line on stderr.
"""

from rsegen.cli.commands import COMMANDS
from rsegen.cli.edge import main

__all__ = ["COMMANDS", "main"]
