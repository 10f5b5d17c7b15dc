"""Readers of mesh files from anywhere, as Gazebo reads them, for what trimesh reads otherwise.

    scene.dae --read_collada--> Triangles, in metres          mesh.obj, others --loaded_by_trimesh--> what trimesh has

COLLADA. Idea: a scene is a tree of nodes, each with transforms and instances of geometries, or of nodes of a library;
every instance adds the triangles of its geometry, as Gazebo places them. Source: COLLADA 1.4.1, Khronos 2008; and
Gazebo's ColladaLoader, which multiplies all lengths with the <unit>, and leaves <up_axis> alone. Cost: linear in the
text and in what its instances add, which is limited, as a few lines can double themselves without end. What breaks it:
skins of controllers, strips and fans of triangles, and splines are left out.

OBJ. Idea: in `f -3 -2 -1` the corners are the last three points before this line, wherever others follow, while trimesh
counts them from the end of the file; such files become equal ones that count forwards. Source: Wavefront, Advanced
Visualizer, appendix B1. Cost: linear in the lines, if there are any such corners.

Text. Names and comments of other languages may be in Latin-1, as Windows wrote them, and trimesh takes UTF-8 alone, or
guesses by a library that few have. Text that is no UTF-8 becomes it; nothing that counts has such letters.
"""

from __future__ import annotations

import os
import re
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from io import BufferedReader, BytesIO
from math import radians
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.poses import pose_matrix, turn_about
from rsegen.input_files import read_by_library, text_of, xml_root

MAX_MESH_MIB = 64
"""The largest file that is read, MiB: about a million triangles; makers' have some megabytes."""

_MOST = 10_000
"""Nodes in a scene at most; makers' models have up to some hundreds."""

_MOST_TRIANGLES = 5_000_000
"""Triangles in a scene at most, and points: five times those of the largest file that has each but once."""


class Triangles(NamedTuple):
    """The triangles of a mesh: points (n, 3), metres; corners (m, 3), indices of points."""

    points: Array
    corners: Ints


def read_collada(path: Path) -> Triangles:
    """Return the triangles of a file; FileError if it has none, or is no COLLADA."""
    root = xml_root(text_of(path, MAX_MESH_MIB, "a mesh"), str(path))
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]  # without the name space, of which there are two
    parts = read_by_library(path, lambda: list(_Scene(root).triangles()))
    if not parts:
        raise FileError(f"{path}: has no triangles")
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    corners = [part.corners + start for part, start in zip(parts, starts[:-1], strict=True)]
    points = np.concatenate([part.points for part in parts])
    if not np.isfinite(points).all():
        raise FileError(f"{path}: has a point whose place is no number")
    return Triangles(points, np.concatenate(corners))


class _Scene:
    """A document: its elements by their ids, the geometries that were read, and how much more may come."""

    def __init__(self, root: Element) -> None:
        self._root = root
        self._known = _by_id(root)
        self._geometries: dict[str, list[Triangles]] = {}
        self._nodes, self._triangles = _MOST, _MOST_TRIANGLES

    def triangles(self) -> Iterator[Triangles]:
        """Yield the triangles of each instance of a geometry in the scene."""
        unit = self._root.find("asset/unit")
        scale = np.diag([*[float(unit.get("meter", "1")) if unit is not None else 1.0] * 3, 1.0])
        scene = self._root.find("scene/instance_visual_scene")
        if scene is not None:
            for node in self._known["visual_scene", scene.get("url", "")].findall("node"):
                yield from self._of_node(node, scale)

    def _of_node(self, node: Element, above: Array) -> Iterator[Triangles]:
        self._nodes -= 1
        if self._nodes < 0:
            raise ValueError(f"more than {_MOST} nodes")
        place = above
        for element in node:
            if element.tag in _TRANSFORMS:
                place = place @ _TRANSFORMS[element.tag](_numbers(element))
            elif element.tag == "node":
                yield from self._of_node(element, place)
            elif element.tag == "instance_node":
                yield from self._of_node(self._known["node", element.get("url", "")], place)
            elif element.tag == "instance_geometry":
                yield from self._of_instance(element.get("url", ""), place)

    def _of_instance(self, url: str, place: Array) -> Iterator[Triangles]:
        if url not in self._geometries:
            self._geometries[url] = list(self._of_geometry(self._known["geometry", url]))
        for points, corners in self._geometries[url]:
            self._triangles -= max(len(points), len(corners))
            if self._triangles < 0:
                raise ValueError(f"more than {_MOST_TRIANGLES} triangles or points")
            yield Triangles(points @ place[:3, :3].T + place[:3, 3], corners)

    def _of_geometry(self, geometry: Element) -> Iterator[Triangles]:
        """Yield the triangles of a geometry, each list of faces on its own."""
        known = ChainMap(_by_id(geometry), self._known)  # some programs give each geometry's points one id
        for faces in geometry.iterfind("mesh/*"):
            if faces.tag not in ("triangles", "polylist", "polygons"):
                continue
            # Each corner is a row of indices, one for each input; only the column of the points counts here.
            inputs = {source.get("semantic"): source for source in faces.findall("input")}
            columns = 1 + max(int(source.get("offset", "0")) for source in faces.findall("input"))
            column = int(inputs["VERTEX"].get("offset", "0"))
            rings = [_numbers(ring).astype(np.int64).reshape(-1, columns)[:, column] for ring in faces.findall("p")]
            if faces.tag == "polylist" and rings:
                counts = _numbers(faces.find("vcount")).astype(np.int64)
                rings = np.split(rings[0], np.cumsum(counts)[:-1])
            corners = [ring.reshape(-1, 3) if faces.tag == "triangles" else _fan(ring) for ring in rings]
            joined = np.concatenate(corners) if corners else np.zeros((0, 3), dtype=np.int64)
            if joined.size:
                points = _points(inputs["VERTEX"], known)
                if not 0 <= joined.min() <= joined.max() < len(points):
                    raise ValueError("a corner of a triangle is no point")
                yield Triangles(points, joined)


