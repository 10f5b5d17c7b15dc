"""Writing behind the window: it never freezes, and can be cancelled between two steps."""

from __future__ import annotations

from PySide6.QtCore import QThread, Signal

from rsegen.errors import RsegenError
from rsegen.gui.jobs import Job


class Run(QThread):
    """One job, once: `progressed` counts its steps, the others tell what came of it."""

    progressed = Signal(int)
    succeeded = Signal(str)
    cancelled = Signal(str)
    failed = Signal(str)

    def __init__(self, job: Job, *, force: bool) -> None:
        super().__init__()
        self.job = job
        self._force = force
        self._done = 0

    def run(self) -> None:
        """In a thread of its own."""
        try:
            self.succeeded.emit(self.job.carried_out(self._step, force=self._force))
        except _Cancelled:
            self.cancelled.emit(self.job.stopped(self._done))
        except RsegenError as error:
            self.failed.emit(str(error))
        except Exception as error:  # such as a library's: whoever waits for the files hears of it
            self.failed.emit(f"it failed: {error!r}")

    def _step(self, _: object) -> None:
        self._done += 1
        self.progressed.emit(self._done)
        if self.isInterruptionRequested() and self._done < self.job.steps:
            raise _Cancelled


class _Cancelled(Exception):
    """A person has had enough."""
