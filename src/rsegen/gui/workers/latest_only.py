"""A worker thread that keeps only the latest task: a preview that is already out of date is not computed."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

from PySide6.QtCore import QObject, Signal, Slot

from rsegen.errors import RsegenError

Task = Callable[[], object]


class LatestOnly(QObject):
    """Runs one task at a time in a thread; a task that waits is replaced by the next one.

    result: what the latest task returned, or the exception that it raised.
    """

    result = Signal(object)
    _finished = Signal(object, object)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._latest: Task | None = None
        self._thread: Thread | None = None
        self._finished.connect(self._finish)

    @property
    def busy(self) -> bool:
        """Whether a task is running in the thread."""
        return self._thread is not None

    def submit(self, task: Task, *, at_once: bool = False) -> None:
        """Run a task in the thread as soon as possible, or at once in the caller's own, instead of all earlier ones."""
        self._latest = None if at_once else task
        if at_once:
            self.result.emit(_result_of(task))
        self._start()

    def stop(self) -> None:
        """Discard the task that waits, and wait for the one that is running."""
        self._latest = None
        if self._thread:
            self._thread.join()

    def _start(self) -> None:
        task = self._latest
        if task and not self._thread:
            self._thread = Thread(target=lambda: self._finished.emit(task, _result_of(task)))
            self._thread.start()

    @Slot(object, object)
    def _finish(self, task: Task, result: object) -> None:
        self._thread = None
        if task is self._latest:
            self._latest = None
            self.result.emit(result)
        self._start()


def failure_text(error: object) -> str:
    """What a task that failed shows: the message of an error that rsegen raises on purpose, or a request to report."""
    return str(error) if isinstance(error, RsegenError) else f"internal error, please report it: {error!r}"


def _result_of(task: Task) -> object:
    try:
        return task()
    except Exception as error:  # it is shown by the window, in its own thread
        return error
