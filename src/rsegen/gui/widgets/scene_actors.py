"""The actors of the 3D view, created once and filled with the points, faces and colours of every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, CellWindow
from rsegen.gui.model.axes import Bounds, tick_marks
from rsegen.gui.model.camera import SOUTH_EAST, VIEW_ANGLE, viewpoint
from rsegen.gui.model.colours import GROUND
from rsegen.gui.model.solid import Lines, Solid, block_edges, box_edges

if TYPE_CHECKING:
    from pyvista import Actor, PolyData

EDGED = 60
"""The blocks of maps up to this many cells a side are outlined."""

_HIGHLIGHT = (0.95, 0.0, 0.75)
_EDGE = (0.1, 0.1, 0.1)
_GHOSTLY = 0.45
"""The opacity of an obstacle that is not yet in the list."""
_BORDER = 0.06
"""Width of the ground around the map, as a share of its longer side; a hundredth of that is its depth below the map."""

Plotter = Any
"""A pyvistaqt.QtInteractor, which has no types."""


class SceneActors:
    """What a plotter shows: the map, the edges of its blocks, the highlighted cells, the ground, the axes."""

    def __init__(self, plotter: Plotter) -> None:
        self._plotter = plotter
        self._ground, _ = _actor(plotter, colour=tuple(part / 255 for part in GROUND))
        self._solid, _ = _actor(plotter, colour=None)
        self._ghost, self._ghost_actor = _actor(plotter, colour=None, nearer=1)
        self._ghost_actor.prop.opacity = _GHOSTLY
        self._edges, self._edges_actor = _actor(plotter, colour=_EDGE, width=1, nearer=2)
        self._tick_marks, _ = _actor(plotter, colour=_EDGE, width=1, nearer=2)
        self._box, self._box_actor = _actor(plotter, colour=_HIGHLIGHT, width=3, nearer=40)
        self._bounds: Bounds | None = None
        self._ink = (0.0, 0.0, 0.0)
        self._fitted_position: tuple[float, ...] | None = None

    def show(self, scene: Scene, made: Solid, cells: CellWindow | None) -> None:
        """Show the solid of a scene and a box around some cells; the camera moves only if the map has another size."""
        field = scene.field
        _fill_faces(self._solid, made)
        if edged := max(field.shape) <= EDGED:
            _fill_lines(self._edges, block_edges(field))
        self._edges_actor.SetVisibility(edged)
        if cells:
            _fill_lines(self._box, box_edges(field, cells))
        self._box_actor.SetVisibility(cells is not None)
        self._show_ground(bounds(scene))
        self._plotter.renderer.ResetCameraClippingRange()

    def show_ghost(self, made: Solid | None) -> None:
        """Show the blocks of an obstacle that is not yet in the list, pale; None hides them."""
        if made:
            _fill_faces(self._ghost, made)
        self._ghost_actor.SetVisibility(made is not None)

    def set_colours(self, background: tuple[float, float, float], ink: tuple[float, float, float]) -> None:
        """Set the colours of the background and of the axes."""
        self._plotter.set_background(background)
        self._ink = ink
        if self._bounds:
            self._show_axes(self._bounds)

    def reset_camera(self) -> None:
        """Show the whole map from the south-east, above."""
        self._look_from(SOUTH_EAST)

    def turn(self, across: float, up: float) -> None:
        """Turn the camera around the map by degrees, and upwards, but neither over the top nor under the ground."""
        camera = self._plotter.camera
        camera.Azimuth(across)
        x, y, z = np.subtract(camera.position, camera.focal_point)
        height = np.degrees(np.arctan2(z, np.hypot(x, y)))
        camera.Elevation(float(np.clip(height + up, 2, 88) - height))
        self._plotter.renderer.ResetCameraClippingRange()

    def zoom(self, factor: float) -> None:
        """Move the camera closer by a factor, or away if it is less than one."""
        self._plotter.camera.Dolly(factor)
        self._plotter.renderer.ResetCameraClippingRange()

    def fit_to_size(self) -> None:
        """Show the whole map in a resized view, unless the user has moved the camera."""
        if self._fitted_position and self._fitted_position == tuple(self._plotter.camera.position):
            self._fit()

    def _show_ground(self, found: Bounds) -> None:
        """Show ground and axes for these bounds, if they have changed."""
        before, self._bounds = self._bounds, found
        if found == before:
            return
        _fill_faces(self._ground, _ground(found))
        self._show_axes(found)
        if before is None:
            self.reset_camera()
        elif found[:4] != before[:4]:
            self._fit()

    def _fit(self) -> None:
        """Show the whole map from the present direction."""
        camera = self._plotter.camera
        self._look_from(np.subtract(camera.position, camera.focal_point))

    def _look_from(self, direction: Array) -> None:
        if not self._bounds:
            return
        aspect = max(self._plotter.width(), 1) / max(self._plotter.height(), 1)
        margin = 2.6 * _border(self._bounds)
        position, focus = viewpoint(self._bounds, direction, margin=margin, aspect=aspect)
        camera = self._plotter.camera
        camera.position, camera.focal_point, camera.up = position, focus, (0.0, 0.0, 1.0)
        camera.view_angle = VIEW_ANGLE
        self._fitted_position = tuple(camera.position)
        self._plotter.renderer.ResetCameraClippingRange()

    def _show_axes(self, found: Bounds) -> None:
        """Show tick marks with metres along the map's sides."""
        ruled = tick_marks(found, _border(found))
        _fill_lines(self._tick_marks, ruled.lines)
        self._plotter.add_point_labels(
            ruled.places,
            ruled.texts,
            name="metres",
            text_color=self._ink,
            font_size=12,
            bold=False,
            shape=None,
            show_points=False,
            always_visible=True,
            justification_horizontal="center",
            justification_vertical="center",
            reset_camera=False,
            render=False,
        )


