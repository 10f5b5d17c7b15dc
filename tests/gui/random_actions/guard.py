"""What must not happen while the window is used: exceptions, warnings of Qt, files outside a folder."""

from __future__ import annotations

import os
import sys
import threading
import traceback
from pathlib import Path
from types import TracebackType

from PySide6.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler

_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_CHANGES = {"os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.truncate", "shutil.rmtree"}
_STARTS = {"subprocess.Popen", "os.exec", "os.posix_spawn", "os.system"}
_HARMLESS = ("fc-list",)
"""matplotlib asks it for fonts."""
_DEVICES = ("/dev/", "/proc/")
_OF_THE_SCREEN = (
    "This plugin does not support",  # offscreen
    "QXcbConnection",  # Xvfb has no extensions of a graphics card
    "QXcbClipboard",  # nor what keeps the clipboard
)
"""What Qt says about a screen that is none."""


class Guard:
    """Collects what went wrong, as texts, from all threads."""

    def __init__(self, folder: Path) -> None:
        self.wrong: list[str] = []
        self._folder = folder.resolve()

    def watch(self) -> None:
        """Collect from now on."""
        sys.excepthook = self._raised
        sys.unraisablehook = lambda raised: self._raised(type(raised.exc_value), raised.exc_value, raised.exc_traceback)
        threading.excepthook = lambda raised: self._raised(raised.exc_type, raised.exc_value, raised.exc_traceback)
        qInstallMessageHandler(self._said_by_qt)
        sys.addaudithook(self._audited)

    def _raised(self, kind: type, error: BaseException | None, trace: TracebackType | None, /) -> None:
        self.wrong.append("".join(traceback.format_exception(kind, error, trace)))

    def _said_by_qt(self, kind: QtMsgType, _: QMessageLogContext, text: str) -> None:
        if kind == QtMsgType.QtFatalMsg:
            sys.stdout.write(f"Qt: {text}\n")
            sys.stdout.flush()
        if kind != QtMsgType.QtDebugMsg and not text.startswith(_OF_THE_SCREEN):
            self.wrong.append("".join([f"Qt: {text}\n", *traceback.format_stack(limit=8)]))

    def _audited(self, event: str, arguments: tuple[object, ...]) -> None:
        if event in _STARTS and arguments[0] not in _HARMLESS:
            self.wrong.append(f"{event}: {arguments[:2]}")
        for path in _written(event, arguments):
            if not path.startswith(_DEVICES) and not self._is_inside(path):
                self.wrong.append(f"{event} outside the folder: {path}")

    def _is_inside(self, path: str) -> bool:
        return Path(os.path.realpath(path)).is_relative_to(self._folder)


def _written(event: str, arguments: tuple[object, ...]) -> list[str]:
    """The paths that an event of Python's audit writes to."""
    if event == "open" and not (isinstance(arguments[2], int) and arguments[2] & _WRITES):
        return []
    if event != "open" and event not in _CHANGES:
        return []
    return [os.fsdecode(path) for path in arguments[:2] if isinstance(path, (str, bytes)) and len(path) > 1]
