"""The plan as a file: SVG and PDF of lines and texts, or PNG."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtCore import QMarginsF, QRect, QSize, QSizeF, Qt
from PySide6.QtGui import QImage, QPageSize, QPaintDevice, QPainter, QPdfWriter

from rsegen.errors import FileError, UnknownName

Paint = Callable[[QPainter], None]
_FINE = 4
"""Pixels of a PNG file per pixel of the plan."""


def save_plan(path: Path, size: QSize, paint: Paint) -> None:
    """Write what `paint` paints on an area of some pixels, in the format of the suffix; a FileError if that fails."""
    write = WRITERS.get(path.suffix.lower())
    if write is None:
        raise UnknownName.among(f"{path}", "suffix of a plan", path.suffix, WRITERS)
    try:
        path.open("ab").close()
        written = write(path, size, paint)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None
    if not written:
        raise FileError(f"{path}: cannot be written")


def _svg(path: Path, size: QSize, paint: Paint) -> bool:
    from PySide6.QtSvg import QSvgGenerator

    generator = QSvgGenerator()
    generator.setFileName(str(path))
    generator.setSize(size)
    generator.setViewBox(QRect(0, 0, size.width(), size.height()))
    generator.setTitle("rsegen: plan of a map")
    return _painted(generator, paint)


def _pdf(path: Path, size: QSize, paint: Paint) -> bool:
    writer = QPdfWriter(str(path))
    writer.setResolution(72)
    writer.setPageSize(QPageSize(QSizeF(size), QPageSize.Unit.Point))
    writer.setPageMargins(QMarginsF())
    writer.setTitle("rsegen: plan of a map")
    return _painted(writer, paint)


def _png(path: Path, size: QSize, paint: Paint) -> bool:
    image = QImage(size * _FINE, QImage.Format.Format_ARGB32)
    image.setDevicePixelRatio(_FINE)
    image.fill(Qt.GlobalColor.white)
    return _painted(image, paint) and image.save(str(path))


def _painted(device: QPaintDevice, paint: Paint) -> bool:
    painter = QPainter()
    if not painter.begin(device):
        return False
    paint(painter)
    return painter.end()


WRITERS: Mapping[str, Callable[[Path, QSize, Paint], bool]] = {".svg": _svg, ".pdf": _pdf, ".png": _png}
"""The formats by their suffix."""
