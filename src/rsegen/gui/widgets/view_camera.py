"""The camera of the 3D view: where it looks from, and how it is turned and moved."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.gui.model.bounds import Bounds
from rsegen.gui.model.camera import SOUTH_EAST, VIEW_ANGLE, viewpoint
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
        """Whether the user has not moved the camera since it showed the whole map."""
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
