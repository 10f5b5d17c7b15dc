"""The camera of the 3D view, how it is turned and moved, and the legend and scale bar over its picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QGuiApplication, QImage, QPainter, QPen

from rsegen.field.stepfield import Array
from rsegen.gui.model.colours import Rgb
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.solid import SOUTH_EAST, VIEW_ANGLE, Bounds, length_text, round_length, viewpoint
from rsegen.gui.widgets.meshes import Plotter


class Side(Enum):
    """From where the whole map is seen: the direction to the camera."""

    PERSPECTIVE = tuple(SOUTH_EAST.tolist())
    TOP = (0.0, 0.0, 1.0)
    SOUTH = (0.0, -1.0, 0.0)


class Look(NamedTuple):
    """How a camera looks: its position, focal point and direction up; the scale without perspective, the angle with it,
    degrees; the size of its view in pixels, and whether that shows the whole map.
    """

    place: tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
    is_parallel: bool
    scale: float
    angle: float
    size: tuple[int, int]
    is_fitted: bool


class ViewCamera:
    """The camera of a plotter, which fits bounds into the view; size: gives its width and height."""

    def __init__(self, plotter: Plotter, size: Callable[[], tuple[int, int]]) -> None:
        self._plotter, self._size = plotter, size
        self._bounds: Bounds | None = None
        self._margin = 0.0
        self._fitted: tuple[float, ...] = ()

    def fit_bounds(self, found: Bounds, margin: float) -> None:
        """Show the whole of some bounds, widened by a margin, from the present direction, if they are other ones."""
        before, self._bounds, self._margin = (self._bounds, self._margin), found, margin
        if before[0] is None:
            self.look_from(Side.PERSPECTIVE)
        elif found[:4] != before[0][:4]:
            self.fit()
        elif margin != before[1]:
            self.fit_to_size()

    def look_from(self, side: Side) -> None:
        """Show the whole map from a side; from above and from the south all is drawn to one scale."""
        self._plotter.camera.SetParallelProjection(side is not Side.PERSPECTIVE)
        self._look_along(np.array(side.value))

    @property
    def direction(self) -> tuple[float, float, float]:
        """From the map to the camera."""
        camera = self._plotter.camera
        x, y, z = np.subtract(camera.position, camera.focal_point).tolist()
        return x, y, z

    def look_along(self, direction: tuple[float, float, float]) -> None:
        """Show the whole map from any direction, in perspective."""
        self._plotter.camera.SetParallelProjection(False)  # noqa: FBT003  # VTK's
        self._look_along(np.array(direction))

    def fit(self) -> None:
        """Show the whole map from the present direction."""
        self._look_along(np.array(self.direction))

    def fit_to_size(self) -> None:
        """Show the whole map in a resized view, unless the user has moved the camera."""
        if self._is_fitted:
            self.fit()

    @property
    def _is_fitted(self) -> bool:
        """Return whether the user has not moved the camera since it showed the whole map."""
        camera = self._plotter.camera
        return self._fitted == (*camera.position, *camera.focal_point, camera.GetParallelScale())

    def turn(self, across: float, up: float) -> None:
        """Turn the camera around the map by degrees, and upwards, but neither over the top nor under the ground."""
        camera = self._plotter.camera
        x, y, z = np.subtract(camera.position, camera.focal_point)
        away, height = float(np.linalg.norm((x, y, z))), float(np.degrees(np.arctan2(z, np.hypot(x, y))))
        heading = np.radians(across) + (np.arctan2(y, x) if np.hypot(x, y) > 1e-9 * away else -np.pi / 2)
        height = np.radians(np.clip(height + up, 2, 88))
        flat = away * np.cos(height)
        camera.SetParallelProjection(False)  # noqa: FBT003  # VTK's
        camera.position = camera.focal_point + np.array(
            [flat * np.cos(heading), flat * np.sin(heading), away * np.sin(height)]
        )
        camera.up = (0.0, 0.0, 1.0)
        self._plotter.renderer.ResetCameraClippingRange()

    def leave_side(self) -> None:
        """Look in perspective again, as up stays up only there when the mouse turns the map."""
        if self._plotter.camera.GetParallelProjection():
            self.turn(0, 0)

    def zoom(self, factor: float) -> None:
        """Move the camera closer by a factor, or away if it is less than one."""
        camera = self._plotter.camera
        camera.Dolly(factor)
        camera.SetParallelScale(camera.GetParallelScale() / factor)
        self._plotter.renderer.ResetCameraClippingRange()

    def metres_per_pixel(self) -> float:
        """The length that a pixel covers at the focal point."""
        camera, (_, height) = self._plotter.camera, self._plotter.renderer.GetSize()
        if camera.GetParallelProjection():
            return float(2 * camera.GetParallelScale() / max(height, 1))
        away = float(np.linalg.norm(np.subtract(camera.position, camera.focal_point)))
        return float(2 * away * np.tan(np.radians(camera.GetViewAngle() / 2)) / max(height, 1))

    @property
    def look(self) -> Look:
        """Where it looks from, and how."""
        camera = self._plotter.camera
        return Look(
            place=(tuple(camera.position), tuple(camera.focal_point), tuple(camera.up)),
            is_parallel=bool(camera.GetParallelProjection()),
            scale=float(camera.GetParallelScale()),
            angle=float(camera.view_angle),
            size=self._size(),
            is_fitted=self._is_fitted,
        )

    def look_as(self, look: Look) -> None:
        """Look as another camera does: at the whole map if that does, else at as much from left to right."""
        camera = self._plotter.camera
        camera.position, camera.focal_point, camera.up = look.place
        (width, height), (their_width, their_height) = self._size(), look.size
        wider = max(their_width * height / max(width * their_height, 1), 1.0)
        camera.SetParallelProjection(look.is_parallel)
        if look.is_fitted:
            self.fit()
            return
        camera.SetParallelScale(look.scale * wider)
        camera.view_angle = float(np.degrees(2 * np.arctan(wider * np.tan(np.radians(look.angle / 2)))))
        self._plotter.renderer.ResetCameraClippingRange()

    def ray(self, x: float, y: float) -> tuple[Array, Array]:
        """The nearest and the farthest point that are seen at a pixel, counted from the lower left."""
        renderer, ends = self._plotter.renderer, []
        for depth in (0.0, 1.0):
            renderer.SetDisplayPoint(x, y, depth)
            renderer.DisplayToWorld()
            point = np.array(renderer.GetWorldPoint())
            ends.append(point[:3] / point[3])
        return ends[0], ends[1]

    def _look_along(self, direction: Array) -> None:
        """Look at the whole map from a direction; the scale is the same with and without perspective."""
        if not self._bounds:
            return
        width, height = self._size()
        aspect = max(width, 1) / max(height, 1)
        position, focus = viewpoint(self._bounds, direction, margin=self._margin, aspect=aspect)
        camera, is_upright = self._plotter.camera, np.hypot(*direction[:2]) < 1e-6 * np.linalg.norm(direction)
        camera.position, camera.focal_point = position, focus
        camera.up = (0.0, 1.0, 0.0) if is_upright else (0.0, 0.0, 1.0)
        camera.view_angle = VIEW_ANGLE
        camera.SetParallelScale(float(np.linalg.norm(position - focus) * np.tan(np.radians(VIEW_ANGLE / 2))))
        self._fitted = (*camera.position, *camera.focal_point, camera.GetParallelScale())
        self._plotter.renderer.ResetCameraClippingRange()


_PAD = 8.0
_TEXT = 12


class Inks(NamedTuple):
    """The colours of pictures over the view: below the text, and of the text."""

    paper: QColor
    ink: QColor


def legend_image(rows: Sequence[tuple[Rgb, str]], note: str, height: float, inks: Inks, scale: float) -> QImage:
    """Colours with their names and a note below, in at most a height; rows that have no room there are left out.

    Lengths are in pixels before they are multiplied by the scale.
    """
    metrics = QFontMetricsF(_font())
    row = metrics.height() + 3
    notes = note.splitlines()
    step = _step(len(rows), int((height - 2 * _PAD) / row) - len(notes))
    shown = [*rows[:-1:step], *rows[-1:]] if step else []
    longest = max((metrics.horizontalAdvance(text) for text in [*(name for _, name in shown), *notes]), default=0)
    side = metrics.ascent()
    image, painter = _blank(side + longest + 3 * _PAD, (len(shown) + len(notes)) * row + 2 * _PAD, inks, scale)
    for number, (colour, name) in enumerate(shown):
        y = _PAD + number * row
        painter.fillRect(QRectF(_PAD, y + (row - side) / 2, side, side), QColor(*colour))
        painter.drawText(QRectF(2 * _PAD + side, y, longest + 1, row), Qt.AlignmentFlag.AlignVCenter, name)
    for number, line in enumerate(notes):
        y = _PAD + (len(shown) + number) * row
        painter.drawText(QRectF(_PAD, y, longest + side + _PAD, row), Qt.AlignmentFlag.AlignVCenter, line)
    painter.end()
    return image


def scale_bar_image(text: str, width: float, inks: Inks, scale: float) -> QImage:
    """A bar of a width in pixels with its length as text, all multiplied by the scale."""
    metrics = QFontMetricsF(_font())
    total = max(width, metrics.horizontalAdvance(text)) + 2 * _PAD
    image, painter = _blank(total, metrics.height() + 9 + _PAD, inks, scale)
    left, y = (total - width) / 2, metrics.height() + 8
    painter.drawText(QRectF(0, 3, total, metrics.height()), Qt.AlignmentFlag.AlignHCenter, text)
    painter.setPen(QPen(inks.ink, 2))
    painter.drawPolyline([QRectF(left, y - 4, width, 4).topLeft(), QRectF(left, y, 0, 0).topLeft()])
    painter.drawLine(int(left), int(y), int(left + width), int(y))
    painter.drawLine(int(left + width), int(y - 4), int(left + width), int(y))
    painter.end()
    return image


def _step(rows: int, room: int) -> int:
    """Every which row is shown, the last aside, so that all have room; 0 if there are none."""
    return max(-(-(rows - 1) // max(room - 1, 1)), 1) if rows else 0


def _font() -> QFont:
    font = QFont(QGuiApplication.font())
    font.setPixelSize(_TEXT)
    return font


def _blank(width: float, height: float, inks: Inks, scale: float) -> tuple[QImage, QPainter]:
    """A transparent image with round, translucent paper, and a painter of it."""
    image = QImage(round(width * scale), round(height * scale), QImage.Format.Format_RGBA8888)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(scale, scale)
    paper = QColor(inks.paper)
    paper.setAlphaF(0.75)
    painter.setBrush(paper)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.drawRoundedRect(QRectF(0, 0, width, height), 5, 5)
    painter.setPen(inks.ink)
    painter.setFont(_font())
    return image, painter


_RIM = 8
_ABOVE = 9
"""The layer of the pictures, above that of the axes' numbers."""

