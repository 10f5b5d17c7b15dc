"""The command line as a process: from its first line on, before all other imports, a signal ends it in one line.

Imports take tenths of a second, in which Python would answer Ctrl-C with a traceback. Until the command has set its own
handlers, a signal ends the process at once, as nothing has been begun; after the command it is ignored, as all is done.
"""

from __future__ import annotations

import os
import signal
import sys


def main() -> int:
    """Run the command that this process was started with; gives the exit code."""
    names = ("SIGINT", "SIGHUP", "SIGTERM")
    known = [getattr(signal, name) for name in names if hasattr(signal, name)]  # Windows has no SIGHUP
    stop_signals = [code for code in known if signal.getsignal(code) is not signal.SIG_IGN]  # nohup ignores SIGHUP
    for stop_signal in stop_signals:
        signal.signal(stop_signal, _end)
    from rsegen.cli.edge import main as run

    try:
        code = run()
        if code > 128:  # by a signal: if it came during an `exec`, CPython would say that it was SIGINT
            os._exit(code)
        return code
    except SystemExit as done:  # --help
        return int(done.code or 0)
    finally:  # what is done is done
        for stop_signal in stop_signals:
            signal.signal(stop_signal, signal.SIG_IGN)


def _end(number: int, frame: object) -> None:
    """End the process at once: nothing has been begun."""
    if sys.stderr:
        os.write(2, b"rsegen: stopped\n")
    os._exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
