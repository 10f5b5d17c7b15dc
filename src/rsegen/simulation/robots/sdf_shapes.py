"""The extents of the collision shapes of a model in an SDF file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.io.input_files import open_regular
from rsegen.io.libraries import read_by_library
from rsegen.simulation.robots.sdf_frames import Frames, floats


class Extent(NamedTuple):
    """The axis-aligned box of a collision shape of a link, in the model's frame: low and high, (3,), metres."""

    link: str
    low: Array
    high: Array


class Extents(NamedTuple):
    """The boxes of all collision shapes whose size is known, and the names of the links that have others too."""

    known: tuple[Extent, ...]
    unknown: tuple[str, ...]

    @property
    def low(self) -> Array:
        """The lowest x, y and z of all, metres."""
        return np.asarray(np.min([each.low for each in self.known], axis=0))

    @property
    def high(self) -> Array:
        """The highest x, y and z of all, metres."""
        return np.asarray(np.max([each.high for each in self.known], axis=0))

    def of(self, link: str) -> Extent | None:
        """The box of all shapes of one link; None if one is unknown, or there is none."""
        boxes = [each for each in self.known if each.link == link]
        if not boxes or link in self.unknown:
            return None
        low, high = np.min([each.low for each in boxes], axis=0), np.max([each.high for each in boxes], axis=0)
        return Extent(link, low, high)


class _Solid(NamedTuple):
    """A box with a half of each side, swept by an ellipsoid of these radii, around a centre; metres."""

    half: tuple[float, float, float]
    radii: tuple[float, float, float] = (0, 0, 0)
    centre: tuple[float, float, float] = (0, 0, 0)


def extents(frames: Frames) -> Extents:
    """The extents of the collision shapes of every link of a model."""
    known, unknown = [], []
    for link, collision in _collisions(frames):
        geometry = collision.find("geometry")
        if geometry is None or _is_without_extent(geometry):
            continue
        solid = _solid(geometry, frames.where)
        if solid is None:
            unknown.append(link)
            continue
        pose = frames.shape(link, collision)
        reach = np.abs(pose[:3, :3]) @ solid.half + np.sqrt((pose[:3, :3] ** 2) @ np.square(solid.radii))
        middle = pose[:3, :3] @ solid.centre + pose[:3, 3]
        known.append(Extent(link, middle - reach, middle + reach))
    return Extents(tuple(known), tuple(dict.fromkeys(unknown)))


def _collisions(frames: Frames) -> Iterator[tuple[str, Element]]:
    for name, element in frames.elements.items():
        if element.tag == "link":
            yield from ((name, collision) for collision in element.findall("collision"))


def _is_without_extent(geometry: Element) -> bool:
    return geometry.find("empty") is not None or geometry.find("plane") is not None or len(geometry) == 0


def _solid(geometry: Element, where: str) -> _Solid | None:
    """The solid of a geometry; None for one that is not known."""
    kind = geometry[0]
    if kind.tag == "box":
        x, y, z = (side / 2 for side in floats(kind.findtext("size"), 3, where))
        return _Solid((x, y, z))
    if kind.tag == "ellipsoid":
        x, y, z = floats(kind.findtext("radii"), 3, where)
        return _Solid((0, 0, 0), (x, y, z))
    if kind.tag in ("sphere", "cylinder", "capsule", "cone"):
        (r,) = floats(kind.findtext("radius"), 1, where)
        half = 0 if kind.tag == "sphere" else floats(kind.findtext("length"), 1, where)[0] / 2
        return _Solid((0, 0, half), (r, r, 0 if kind.tag in ("cylinder", "cone") else r))
    return _mesh(kind, where) if kind.tag == "mesh" else None


def _mesh(mesh: Element, where: str) -> _Solid | None:
    """The box of a mesh in a file that trimesh reads (STL, OBJ, PLY, glTF); None for any other."""
    uri = (mesh.findtext("uri") or "").strip()
    scale = np.array(floats(mesh.findtext("scale") or "1 1 1", 3, where))
    if not uri.lower().endswith((".stl", ".obj", ".ply", ".glb", ".gltf")):
        return None
    path = Path(uri.removeprefix("file://"))

    def bounds() -> Array:
        import trimesh

        with open_regular(path) as file:
            form, resolver = path.suffix[1:].lower(), trimesh.resolvers.FilePathResolver(str(path))
            found = trimesh.load(file, file_type=form, resolver=resolver, force="mesh").bounds
        if found is None:
            raise FileError(f"{path}: has no points")
        return np.asarray(found)

    try:
        low, high = read_by_library(path, bounds) * scale
    except ImportError:
        return None
    half, centre = np.abs(high - low) / 2, (low + high) / 2
    return _Solid(tuple(half.tolist()), centre=tuple(centre.tolist()))
