"""The legend and the scale bar in the scene of the 3D view: a native window would hide widgets over it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from PySide6.QtGui import QImage

from rsegen.gui.model.colours import Rgb
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.scale_bar import length_text, round_length
from rsegen.gui.widgets.legend import Inks, legend_image, scale_bar_image
from rsegen.gui.widgets.meshes import Plotter
from rsegen.gui.widgets.view_camera import ViewCamera

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
