"""The command line as a process: from its first line on, before all other imports, a signal ends it in one line."""

from __future__ import annotations

import os
import signal
import sys


def main() -> int:
    """Run the command that this process was started with; gives the exit code."""
    names = ("SIGINT", "SIGHUP", "SIGTERM")
    found = [getattr(signal, name) for name in names if hasattr(signal, name)]
    heeded = [each for each in found if signal.getsignal(each) is not signal.SIG_IGN]
    for each in heeded:
        signal.signal(each, _end)
    from rsegen.cli import main as run

    try:
        code = run()
        if code > 128:  # by a signal: if it came during an `exec`, CPython would say that it was SIGINT
            os._exit(code)
        return code
    except SystemExit as done:  # --help
        return int(done.code or 0)
    finally:  # what is done is done
        for each in heeded:
            signal.signal(each, signal.SIG_IGN)


def _end(number: int, frame: object) -> None:
    """End the process at once: nothing has been begun."""
    if sys.stderr:
        os.write(2, b"rsegen: stopped\n")
    os._exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
