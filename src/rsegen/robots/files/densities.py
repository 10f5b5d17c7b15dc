"""Masses of links from the densities of their collision shapes, for links with <inertial auto>, as in Gazebo Sim.

    shape --density, volume--> mass, centre, tensor --of all shapes--> <inertial> --scaled to its <mass>--> <inertial>

Each shape is a solid of even density: its own, or that of its link's <inertial>, or 1000 kg/m^3. They are added up even
where they overlap. A mesh is the sum of the tetrahedra between the origin and its triangles, with signs (Blow and
Binstock 2004), so it has to be closed; small holes change little. Gazebo Sim computes the same; with the masses in the
model, all other simulators have them too. Cost: reading the meshes.
"""

from __future__ import annotations

from math import pi
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.robots.files.meshes import collision_mesh
from rsegen.robots.files.sdf_elements import Mass, append_inertial, is_true, sum_of_masses
from rsegen.robots.files.sdf_shapes import (
    ROUND,
    ModelFrames,
    file_and_scale,
    floats,
    geometries,
    is_impossible,
    radius_and_length,
    refuse_mass,
)

_WATER = 1000.0
"""Density, kg/m^3, of shapes of which a file says none, in SDF."""

_REPLACED = ("pose", "mass", "density", "inertia", "auto_inertia_params")


def weigh(frames: ModelFrames) -> list[str]:
    """Put the masses of links that a model leaves to Gazebo into their <inertial>, and return the links' names.

    FileError for a shape that has no volume, such as a mesh that is not closed.
    """
    weighed = []
    for link, element in frames.links():
        inertial = element.find("inertial")
        if inertial is None or not is_true(inertial.attrib.pop("auto", "")):
            continue
        where = f"{frames.where}: link {shown(link)}"
        body = _of_shapes(link, element, inertial, frames)
        if not body.mass:
            raise FileError(f"{where}: its <inertial auto='true'> needs a collision shape")
        if (mass := inertial.findtext("mass")) is not None:
            (stated_mass,) = floats(mass, 1, where)
            refuse_mass(stated_mass, where)
            body = _times(body, stated_mass / body.mass)
        for part in [part for part in inertial if part.tag in _REPLACED]:
            inertial.remove(part)
        append_inertial(element, body)
        weighed.append(link)
    return weighed


def _of_shapes(link: str, element: Element, inertial: Element, frames: ModelFrames) -> Mass:
    """Return the mass of all collision shapes of a link, in its frame."""
    inverse, parts = np.linalg.inv(frames.transform(link)), []
    for collision, geometry in geometries(element, "collision"):
        where = f"{frames.where}: link {shown(link)}: collision shape {shown(collision.get('name', ''))}"
        density = collision.findtext("density", inertial.findtext("density", str(_WATER)))
        (value,) = floats(density, 1, where)
        if not value > 0:
            raise FileError(f"{where}: its density of {value:g} kg/m^3 is not positive")
        parts.append((_times(_of_solid(geometry[0], where), value), inverse @ frames.shape(link, collision)))
    return sum_of_masses(parts)


def _times(body: Mass, factor: float) -> Mass:
    """Return a body of a density that is larger by a factor."""
    return Mass(body.mass * factor, body.centre, body.tensor * factor)


def _of_solid(kind: Element, where: str) -> Mass:
    """Return the mass of a solid of 1 kg/m^3 in its own frame."""
    if kind.tag == "mesh":
        return _of_mesh(kind, where)
    if kind.tag in ("box", "ellipsoid"):
        x, y, z = floats(kind.findtext("size" if kind.tag == "box" else "radii"), 3, where)
        volume, part = (x * y * z, 12) if kind.tag == "box" else (4 / 3 * pi * x * y * z, 5)
        return Mass(volume, np.zeros(3), volume / part * np.diag([y * y + z * z, x * x + z * z, x * x + y * y]))
    if kind.tag not in ROUND:
        raise FileError(
            f"{where}: the mass of a <{kind.tag}> is not computed; write the link's <inertial> without auto"
        )
    r, length = radius_and_length(kind, where)
    if kind.tag == "cone":  # its centre is a quarter of its length above its base
        volume = pi * r * r * length / 3
        across = volume * (3 / 20 * r * r + 3 / 80 * length**2)
        return Mass(volume, np.array([0, 0, -length / 4]), np.diag([across, across, 0.3 * volume * r * r]))
    # A cylinder with the halves of a ball at its ends, each of them 3/8 r from its plane to its centre.
    tube, ball = (pi * r * r * length, 4 / 3 * pi * r**3 if kind.tag != "cylinder" else 0.0)
    across = tube * (3 * r * r + length**2) / 12 + ball * (0.4 * r * r + length**2 / 4 + 0.375 * length * r)
    along = tube * r * r / 2 + ball * 0.4 * r * r
    return Mass(tube + ball, np.zeros(3), np.diag([across, across, along]))


def _of_mesh(mesh: Element, where: str) -> Mass:
    """Return the mass of a closed mesh of 1 kg/m^3."""
    path, scale = file_and_scale(mesh, where)
    points, corners = collision_mesh(path)
    corner = points[corners].astype(np.float64) * scale
    total = corner.sum(axis=1)
    # A tetrahedron 0, a, b, c has the volume a . (b x c) / 6, negative if its triangle faces the origin, the centre
    # total / 4, and as its integral of x x^T: volume / 20 times (a a^T + b b^T + c c^T + total total^T).
    six = np.einsum("ni,ni->n", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))  # times the volume
    volume = float(six.sum() / 6)
    if not volume > 0:
        raise _not_closed(path, where)
    centre = six @ total / 24 / volume
    moments = (np.einsum("n,nki,nkj->ij", six, corner, corner) + np.einsum("n,ni,nj->ij", six, total, total)) / 120
    moments -= volume * np.outer(centre, centre)
    tensor: Array = np.trace(moments) * np.eye(3) - moments
    if np.linalg.eigvalsh(tensor)[0] <= 0 or is_impossible(tensor):
        raise _not_closed(path, where)
    return Mass(volume, centre, tensor)


def _not_closed(path: Path, where: str) -> FileError:
    problem = "has no volume, as it is not closed, or its faces point inwards"
    return FileError(f"{where}: {path.name} {problem}; mend it, or write the link's <inertial> without auto")
