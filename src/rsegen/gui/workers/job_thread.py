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

    def run(self) -> None:
        """Run the job; called by Qt in the thread."""
        step = _Step(self)
        try:
            self.succeeded.emit(self.job.run(step, force=self._force))
        except _Cancelled:
            self.cancelled.emit(self.job.cancelled(step.done))
        except Exception as error:  # also a library's: whoever waits for the files sees it
            self.failed.emit(failure_text(error))


class _Step:
    """Counts the steps of a thread's job, and cancels it at the next one, or while one lasts."""

    def __init__(self, thread: JobThread) -> None:
        self._thread = thread
        self.done = 0

    def __call__(self, _: object = None, /) -> None:
        """Count a step; a job that is complete is not cancelled."""
        self.done += 1
        self._thread.progressed.emit(self.done)
        if self.done < self._thread.job.steps:
            self.check()

    def check(self) -> None:
        """Raise if the job is to be cancelled."""
        if self._thread.isInterruptionRequested():
            raise _Cancelled


class _Cancelled(Exception):
    """The user pressed Cancel."""
