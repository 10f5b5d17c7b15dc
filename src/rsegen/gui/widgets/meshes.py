"""Meshes of the 3D view, each with an actor that stays while its points, faces and colours are replaced."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rsegen.gui.model.reach import RobotPart, RobotShape
from rsegen.gui.model.solid import Floats, Lines, Solid

if TYPE_CHECKING:
    from pyvista import Actor, PolyData, Texture

_PALEST = 50
"""Black parts of robots are drawn this bright of 255, to be seen on a dark background."""

Plotter = Any
"""A pyvista.Plotter, which has no types."""


class Drawn(NamedTuple):
    """A mesh and its actor."""

    mesh: PolyData
    actor: Actor


def faces_in(plotter: Plotter, texture: Texture | None = None) -> Drawn:
    """Add an empty mesh of faces, each in its own colour; `texture` makes it darker where that is dark."""
    drawn = _added(plotter)
    drawn.actor.mapper.SetColorModeToDirectScalars()
    drawn.actor.mapper.SetScalarModeToUseCellData()
    if texture is not None:
        drawn.actor.SetTexture(texture)
    return drawn


def lines_in(plotter: Plotter, colour: tuple[float, ...], *, width: float, nearer: int) -> Drawn:
    """Add an empty mesh of lines; nearer: how far it is drawn in front of faces at the same place."""
    drawn = _added(plotter)
    drawn.actor.mapper.ScalarVisibilityOff()
    drawn.actor.prop.color = colour
    drawn.actor.prop.line_width = width
    drawn.actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-nearer, -nearer)
    return drawn


def light_map() -> Any:
    """A texture that is smooth near by and far away."""
    import pyvista

    texture: Any = pyvista.Texture
    made = texture(np.full((2, 2, 3), 255, dtype=np.uint8))
    made.InterpolateOn()
    made.MipmapOn()
    made.SetMaximumAnisotropicFiltering(1)  # more takes software OpenGL as long again as all else
    return made


def fill_light(texture: Texture, light: Floats) -> None:
    """Replace the content of a light map, x along its first axis."""
    import pyvista

    grey = np.round(light * 255).astype(np.uint8).T
    image = pyvista.ImageData(dimensions=(*grey.shape[::-1], 1))
    scalars: Any = np.repeat(grey.ravel()[:, None], 3, axis=1)
    image.point_data.set_scalars(scalars, "light")
    texture.SetInputData(image)


def fill_faces(drawn: Drawn, found: Solid) -> None:
    """Replace the content of a mesh by faces."""
    import pyvista

    made = pyvista.PolyData()
    if len(found.faces):
        points: Any = found.points
        faces: Any = found.faces
        made = pyvista.PolyData.from_regular_faces(points, faces)
        made.cell_data.set_scalars(found.colours, "colour")
        made.active_texture_coordinates = found.places
    _replace(drawn.mesh, made)


def fill_lines(drawn: Drawn, found: Lines) -> None:
    """Replace the content of a mesh by lines."""
    import pyvista

    rows = np.column_stack([np.full(len(found.pairs), 2), found.pairs]).ravel()
    _replace(drawn.mesh, pyvista.PolyData(found.points, lines=rows) if len(rows) else pyvista.PolyData())


def robot_in(plotter: Plotter) -> Drawn:
    """Add an empty mesh of a robot's parts, each in its own colour, lit so that its round parts are seen as round."""
    drawn = faces_in(plotter)
    drawn.actor.prop.lighting = True
    drawn.actor.prop.ambient = 0.45
    drawn.actor.prop.diffuse = 0.7
    return drawn


def fill_robot(drawn: Drawn, shape: RobotShape) -> None:
    """Replace the content of a mesh by the parts of a robot, its origin in the origin."""
    import pyvista

    parts = [_part(part) for part in shape.parts]
    _replace(drawn.mesh, pyvista.merge(parts).extract_surface(algorithm="dataset_surface"))


def _part(part: RobotPart) -> Any:
    import pyvista

    sizes: Any = part.sizes
    if len(sizes) == 3:
        made: Any = pyvista.Cube(x_length=sizes[0], y_length=sizes[1], z_length=sizes[2])
    elif len(sizes) == 2:
        made = pyvista.Cylinder(direction=(0, 0, 1), radius=sizes[0], height=sizes[1], resolution=32)
    else:
        made = pyvista.Sphere(radius=sizes[0])
    made = made.transform(part.pose, inplace=False)
    made.clear_data()
    colours: Any = np.tile(
        np.round(_PALEST + (255 - _PALEST) * np.array(part.colour)).astype(np.uint8), (made.n_cells, 1)
    )
    made.cell_data.set_scalars(colours, "colour")
    return made


def _added(plotter: Plotter) -> Drawn:
    """Add an empty, unlit mesh to a plotter."""
    import pyvista

    mesh = pyvista.PolyData()
    mapper = pyvista.DataSetMapper(mesh)
    actor = pyvista.Actor(mapper=mapper)
    actor.prop.lighting = False
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    plotter.add_actor(actor, reset_camera=False, render=False)
    return Drawn(mesh, actor)


def _replace(mesh: PolyData, made: Any) -> None:
    """Replace the content of a mesh, so that its actor stays."""
    mesh.shallow_copy(made)
    mesh.Modified()
