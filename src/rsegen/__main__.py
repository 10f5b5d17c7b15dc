"""The command line as a process: from its first line on, before all other imports, a signal ends it in one line.

Python's own start, and the start of this package, take some hundredths of a second before that; nothing can be done
about a Ctrl-C then.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys


def main() -> int:
    """Run the command that this process was started with; gives the exit code."""
    found = [getattr(signal, name) for name in ("SIGINT", "SIGHUP", "SIGTERM") if hasattr(signal, name)]
    heeded = [each for each in found if signal.getsignal(each) is not signal.SIG_IGN]
    _end_when_stopped(heeded, b"rsegen: stopped\n", 1)
    atexit.register(_ignore, heeded)  # the first is called last: Python takes its functions away from signals then
    from rsegen.cli import main as run

    code = 1
    try:
        code = run()
    except SystemExit as done:  # --help
        code = int(done.code or 0)
    except KeyboardInterrupt:  # so late that the command has said all that there is to say
        pass
    finally:
        _end_when_stopped(heeded, b"", code)
    return code


def _end_when_stopped(heeded: list[signal.Signals], words: bytes, code: int) -> None:
    """From now on each of these signals ends the process at once; a command that works heeds them itself."""

    def end(*_: object) -> None:
        if sys.stderr and words:
            os.write(2, words)
        os._exit(code)

    for each in heeded:
        signal.signal(each, end)


def _ignore(heeded: list[signal.Signals]) -> None:
    for each in heeded:
        signal.signal(each, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
