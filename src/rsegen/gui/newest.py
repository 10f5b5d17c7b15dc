"""Work behind the window, one piece at a time, of which only the newest counts."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

from PySide6.QtCore import QObject, Signal, Slot

Work = Callable[[], object]


class Newest(QObject):
    """`came` tells what came of the newest order, or the error; of orders that come too fast, most are never begun."""

    came = Signal(object)
    _ended = Signal(object, object)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._ordered: Work | None = None
        self._thread: Thread | None = None
        self._ended.connect(self._end)

    def order(self, work: Work, *, at_once: bool = False) -> None:
        """Do this at once in the window's own thread, or as soon as may be; and nothing that was ordered before."""
        self._ordered = None if at_once else work
        if at_once:
            self.came.emit(_came_of(work))
        self._begin()

    def end(self) -> None:
        """Give up what is ordered, and wait for what cannot be stopped."""
        self._ordered = None
        if self._thread:
            self._thread.join()

    def _begin(self) -> None:
        work = self._ordered
        if work and not self._thread:
            self._thread = Thread(target=lambda: self._ended.emit(work, _came_of(work)))
            self._thread.start()

    @Slot(object, object)
    def _end(self, work: Work, result: object) -> None:
        self._thread = None
        if work is self._ordered:
            self._ordered = None
            self.came.emit(result)
        self._begin()


def _came_of(work: Work) -> object:
    try:
        return work()
    except Exception as error:  # it is told in the window's own thread
        return error