_ById = MutableMapping[tuple[str, str], Element]
"""Elements by their tag and #id: programs give a node and its geometry one id, though no id may occur twice."""


def _by_id(root: Element) -> _ById:
    """Return the elements below one that have an id; of several with one tag and id the first, as in Gazebo."""
    known: _ById = {}
    for element in root.iter():
        if name := element.get("id"):
            known.setdefault((element.tag, f"#{name}"), element)
    return known


def _points(vertex: Element, known: _ById) -> Array:
    """Return the points, (n, 3), of an input VERTEX, in the unit of the file."""
    vertices = known["vertices", vertex.get("source", "")]
    (position,) = vertices.findall("input[@semantic='POSITION']")
    accessor = next(known["source", position.get("source", "")].iterfind("technique_common/accessor"))
    values = _numbers(known["float_array", accessor.get("source", "")])[int(accessor.get("offset", "0")) :]
    stride = int(accessor.get("stride", "1"))
    return values[: len(values) // stride * stride].reshape(-1, stride)[:, :3]


def _fan(ring: Ints) -> Ints:
    """Return the triangles (m, 3) of a polygon, all with its first corner."""
    return np.stack([np.repeat(ring[:1], max(len(ring) - 2, 0)), ring[1:-1], ring[2:]], axis=1)


def _numbers(element: Element | None) -> Array:
    """Return the numbers in an element, none for no element."""
    return np.array(((element.text if element is not None else "") or "").split(), dtype=np.float64)


def _turned(numbers: Array) -> Array:
    """Return the rotation, (4, 4), about an axis x, y, z by an angle in degrees."""
    *axis, angle = numbers
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    return pose_matrix((0, 0, 0), turn_about((x, y, z), radians(angle)))


_TRANSFORMS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {
        "matrix": lambda numbers: numbers.reshape(4, 4),
        "translate": pose_matrix,
        "rotate": _turned,
        "scale": lambda numbers: np.diag([*numbers, 1.0]),
    }
)
"""Transforms of nodes, (4, 4), by their elements; each is in the frame of those before it."""


# OBJ files.


_BACKWARDS = re.compile(rb"^[ \t]*[flp][ \t][^\r\n#]*?(?<=[ \t/])-\d", re.MULTILINE)
"""A line with a corner that is counted backwards."""

_POINTS = (b"v", b"vt", b"vn")
"""Words of lines with points, texture coordinates and normals, which the numbers of a corner count in this order."""


def _counted_forwards(content: bytes) -> bytes:
    """Return the content of an OBJ file with corners counted from the first point."""
    if not _BACKWARDS.search(content):
        return content
    counts, lines = dict.fromkeys(_POINTS, 0), []
    for line in content.splitlines():
        word, *corners = line.split() or [b""]
        if word in counts:
            counts[word] += 1
        is_face = word in (b"f", b"l", b"p")
        lines.append(
            b" ".join([word, *(_forwards(corner, [*counts.values()]) for corner in corners)]) if is_face else line
        )
    return b"\n".join(lines)


def _forwards(corner: bytes, counts: list[int]) -> bytes:
    """Return a corner such as -1//-1 counted forwards, given the counts of points, texture coordinates and normals."""
    indices = corner.split(b"/")
    pairs = zip(indices, counts, strict=False)
    return b"/".join(b"%d" % (count + 1 + int(index)) if index[:1] == b"-" else index for index, count in pairs)


# What trimesh reads.


_STL_HEADER = 84
"""Bytes before the faces of a binary STL file, the last four of which are their number."""

STL_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
"""A face of a binary STL file."""

_LONGEST_PLY_HEADER = 1 << 16
"""Bytes in which the header of a PLY file ends, which is text."""


def binary_faces(file: IO[bytes]) -> int | None:
    """Return the number of faces that follow in an open STL file; None of one that is not binary, or is cut."""
    count = int.from_bytes(file.read(_STL_HEADER)[-4:], "little")
    return count if os.fstat(file.fileno()).st_size == _STL_HEADER + count * STL_FACE.itemsize else None


def loaded_by_trimesh(path: Path, file: BufferedReader, **options: Any) -> Any:
    """Return what trimesh makes of an open file, and of those beside it that it names; ImportError without trimesh.

    options: of trimesh.load
    """
    import trimesh

    form, beside = path.suffix[1:].lower(), trimesh.resolvers.FilePathResolver(str(path))
    try:
        return trimesh.load(_for_trimesh(form, file), file_type=form, resolver=beside, **options)
    except ImportError as error:  # of what only files need that are broken, or in a way that few are
        raise ValueError(f"trimesh would need {error.name} for it") from None


def _for_trimesh(form: str, file: BufferedReader) -> IO[bytes]:
    """Return an open file as it is, or as trimesh takes it."""
    is_text = form in ("obj", "gltf") or (form == "stl" and binary_faces(file) is None)
    header, end, _ = file.read(_LONGEST_PLY_HEADER).partition(b"end_header") if form == "ply" else (b"", b"", b"")
    file.seek(0)
    if is_text:
        text = _in_utf8(file.read())
        return BytesIO(_counted_forwards(text) if form == "obj" else text)
    if end and (in_utf8 := _in_utf8(header)) != header:
        return BytesIO(in_utf8 + file.read()[len(header) :])
    return file


def _in_utf8(text: bytes) -> bytes:
    """Return a text in UTF-8 as it is, and any other as if it were Latin-1."""
    try:
        text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1").encode()
    return text
