"""The pictures of the window in the manual.

python -m docs.window           makes all of them, on a display of 1920 x 1080 or more
                                (else: xvfb-run -a -s '-screen 0 1920x1080x24' python -m docs.window)
python -m docs.window FILE      makes the first of them as another file
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QCoreApplication, QEventLoop, QSettings, QTimer
from PySide6.QtGui import QColor, QImage, QPalette
from PySide6.QtWidgets import QApplication, QComboBox

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.recipe.examples import EXAMPLES

PICTURES = Path(__file__).parent / "pictures"
EXAMPLE = "mixed-course"
EDITED = 2
"""The row that is taken into the form."""

SMALL, LARGE = (1280, 720), (1920, 1080)
_BEST, _WORST = 90, 40
MOST = 200_000
"""Bytes of a picture."""

_PAUSE = 1000
"""Milliseconds in which all that has been computed is painted."""


class Picture(NamedTuple):
    """What a picture shows: whether in dark colours, its size in pixels, and the robot that is chosen, if any."""

    is_dark: bool
    size: tuple[int, int]
    robot: str = ""


SHOWN = {
    "window.jpg": Picture(is_dark=False, size=SMALL),
    "window-dark.jpg": Picture(is_dark=True, size=SMALL),
    "window-robot.jpg": Picture(is_dark=False, size=LARGE, robot="crawler"),
    "window-robot-dark.jpg": Picture(is_dark=True, size=LARGE, robot="crawler"),
}


def photograph(picture: Picture) -> QImage:
    """What is seen of the window."""
    QApplication.setPalette(_dark() if picture.is_dark else QApplication.style().standardPalette())
    window = Window(Session.opened(EXAMPLES[EXAMPLE]))
    window.resize(*picture.size)
    window.move(0, 0)
    window.show()
    window.document.select(-1 if picture.robot else EDITED)
    if picture.robot:
        (box,) = window.status.findChildren(QComboBox, "robot")
        box.setCurrentText(picture.robot)
    wait(lambda: bool(window.status.costs.text() and (window.status.crossing.text() or not picture.robot)))
    seen = window.screen().grabWindow(window.winId()).toImage()
    window.close()
    if seen.size().toTuple() != picture.size:
        sys.exit(f"the display is too small for a window of {picture.size[0]} x {picture.size[1]}")
    return seen


def wait(holds: Callable[[], bool]) -> None:
    """Let the window and its threads work until something holds and is painted."""
    loop, timer = QEventLoop(), QTimer(interval=50)

    def look() -> None:
        if holds():
            timer.stop()
            QTimer.singleShot(_PAUSE, loop.quit)

    timer.timeout.connect(look)
    timer.start()
    loop.exec()


def main(file: Path | None) -> int:
    """Make the pictures; gives the exit code."""
    application = QApplication([])
    application.setStyle("Fusion")
    QCoreApplication.setOrganizationName("rsegen-docs")
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    for path, picture in {file: next(iter(SHOWN.values()))}.items() if file else _all().items():
        _save(photograph(picture), path)
    application.quit()
    return 0


def _save(image: QImage, path: Path) -> None:
    """Save a picture; as JPEG in the best quality that makes no more than MOST bytes."""
    for quality in range(_BEST, _WORST, -4) if path.suffix == ".jpg" else [-1]:
        if not image.save(str(path), quality=quality):
            sys.exit(f"{path}: cannot be written")
        if path.stat().st_size <= MOST:
            return


def _dark() -> QPalette:
    """The colours of a dark desktop."""
    palette = QPalette(QColor(50, 50, 50))
    palette.setColor(QPalette.ColorRole.Base, QColor(32, 32, 32))
    palette.setColor(QPalette.ColorRole.AlternateBase, QColor(42, 42, 42))
    palette.setColor(QPalette.ColorRole.Highlight, QColor(42, 110, 180))
    return palette


def _all() -> dict[Path, Picture]:
    return {PICTURES / name: picture for name, picture in SHOWN.items()}


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
