"""Saving a picture: drawn and compressed in a thread, as a large one takes many seconds."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from threading import Event

from PySide6.QtCore import QBuffer, QIODevice, QObject, Signal
from PySide6.QtGui import QImage

from rsegen.errors import FileError
from rsegen.gui.workers.latest_only import LatestOnly, failure_text

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
