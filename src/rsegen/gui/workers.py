"""Work in threads of its own, so that the window never waits: previews, jobs, pictures, spawning."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from functools import partial
from itertools import count
from pathlib import Path
from threading import Event, Thread

from PySide6.QtCore import QBuffer, QIODevice, QObject, QThread, Signal, Slot
from PySide6.QtGui import QImage

from rsegen.errors import FileError, RsegenError
from rsegen.exporters.scene import Scene
from rsegen.gui.model.jobs import Job
from rsegen.gui.model.preview import Costs, Preview, costs, is_quick, preview
from rsegen.gui.model.session import Entry
from rsegen.gui.model.simulation import SpawnedMap, Spawning, spawn
from rsegen.recipe.recipe import Recipe

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
        """Return whether a task is running in the thread."""
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


class Previewer(QObject):
    """Computes previews, of which only the latest counts.

    previewed: its Preview; counted: its Costs; failed: why there is no preview.
    """

    previewed = Signal(object)
    counted = Signal(object)
    failed = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._shown: Preview | None = None
        self._previews, self._counts = LatestOnly(self), LatestOnly(self)
        self._previews.result.connect(self._take_preview)
        self._counts.result.connect(self._take_costs)

    @property
    def scene(self) -> Scene | None:
        """The scene that was previewed last."""
        return self._shown.scene if self._shown else None

    @property
    def busy(self) -> bool:
        """Return whether a preview is being computed in the thread."""
        return self._previews.busy

    def preview(self, recipe: Recipe, index: int, proposed: Entry | None = None) -> None:
        """Preview one map of a recipe, with a ghost of one more obstacle; a small map at once."""
        self._previews.submit(partial(preview, recipe, index, proposed, self._shown), at_once=is_quick(recipe))

    def count(self, robot: str) -> None:
        """Count the costs of the scene, and whether a robot can cross it if one is named."""
        if self.scene:
            self._counts.submit(partial(costs, self.scene, robot))

    def stop(self) -> None:
        """Wait for what is being computed, and discard it."""
        self._previews.stop()
        self._counts.stop()

    def _take_preview(self, result: object) -> None:
        if isinstance(result, Preview):
            self._shown = result
            self.previewed.emit(result)
        else:
            self.failed.emit(failure_text(result))

    def _take_costs(self, result: object) -> None:
        if isinstance(result, Costs):
            self.counted.emit(result)


_QUALITY = {".png": 70}
"""PNG loses nothing: a quarter more bytes than by default, and a third of the time."""


class PictureSaver(QObject):
    """Saves one picture after the other; `ended` says what failed, or nothing; `saved` has the path of a whole one."""

    ended = Signal(str)
    saved = Signal(Path)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._cancelled = Event()
        self._worker = LatestOnly(self)
        self._worker.result.connect(self._end)

    def save(self, draw: Callable[[], QImage], path: Path) -> None:
        """Save what is drawn as a picture in the format of the suffix."""
        cancelled = self._cancelled = Event()
        if sys.platform == "darwin":  # its windows, also those that are not shown, are of the main thread
            image = draw()
            self._worker.submit(lambda: _saved(lambda: image, path, cancelled))
        else:
            self._worker.submit(lambda: _saved(draw, path, cancelled))

    def cancel(self) -> None:
        """Write no file: what is being drawn is discarded."""
        self._cancelled.set()

    def stop(self) -> None:
        """Cancel, and wait until nothing is being drawn."""
        self.cancel()
        self._worker.stop()

    def _end(self, result: object) -> None:
        self.ended.emit(failure_text(result) if isinstance(result, Exception) else "")
        if isinstance(result, Path):
            self.saved.emit(result)


def write_picture(image: QImage, path: Path) -> None:
    """Write a picture in the format of the suffix; a FileError if that cannot be."""
    _write(_content(image, path), path)


def _saved(draw: Callable[[], QImage], path: Path, cancelled: Event) -> Path | None:
    """The path of the picture; None if it was cancelled."""
    image = draw()
    content = b"" if cancelled.is_set() else _content(image, path)
    if cancelled.is_set():
        return None
    _write(content, path)
    return path


def _content(image: QImage, path: Path) -> bytes:
    """The bytes of a picture; a FileError if there is no such format."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    suffix, quality = path.suffix[1:], _QUALITY.get(path.suffix.lower(), -1)
    if not suffix or not image.save(buffer, suffix, quality):  # type: ignore[call-overload]  # its stub says bytes
        raise _refusal(path)
    return bytes(buffer.data().data())


def _write(content: bytes, path: Path) -> None:
    try:
        path.write_bytes(content)
    except (OSError, ValueError):  # a ValueError of a name with a null character
        raise _refusal(path) from None


def _refusal(path: Path) -> FileError:
    return FileError(f"{path}: cannot be written as a picture; give a name in an existing folder, such as x.png")


class SpawnJob(QObject):
    """Spawns maps in a thread; `message` says what is done and how it ended.

    Each map has a folder and a name of its own, since simulators cache meshes by path.
    """

    message = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._folder = tempfile.TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
        self._numbers = count(1)
        self._before: SpawnedMap | None = None
        self._worker = LatestOnly(self)
        self._worker.result.connect(self._spawned)

    def spawn(self, recipe: Recipe, index: int) -> None:
        """Spawn one map of a recipe."""
        number, before = next(self._numbers), self._before
        self.message.emit(f"Spawning {recipe.map_name(index)}...")
        self._worker.submit(lambda: spawn(recipe.alone(index), Path(self._folder.name, str(number)), number, before))

    def stop(self) -> None:
        """Wait for the map that is being spawned, and delete what was written."""
        self._worker.stop()
        self._folder.cleanup()

    def _spawned(self, result: object) -> None:
        if isinstance(result, Spawning):
            self._before = result.spawned
            instead = f", in place of {result.replaced}" if result.replaced else ""
            self.message.emit(f"{result.spawned.name} is in the simulation{instead}")
        else:
            self.message.emit(failure_text(result))
