"""The actors of a 3D view: made once, and given new points, faces and colours for every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, CellWindow
from rsegen.gui.axes import Bounds, marks
from rsegen.gui.colours import GROUND
from rsegen.gui.sight import SOUTH_EAST, VIEW_ANGLE, viewpoint
from rsegen.gui.solid import Lines, Solid, block_edges, box_edges

if TYPE_CHECKING:
    from pyvista import Actor, PolyData

EDGED = 60
"""Maps of up to so many cells a side have their blocks outlined."""

_HIGHLIGHT = (0.95, 0.0, 0.75)
_EDGE = (0.1, 0.1, 0.1)
_APRON = 0.06
"""How far the ground goes beyond the map, in its longer side; how far below it lies, a hundredth of that."""

Plotter = Any
"""A pyvistaqt.QtInteractor; its wrapped methods lose their types."""


class Stage:
    """What stands in a plotter: the map, the edges of its blocks, the highlighted window, the ground, axes."""

    def __init__(self, plotter: Plotter) -> None:
        self._plotter = plotter
        self._ground, _ = _actor(plotter, colour=tuple(part / 255 for part in GROUND))
        self._solid, _ = _actor(plotter, colour=None)
        self._edges, self._edges_actor = _actor(plotter, colour=_EDGE, width=1, nearer=2)
        self._marks, _ = _actor(plotter, colour=_EDGE, width=1, nearer=2)
        self._box, self._box_actor = _actor(plotter, colour=_HIGHLIGHT, width=3, nearer=40)
        self._bounds: Bounds | None = None
        self._ink = (0.0, 0.0, 0.0)
        self._fitted: tuple[float, ...] | None = None

    def show(self, scene: Scene, made: Solid, window: CellWindow | None) -> None:
        """The solid of a scene, a box round a window of its cells; the camera stays, unless the extent is another."""
        field = scene.field
        _fill_faces(self._solid, made)
        if edged := max(field.shape) <= EDGED:
            _fill_lines(self._edges, block_edges(field))
        self._edges_actor.SetVisibility(edged)
        if window:
            _fill_lines(self._box, box_edges(field, window))
        self._box_actor.SetVisibility(window is not None)
        self._surround(bounds(scene))
        self._plotter.renderer.ResetCameraClippingRange()

    def paint(self, background: tuple[float, float, float], ink: tuple[float, float, float]) -> None:
        """In these colours: what is behind everything, and what the axes are written in."""
        self._plotter.set_background(background)
        self._ink = ink
        if self._bounds:
            self._rule(self._bounds)

    def reset_camera(self) -> None:
        """Look at the whole map from the south-east, above."""
        self._look_from(SOUTH_EAST)

    def turn(self, across: float, up: float) -> None:
        """Go round the map by degrees, and higher, but neither over it nor under it."""
        camera = self._plotter.camera
        camera.Azimuth(across)
        x, y, z = np.subtract(camera.position, camera.focal_point)
        height = np.degrees(np.arctan2(z, np.hypot(x, y)))
        camera.Elevation(float(np.clip(height + up, 2, 88) - height))
        self._plotter.renderer.ResetCameraClippingRange()

    def come_nearer(self, factor: float) -> None:
        """Go towards the map, or away from it where the factor is less than one."""
        self._plotter.camera.Dolly(factor)
        self._plotter.renderer.ResetCameraClippingRange()

    def follow_size(self) -> None:
        """See the whole map in a view of another size, unless the camera was moved by hand."""
        if self._fitted and self._fitted == tuple(self._plotter.camera.position):
            self._fit()

    def _surround(self, found: Bounds) -> None:
        """Ground and axes for a map of these bounds, where they are other than before."""
        before, self._bounds = self._bounds, found
        if found == before:
            return
        _fill_faces(self._ground, _ground(found))
        self._rule(found)
        if before is None:
            self.reset_camera()
        elif found[:4] != before[:4]:
            self._fit()

    def _fit(self) -> None:
        """See the whole map, from the side that it is seen from."""
        camera = self._plotter.camera
        self._look_from(np.subtract(camera.position, camera.focal_point))

    def _look_from(self, direction: Array) -> None:
        if not self._bounds:
            return
        aspect = max(self._plotter.width(), 1) / max(self._plotter.height(), 1)
        margin = 2.6 * _apron(self._bounds)
        position, focus = viewpoint(self._bounds, direction, margin=margin, aspect=aspect)
        camera = self._plotter.camera
        camera.position, camera.focal_point, camera.up = position, focus, (0.0, 0.0, 1.0)
        camera.view_angle = VIEW_ANGLE
        self._fitted = tuple(camera.position)
        self._plotter.renderer.ResetCameraClippingRange()

    def _rule(self, found: Bounds) -> None:
        """Metres along the map's sides."""
        ruled = marks(found, _apron(found))
        _fill_lines(self._marks, ruled.lines)
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
    """Smallest and largest x, y and z, metres; z up to the highest that the recipe can have."""
    field = scene.field
    half_x, half_y = (side / 2 for side in field.extent)
    frame = field.frame_height if field.frame.any() else 0.0
    top = max(scene.recipe.top_level * field.unit, frame, float(field.heights.max(initial=0.0)), field.unit)
    return -half_x, half_x, -half_y, half_y, 0.0, top


def _ground(found: Bounds) -> Solid:
    """A plate just under the map, a little larger than it."""
    west, east, south, north = found[:4]
    apron = _apron(found)
    x, y = (west - apron, east + apron), (south - apron, north + apron)
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    points: Array = np.array([(*corner, -apron / 100) for corner in corners])
    return Solid(points, np.arange(4, dtype=np.int32)[None], np.array([GROUND], dtype=np.uint8))


def _apron(found: Bounds) -> float:
    west, east, south, north = found[:4]
    return _APRON * max(east - west, north - south)


def _actor(
    plotter: Plotter, *, colour: tuple[float, ...] | None, width: int = 1, nearer: int = 0
) -> tuple[PolyData, Actor]:
    """An empty mesh on the stage, unlit; its faces have colours of their own where none is given.

    nearer: how much it goes before what lies at the same place.
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
    """The content of a mesh by another's, so that its actor stays."""
    mesh.shallow_copy(made)
    mesh.Modified()