_BAR = 140
"""The scale bar is at most this many pixels wide."""


class ViewOverlay:
    """The legend at the upper right and the scale bar at the lower left of a plotter, painted anew if they change."""

    def __init__(self, plotter: Plotter, camera: ViewCamera, scale: float) -> None:
        self._renderer, self._camera, self._scale = plotter.renderer, camera, scale
        self._legend, self._bar = _Picture(plotter), _Picture(plotter)
        self._rows: Sequence[tuple[Rgb, str]] = ()
        self._note = ""
        self._inks: Inks | None = None
        self._painted: tuple[object, object] = (None, None)
        self._renderer.AddObserver("StartEvent", lambda *_: self._paint())

    def show_legend(self, preview: Preview) -> None:
        """Show the heights of a map, and a note if it is shown coarser."""
        note = f"each column the highest\nof {preview.factor} x {preview.factor} cells"
        self._rows, self._note = preview.legend, note if preview.factor > 1 else ""

    def set_inks(self, inks: Inks) -> None:
        """Set the colours of paper and text."""
        self._inks = inks

    def _paint(self) -> None:
        """Paint what has changed since it was painted last, and put it where it belongs in a view of this size."""
        if not self._inks:
            return
        width, height = self._renderer.GetSize()
        length = round_length(self._camera.metres_per_pixel() * min(_BAR * self._scale, width / 2))
        bar = length / self._camera.metres_per_pixel() / self._scale
        before, self._painted = self._painted, ((tuple(self._rows), self._note, height, self._inks), (bar, self._inks))
        if self._painted[0] != before[0]:
            room = height / self._scale - 2 * _RIM
            self._legend.show(legend_image(self._rows, self._note, room, self._inks, self._scale))
        if self._painted[1] != before[1]:
            self._bar.show(scale_bar_image(length_text(length), bar, self._inks, self._scale))
        self._legend.set_visible(is_visible=bool(self._rows or self._note))
        rim = _RIM * self._scale
        self._legend.move(width - self._legend.width - rim, height - self._legend.height - rim)
        self._bar.move(rim, rim)


