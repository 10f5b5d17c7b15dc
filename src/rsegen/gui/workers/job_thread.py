"""A job in a thread of its own: the window stays responsive, and the job can be cancelled between two steps."""

from __future__ import annotations

from PySide6.QtCore import QThread, Signal

from rsegen.gui.model.jobs import Job
from rsegen.gui.workers.latest_only import failure_text


class JobThread(QThread):
    """Runs one job once: `progressed` gives the number of steps done, the other signals give the final message."""

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
        """Run the job; called by Qt in the thread."""
        try:
            self.succeeded.emit(self.job.run(self._step, force=self._force))
        except _Cancelled:
            self.cancelled.emit(self.job.cancelled(self._done))
        except Exception as error:  # also a library's: whoever waits for the files sees it
            self.failed.emit(failure_text(error))

    def _step(self, _: object) -> None:
        self._done += 1
        self.progressed.emit(self._done)
        if self.isInterruptionRequested() and self._done < self.job.steps:
            raise _Cancelled


class _Cancelled(Exception):
    """The user pressed Cancel."""