def bounds(scene: Scene) -> Bounds:
    """Smallest and largest x, y and z of a scene [m]; z up to the highest level that the recipe can have."""
    field = scene.field
    half_x, half_y = (side / 2 for side in field.extent)
    frame = field.frame_height if field.frame.any() else 0.0
    top = max(scene.recipe.top_level * field.unit, frame, float(field.heights.max(initial=0.0)), field.unit)
    return -half_x, half_x, -half_y, half_y, 0.0, top


def _ground(found: Bounds) -> Solid:
    """A plate just below the map, a little larger than it."""
    west, east, south, north = found[:4]
    border = _border(found)
    x, y = (west - border, east + border), (south - border, north + border)
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    points: Array = np.array([(*corner, -border / 100) for corner in corners])
    return Solid(points, np.arange(4, dtype=np.int32)[None], np.array([GROUND], dtype=np.uint8))


def _border(found: Bounds) -> float:
    west, east, south, north = found[:4]
    return _BORDER * max(east - west, north - south)


def _actor(
    plotter: Plotter, *, colour: tuple[float, ...] | None, width: int = 1, nearer: int = 0
) -> tuple[PolyData, Actor]:
    """Add an empty, unlit mesh to a plotter; without a colour its faces have their own.

    nearer: how far it is drawn in front of faces at the same place.
    """
    import pyvista

    mesh = pyvista.PolyData()
    mapper = pyvista.DataSetMapper(mesh)
    actor = pyvista.Actor(mapper=mapper)
    actor.prop.lighting = False
    actor.prop.line_width = width
    if colour is None:
        mapper.SetColorModeToDirectScalars()
        mapper.SetScalarModeToUseCellData()
    else:
        mapper.ScalarVisibilityOff()
        actor.prop.color = colour
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-nearer, -nearer)
    plotter.add_actor(actor, reset_camera=False, render=False)
    return mesh, actor


def _fill_faces(mesh: PolyData, found: Solid) -> None:
    import pyvista

    made = pyvista.PolyData()
    if len(found.faces):
        faces: Any = found.faces
        made = pyvista.PolyData.from_regular_faces(found.points, faces)
        made.cell_data.set_scalars(found.colours, "colour")
    _replace(mesh, made)


def _fill_lines(mesh: PolyData, found: Lines) -> None:
    import pyvista

    rows = np.column_stack([np.full(len(found.pairs), 2), found.pairs]).ravel()
    _replace(mesh, pyvista.PolyData(found.points, lines=rows))


def _replace(mesh: PolyData, made: Any) -> None:
    """Replace the content of a mesh, so that its actor stays."""
    mesh.shallow_copy(made)
    mesh.Modified()