class _Picture:
    """An image at a place of the view, in pixels from its lower left corner."""

    def __init__(self, plotter: Plotter) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

        self.width = self.height = 0
        self._mapper: Any = vtkImageMapper()
        self._mapper.SetColorWindow(255)
        self._mapper.SetColorLevel(127.5)
        self._actor: Any = vtkActor2D()
        self._actor.SetMapper(self._mapper)
        self._actor.SetLayerNumber(_ABOVE)
        plotter.renderer.AddViewProp(self._actor)

    def show(self, image: QImage) -> None:
        """Show another image."""
        import pyvista

        self.width, self.height = image.width(), image.height()
        pixels = np.frombuffer(image.constBits(), dtype=np.uint8).reshape(self.height, self.width, 4)[::-1]
        grid = pyvista.ImageData(dimensions=(self.width, self.height, 1))
        scalars: Any = pixels.reshape(-1, 4).copy()
        grid.point_data.set_scalars(scalars, "pixels")
        self._mapper.SetInputData(grid)

    def set_visible(self, *, is_visible: bool) -> None:
        """Show or hide it."""
        self._actor.SetVisibility(is_visible)

    def move(self, x: float, y: float) -> None:
        """Put the lower left corner somewhere."""
        self._actor.SetPosition(round(x), round(y))
