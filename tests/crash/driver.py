"""Runs commands of rsegen as children of one process that has everything imported, each below inject.c.

    request: a line of JSON --> fork --> rsegen.__main__.main() below inject.c --> answer: a line of JSON

A start of Python and numpy takes longer than most of the runs; a fork of a process that has them takes milliseconds.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import gc
import importlib
import json
import os
import pkgutil
import re
import signal
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from tests.crash.injection import Control, Injection, mapped_control

CONTROL = "RSEGEN_CRASH_CONTROL"
_LONGEST = 600
_PR_SET_CHILD_SUBREAPER = 36
_LEFT_OUT = re.compile(
    r"rsegen\.(__main__|learning(?!\.commands)|mujoco\.(kernels|many_worlds|many_maps)|training)\b"
).match
"""Modules that no command of the trials needs, with PyTorch and Warp."""
_HEAVY = (
    *(f"matplotlib.backends.backend_{name}" for name in ("agg", "pdf", "svg")),
    *("matplotlib.figure", "mpl_toolkits.mplot3d", "PIL.PngImagePlugin", "tqdm", "multiprocessing.spawn"),
)
"""Modules that functions import when they are called."""


class _Child:
    """A command that runs: the main process of a group of its own."""

    def __init__(self, arguments: list[str], folder: str, said: str, control: Control | None) -> None:
        self._said = said
        self.code: int | None = None
        self.signal = 0
        self.stopped = False
        sys.stdout.flush()
        self.pid = os.fork()
        if not self.pid:
            _become(arguments, folder, said, control)
        with contextlib.suppress(OSError):  # the child does it too: whoever is first
            os.setpgid(self.pid, self.pid)

    def wait(self) -> dict[str, Any]:
        """Wait until the command has ended, with all of its processes, or is stopped; gives how."""
        end, self.stopped = time.monotonic() + _LONGEST, False
        while self._lives() and not self.stopped:
            if time.monotonic() > end:
                os.killpg(self.pid, signal.SIGKILL)
                self.signal = -1
            time.sleep(0.002)
        err = Path(self._said).read_text("utf-8", "replace")
        return {"code": self.code, "signal": self.signal, "stopped": self.stopped, "err": err}

    def go_on(self) -> None:
        """Wake it up after it was stopped."""
        os.killpg(self.pid, signal.SIGCONT)

    def _lives(self) -> bool:
        """Return whether a process of the group is left; all that end become children of this process."""
        with contextlib.suppress(ChildProcessError):
            while True:
                pid, status = os.waitpid(-self.pid, os.WNOHANG | os.WUNTRACED)
                if not pid:
                    return True
                if pid == self.pid and os.WIFSTOPPED(status):
                    self.stopped = True
                elif pid == self.pid and os.WIFSIGNALED(status):
                    self.signal = self.signal or os.WTERMSIG(status)
                elif pid == self.pid:
                    self.code = os.WEXITSTATUS(status)
        return False


class _InChild(Exception):
    """Raised in a child, to leave all of the driver's functions behind."""


def _become(arguments: list[str], folder: str, said: str, control: Control | None) -> NoReturn:
    """In a child: be the process of a command, counted from now on."""
    os.setpgid(0, 0)
    nothing = os.open(os.devnull, os.O_RDWR)
    err = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    for descriptor, stream in ((nothing, 0), (nothing, 1), (err, 2)):
        os.dup2(descriptor, stream)
    os.close(nothing)
    os.close(err)
    os.chdir(folder)
    sys.argv = ["rsegen", *arguments]
    sys.modules["__main__"].__spec__ = find_spec("rsegen.__main__")  # what workers of multiprocessing import
    if control is not None:
        control.main = os.getpid()
        control.group = os.getpid()
    raise _InChild


def _answers(control: Control) -> None:
    """Answer requests until there are no more."""
    held: _Child | None = None
    for line in sys.stdin:
        request = json.loads(line)
        answer: dict[str, Any] = {}
        match request["what"]:
            case "start":
                Injection(**request["injection"]).set(control, request["root"])
                held = _Child(request["arguments"], request["folder"], request["said"], control)
                answer = held.wait() | _counted(control)
            case "second":
                second = _Child(request["arguments"], request["folder"], request["said"] + ".second", None)
                answer = second.wait()
            case "continue" if held:
                held.go_on()
                answer = held.wait() | _counted(control)
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


def _counted(control: Control) -> dict[str, Any]:
    lost = [(file.inode, file.size) for file in control.unsynced[: control.files]]
    call = f"{os.fsdecode(control.call)} {os.fsdecode(control.path).removeprefix(os.fsdecode(control.root))}"
    return {"calls": control.calls, "by_workers": control.by_workers, "call": call.strip(), "unsynced": lost}


def _run() -> int:
    """Be the driver, and in its children the command."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    _imported()
    try:
        _answers(mapped_control(os.environ[CONTROL]))
    except _InChild:
        pass
    else:
        return 0
    sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115  # it is as long as the process
    from rsegen.__main__ import main

    code = main()
    atexit._run_exitfuncs()
    sys.stderr.flush()
    os._exit(code)  # Python itself would free all that is imported first, for 0.1 s


def _imported() -> None:
    """Import what the commands need, in so far as it is here."""
    import rsegen

    found = [module.name for module in pkgutil.walk_packages(rsegen.__path__, "rsegen.") if not _LEFT_OUT(module.name)]
    for name in (*found, *_HEAVY):
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    gc.freeze()


if __name__ == "__main__":
    sys.exit(_run())
