"""Read point clouds: text (XYZ, CSV), arrays, PLY and meshes, PCD, LAS, LAZ, E57, bags of ROS, and depth images.

All become points (n, 3) in metres, in the frame of the file.

Nothing in a file is trusted: its size and number of points are bounded before it is read, and what a library says of a
file that it cannot read becomes a FileError.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from io import BufferedReader, BytesIO
from itertools import islice
from pathlib import Path
from struct import unpack_from
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.errors import FileError, ParameterError, library_message, shown
from rsegen.field.stepfield import Array
from rsegen.geometry.mesh_files import MAX_MESH_MIB, loaded_by_trimesh, read_collada
from rsegen.heights.base import is_esri_grid
from rsegen.heights.coordinate_system import CoordinateSystem, of_keys, of_wkt, refuse_distorted
from rsegen.heights.image_files import numbers_of, opened_image
from rsegen.input_files import first_inside, open_regular, text_of
from rsegen.npy_files import mapped
from rsegen.params.extras import read_with
from rsegen.params.sorts import CENTIMETRES
from rsegen.scanning import BAG, E57, SCAN
from rsegen.scanning.depth_images import Intrinsics, doubt_of_camera, points_of_depth
from rsegen.scanning.meshes import Cloud, seen_from_above
from rsegen.scanning.recordings import bag_points, e57_points
from rsegen.scanning.scan_options import CLOUDS

if TYPE_CHECKING:
    import trimesh

MOST_POINTS = 20_000_000
"""Points of a file at most: some 2 GB of memory while it is read."""

_MAX_CLOUD_MIB = 1024
"""The largest text that is read, MiB: some 20 million lines of three numbers."""

_MOST_NAMES = 12
"""Names of a point's values in a message at most."""

_MOST_LINES = 11
"""Lines of the header of a PCD file at most, comments left out."""

_MOST_VALUES = 1000
"""Values of a point in a PCD file at most: pypcd4 makes a name for each before it reads them."""

_NUMBER, _SEPARATOR = r"([-+]?(\d+(\.\d*)?|\.\d+)(e[-+]?\d+)?|nan)", r"(\s*[,;]\s*|\s+)"
_POINT = re.compile(rf"\s*{_NUMBER}{_SEPARATOR}{_NUMBER}{_SEPARATOR}{_NUMBER}({_SEPARATOR}|$)", re.IGNORECASE)
"""The start of a line with a point, in which no two parts can match the same letters: hostile lines take no time."""

_WITH_COMMA, _BETWEEN = r"[-+]?\d+(,\d+)?(e[-+]?\d+)?", r"(\s*;\s*|,\s+|\s+)"
_DECIMAL_COMMAS = re.compile(
    rf"(?=.*\d,\d)\s*{_WITH_COMMA}{_BETWEEN}{_WITH_COMMA}{_BETWEEN}{_WITH_COMMA}({_BETWEEN}|$)", re.IGNORECASE
)
_A_DECIMAL_COMMA = re.compile(r",(?=\d)")
"""The start of a line with a point in decimal commas, 0,5;1,25;-3,0 or with blanks between; and such a comma."""

_CUT_NUMBER = re.compile(r"\d,0\d")
"""A number after a comma that begins with 0 as no other does: 0,033 is one, and its comma a decimal one."""

_LOOKED_AT = 1000
"""Lines by which it is known what their commas are."""

_OF_AXIS = re.compile(r"^([xyz])\s*(?:[\[(/_ ].*)?$")
_UNIT = re.compile(r"[\[(/]\s*(mm|cm|m|in|ft)\s*[\])]?$|_(mm|cm|m)$")
"""The title of the column of an axis, and the unit at its end, if it has one: x, x [m], x(in), x_mm."""

_OTHER_TITLES = (
    {"easting": "x", "northing": "y", "elevation": "z", "height": "z", "altitude": "z"},
    {"points:0": "x", "points:1": "y", "points:2": "z"},  # ParaView
    {"points_0": "x", "points_1": "y", "points_2": "z"},
    {"points_m_xyz:0": "x", "points_m_xyz:1": "y", "points_m_xyz:2": "z"},  # VeloView
)
"""Other titles of the columns of x, y and z, as programs of surveyors, ParaView and VeloView write them."""

_IN_A_NAME = re.compile(r"^.*[._ ]([xyz])$")
"""The title of a part of something, as position.x or pos_x."""

_OCTOMAPS = (".bt", ".ot")
"""Endings of files with octrees, whose tools make clouds of them."""

_COLLADA_UP, _ALONG = re.compile(r"<up_axis>\s*([XYZ])_UP"), 0.9
"""The axis up of a COLLADA file, y if it has none; and the cosine from which on a direction is along an axis."""

_MOST_COLUMNS, _OF_POINTS = 8, 20
"""Numbers of a point of an array at most, as x, y, z, intensity, and colours; and times as many points that it has at
least: no depth image is so narrow."""

_NO_UNIT = ""
"""Unit of depths of 8 bits: up to 255 mm no camera measures, so they are in another unit, or shades for the eye."""


def is_cloud(path: Path) -> bool:
    """Return whether a file is a point cloud, by its name."""
    return path.suffix.lower() in CLOUDS


def reads(path: Path, start: bytes) -> str:
    """Return what reads a file with a point cloud or a depth image (`Capability.reads`)."""
    is_other = path.suffix.lower() == ".txt" or is_esri_grid(start.decode("latin-1"))
    form = "" if is_other else CLOUDS.get(path.suffix.lower(), "")
    return f"rsegen scan (for {'a depth image' if form == 'image' else 'a point cloud'})" if form else ""


def read_clouds(
    paths: Sequence[Path],
    values: str | None = None,
    intrinsics: Intrinsics | None = None,
    up: Sequence[float] | None = None,
    topic: str | None = None,
) -> Cloud:
    """Return the points of all files together, metres, in the frame that they share.

    values: the unit of their numbers (m, cm, mm, in, ft); default: m, but mm for depth images with whole numbers.
    intrinsics: for depth images; x is right, y down and z away from the camera. up: nearly the direction up (3,), from
    which meshes are seen; default: found. topic: of a bag, with clouds; default: the only one. A FileError if a file
    has no points.
    """
    with np.errstate(all="ignore"):  # what is no number, or too large for one, is left out when a field is looked for
        read = [_read(path, values, intrinsics, topic) for path in paths]
        meshes = [part for part in read if not isinstance(part, Cloud)]
        clouds = [part for part in read if isinstance(part, Cloud)]
        if meshes:
            clouds.append(_of_meshes(paths, meshes, up))
    doubt = next((cloud.doubt for cloud in clouds if cloud.doubt), "")
    return clouds[-1]._replace(points=np.concatenate([cloud.points for cloud in clouds]), doubt=doubt)


def _read(path: Path, values: str | None, intrinsics: Intrinsics | None, topic: str | None) -> Cloud | trimesh.Trimesh:
    """Return the points of a file, or its mesh, metres."""
    if not is_cloud(path):
        raise FileError(f"{path}: {_instead(path)}")
    form = CLOUDS[path.suffix.lower()]
    if topic is not None and form != "bag":
        raise ParameterError("topic", f"{path} is no bag, and has no topics")
    if values is not None and path.suffix.lower() == ".dae":
        raise ParameterError("values", f"{path} says itself what its unit is; leave it out")
    numbers, usual = _READERS[form](path) if form != "bag" else (_bag(path, topic), "m")
    if values is None and usual == _NO_UNIT:
        raise ParameterError("values", f"{path} has depths of 8 bits, too few for millimetres; set mm, cm, m or in")
    metres = CENTIMETRES[values or usual] / 100
    # A mesh, depths or points: pixels and points are told apart by the last axis, as an array may hold either.
    if not isinstance(numbers, np.ndarray):
        numbers.apply_scale(metres)
        return numbers
    if form == "image" or (numbers.ndim == 2 and numbers.shape[1] != 3):
        points = points_of_depth(path, numbers, intrinsics) * metres
        return Cloud(points, doubt=doubt_of_camera(intrinsics or (), numbers.shape))
    if intrinsics is not None:
        raise ParameterError("intrinsics", f"{path} has points, not the depths of an image")
    return Cloud(np.asarray(numbers.reshape(-1, 3), dtype=np.float64) * metres)


def _instead(path: Path) -> str:
    """Return what to do with a path that is no cloud."""
    if path.suffix.lower() in _OCTOMAPS:
        return "a map of OctoMap; write its points with `octree2pointcloud FILE NEW.pcd`"
    if inside := first_inside(path, is_cloud):
        return f"a folder; use the files in it, such as {inside}"
    return f"clouds are read from files named {', '.join('*' + suffix for suffix in CLOUDS)}"


def _of_meshes(paths: Sequence[Path], meshes: Sequence[trimesh.Trimesh], up: Sequence[float] | None) -> Cloud:
    """Return what is seen of meshes together, as each may be a part of a field: of one level, or one material."""
    import trimesh

    parts = trimesh.util.append_faces([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
    cloud = seen_from_above(trimesh.Trimesh(*parts, process=False), up)
    if not len(cloud.points):
        raise FileError(f"{paths[0]}: has no faces with an area")
    # Who gives an `up` that the format of the file contradicts, and that shows less, has mixed up the axes.
    if up is not None and cloud.clearer is not None:
        for path in paths:
            if (axis := _axis_up(path)) and abs(np.eye(3)["xyz".index(axis)] @ cloud.clearer) > _ALONG:
                raise ParameterError(
                    "up", f"{path} shows less from there than from {axis}, its own axis up; leave it out"
                )
    return cloud


def _axis_up(path: Path) -> str | None:
    """Return the axis that is up in a file by its format: x, y or z; None if the format has none."""
    if path.suffix.lower() == ".dae":
        named = _COLLADA_UP.search(text_of(path, MAX_MESH_MIB, "a mesh"))
        return named[1].lower() if named else "y"
    return "y" if path.suffix.lower() in (".glb", ".gltf") else None


def _array(path: Path) -> tuple[Array, str]:
    """Return points, of which an array may have more than x, y, z, or names for them, or depths."""
    array = mapped(path)
    array = array[..., 0] if array.ndim == 3 and array.shape[2] == 1 else array  # depths with a channel
    fields = {name.lower(): name for name in array.dtype.names or ()}
    if fields.keys() >= set("xyz") and all(array.dtype[fields[axis]].kind in "iuf" for axis in "xyz"):
        _refuse_many(path, array.size)
        return np.stack([array[fields[axis]].ravel() for axis in "xyz"], axis=-1).astype(np.float64), "m"
    if array.ndim in (2, 3) and 3 < array.shape[-1] <= _MOST_COLUMNS and array.size > _OF_POINTS * array.shape[-1] ** 2:
        array = array[..., :3]
    if array.dtype.kind not in "biuf" or not (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3)):
        raise FileError(f"{path}: an array of shape {array.shape}; expected points (n, 3) or depths (rows, columns)")
    if array.ndim == 2 and array.shape[0] == 3 and array.shape[1] > _OF_POINTS:
        raise FileError(f"{path}: an array of shape {array.shape}; use its transpose, points (n, 3)")
    _refuse_many(path, array.size // 3)
    are_depths = array.ndim == 2 and array.shape[1] != 3 and array.dtype.kind in "iu"
    return np.asarray(array), ("mm" if array.itemsize > 1 else _NO_UNIT) if are_depths else "m"


def _image(path: Path) -> tuple[Array, str]:
    with opened_image(path) as image:
        _refuse_many(path, image.width * image.height)
        if image.mode not in ("I", "I;16", "I;16B", "L", "F"):
            raise FileError(
                f"{path}: a {image.mode} image; expected a depth image of one channel (16 bit, millimetres)"
            )
        return numbers_of(image), {"F": "m", "L": _NO_UNIT}.get(image.mode, "mm")


def _text(path: Path) -> tuple[Array, str]:
    """Return the points of lines of numbers by blanks, commas or semicolons, below any titles.

    They are x, y, z and perhaps more, or what the titles name so, in the unit that these say; a comma is a decimal one
    where it cannot be else.
    """
    lines = text_of(path, _MAX_CLOUD_MIB, "a cloud; write it as PLY or PCD").splitlines()
    if is_esri_grid(lines[0] if lines else ""):
        raise FileError(f"{path}: a grid of heights (Esri ASCII), not points; rsegen import reads it")
    first = next((at for at, line in enumerate(lines) if _POINT.match(line)), None)
    if first is None:
        raise FileError(f"{path}: no line has three numbers x, y, z")
    _refuse_many(path, len(lines) - first)
    columns, unit = _columns(path, lines[first - 1] if first else "", lines[first])
    # A comma is the decimal one where lines cannot be read else; 1,2,3,4 alone may be two numbers or four.
    if any(_DECIMAL_COMMAS.match(line) for line in lines[first : first + _LOOKED_AT]):
        lines[first:] = [_A_DECIMAL_COMMA.sub(".", line) for line in lines[first:]]
    elif any(_CUT_NUMBER.search(line) for line in lines[first : first + _LOOKED_AT]):
        raise FileError(f"{path}: commas are in its numbers and between them; write semicolons or blanks between them")
    separator = next((mark for mark in ",;" if mark in lines[first]), None)
    try:
        points = np.loadtxt(lines[first:], delimiter=separator, usecols=columns, ndmin=2, comments=("#", "//"))
    except ValueError as error:
        raise FileError(f"{path}: {library_message(error)}") from None
    return points, unit


def _columns(path: Path, titles: str, line: str) -> tuple[tuple[int, ...], str]:
    """Return the columns of x, y and z by the titles above a line, and their unit; else the first three, in metres."""
    separator = next((mark for mark in ";,\t" if mark in line and mark in titles), None)
    names = [name.strip(" \"'/#").lower() for name in titles.strip(" /#").split(separator)]
    axes, units = _axes(names)
    if len(set("xyz") & set(axes)) < 2:  # one letter may be of a sentence
        if separator and len(names) > 3 and len(names) == line.count(separator) + 1:
            problem = f"none of the titles {shown(titles.strip())} name the columns of x, y and z; name them so"
            raise FileError(f"{path}: {problem}")
        return (0, 1, 2), "m"
    for axis in "xyz":
        if axes.count(axis) != 1:
            raise FileError(
                f"{path}: {axes.count(axis)} of the titles {shown(titles.strip())} name the column of {axis}"
            )
    if len(units) > 1:
        raise FileError(f"{path}: x, y and z are in {' and '.join(sorted(units))}; write all three in one unit")
    return tuple(axes.index(axis) for axis in "xyz"), next(iter(units), "m")


def _axes(names: Sequence[str]) -> tuple[Sequence[str], set[str]]:
    """Return the axis of the column of each title, empty if it has none, and the units of length that titles name."""
    axes = [match[1] if (match := _OF_AXIS.match(name)) else "" for name in names]
    if any(axes):
        found = (_UNIT.search(name) for name, axis in zip(names, axes, strict=True) if axis)
        return axes, {unit[1] or unit[2] for unit in found if unit}
    for known in _OTHER_TITLES:
        if known.keys() & set(names):
            return [known.get(name, "") for name in names], set()
    return [match[1] if (match := _IN_A_NAME.match(name)) else "" for name in names], set()


def _mesh(path: Path) -> tuple[Array | trimesh.Trimesh, str]:
    """Return the points of a cloud, or a mesh; metres if the file has a unit."""

    def read() -> Any:
        import trimesh

        if path.suffix.lower() == ".dae":  # in metres, whatever its unit is
            return trimesh.Trimesh(*read_collada(path), process=False)
        with open_regular(path) as file:
            loaded = loaded_by_trimesh(path, file)
        return loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded

    loaded = read_with(SCAN, path, read)
    if len(getattr(loaded, "faces", ())):
        return loaded, "m"
    return _checked(path, np.asarray(getattr(loaded, "vertices", np.empty((0, 3))))), "m"


def _pcd(path: Path) -> tuple[Array, str]:
    """Return the points of a file of the Point Cloud Library, which pypcd4 reads.

    VIEWPOINT, the pose of the sensor, is not applied, as the readers of that library and of Open3D give the points as
    they are in the file too; programs write points in the frame of the sensor, and in one of several scans.
    """

    def read() -> Array:
        from pypcd4.pypcd4 import MetaData, PointCloud

        with open_regular(path) as file:
            lines = _pcd_header(file)
            header = MetaData.parse_header(lines)
            _refuse_many(path, header.points)
            if sum(header.count) > _MOST_VALUES:
                raise FileError(f"{path}: {sum(header.count):,} values per point; at most {_MOST_VALUES:,} are allowed")
            names = {name.lower(): name for name in header.fields}
            lacking = [axis for axis in "xyz" if axis not in names]
            if lacking:
                raise FileError(f"{path}: no field {lacking[0]} among {', '.join(header.fields[:_MOST_NAMES])}")
            if header.data == "ascii":  # pypcd4 takes each of several blanks for the end of a number
                columns = [sum(header.count[: header.fields.index(names[axis])]) for axis in "xyz"]
                points = np.loadtxt(file, usecols=columns, max_rows=header.points, ndmin=2).reshape(-1, 3)
                if len(points) < header.points:
                    raise FileError(f"{path}: has {len(points):,} of the {header.points:,} points that it says")
                return points
            # The header as it was understood goes before the bytes of the points, for pypcd4 to read both.
            cloud = PointCloud.from_fileobj(BufferedReader(BytesIO("\n".join([*lines, ""]).encode() + file.read())))
            return np.asarray(cloud.numpy([names[axis] for axis in "xyz"]), dtype=np.float64)

    return _checked(path, read_with(SCAN, path, read)), "m"


_RECORDS, _KEYS, _DOUBLES, _WKT = "LASF_Projection", 34735, 34736, 2112
"""Records of a LAS file with the coordinate reference system of its places: as keys of GeoTIFF, or as a text in WKT."""

_IN_METRES = "pdal translate FILE NEW.laz reprojection --filters.reprojection.out_srs={}"
"""The command that projects a laser scan."""

_SAME_UNIT = 1e-5
"""Share by which two units differ that count as one: the US survey foot is longer than a foot by 2e-6."""


def _las(path: Path) -> tuple[Array, str]:
    """Return the points of a laser scan in LAS or LAZ, which laspy reads, and the unit that the file says.

    Its places may be those of a map; heights in another unit than x and y become heights in that one.
    """
    system = CoordinateSystem()

    def read() -> Array:
        import laspy

        nonlocal system

        with open_regular(path) as file:
            _refuse_records(file)
            with laspy.open(file) as reader:
                _refuse_many(path, reader.header.point_count)
                system = _las_system(reader.header)
                refuse_distorted(path, system, tuple(reader.header.mins[:2]), _IN_METRES)
                points = np.asarray(reader.read().xyz, dtype=np.float64)
                if len(points) < reader.header.point_count:
                    raise ValueError(f"has {len(points):,} of the {reader.header.point_count:,} points that it says")
                return points

    # Heights first become lengths in the unit of x and y, as both may differ; that unit is then one with a name.
    points = _checked(path, read_with(SCAN, path, read))
    metres = system.metres or 1.0
    points[:, 2] *= (system.metres_up or metres) / metres
    near = (name for name, length in CENTIMETRES.items() if abs(length / 100 / metres - 1) < _SAME_UNIT)
    if (unit := next(near, None)) is None:
        advice = _IN_METRES.format("EPSG:CODE")
        raise FileError(f"{path}: a unit of its places is {metres:g} m; write them in metres with `{advice}`")
    return points, unit


def _las_system(header: Any) -> CoordinateSystem:
    """Return the coordinate reference system of a laser scan: that of the text, if it has both."""
    records = [*header.vlrs, *(header.evlrs or ())]
    content = {record.record_id: record.record_data_bytes() for record in records if record.user_id == _RECORDS}
    if _WKT in content:
        return of_wkt(content[_WKT].decode("utf-8", "replace"))
    keys, doubles = (
        np.frombuffer(content.get(tag, b""), kind, len(content.get(tag, b"")) // size).tolist()
        for tag, kind, size in ((_KEYS, "<u2", 2), (_DOUBLES, "<f8", 8))
    )
    return of_keys(keys, doubles)


_LAS_RECORD, _LONG_LAS_RECORD = 54, 60
"""Bytes of the header of a variable length record of a LAS file, and of an extended one behind the points."""


def _refuse_records(file: BufferedReader) -> None:
    """Raise a ValueError if the header of a LAS file counts more records than have room: laspy would read each."""
    head = file.read(247).ljust(247, b"\0")
    size = file.seek(0, 2)
    file.seek(0)
    header, points, records = unpack_from("<HII", head, 94)
    behind, long_records = unpack_from("<QI", head, 235) if head[25] >= 4 else (0, 0)  # from version 1.4 on
    for count, room, length in (
        (records, min(points, size) - header, _LAS_RECORD),
        (long_records, size - behind, _LONG_LAS_RECORD),
    ):
        if count * length > max(room, 0):
            raise ValueError(f"its header counts {count:,} records of variable length, for which it has no room")


def _e57(path: Path) -> tuple[Array, str]:
    """Return the points of all scans of a scanner's file, which pye57 reads."""
    return _checked(path, read_with(E57, path, lambda: e57_points(path, partial(_refuse_many, path)))), "m"


def _bag(path: Path, topic: str | None) -> Array:
    """Return the points of a cloud that was recorded, which rosbags reads."""
    return _checked(path, read_with(BAG, path, lambda: bag_points(path, topic, partial(_refuse_many, path))))


_NEEDED = ("FIELDS", "SIZE", "TYPE", "WIDTH", "DATA")
"""Lines that the header of a PCD file has at the least."""


def _pcd_header(file: Iterable[bytes]) -> list[str]:
    """Return the lines of a header up to DATA as pypcd4 takes them; ValueError if one is missing.

    Comments are left out, and what the Point Cloud Library does without is filled in: files of versions .5 and .6 have
    the same content, and one value of each field, one row of points and their number need not be said.
    """
    words: dict[str, str] = {}
    lines = (line.decode().strip() for line in file)
    for line in islice((line for line in lines if line and not line.startswith("#")), _MOST_LINES):
        key, _, value = line.partition(" ")
        words["FIELDS" if key == "COLUMNS" else key] = value
        if key == "DATA":
            break
    if missing := [key for key in _NEEDED if not words.get(key)]:
        raise ValueError(f"no {', '.join(missing)} in its header")
    words["VERSION"] = ".7"
    words.setdefault("COUNT", " ".join("1" for _ in words["FIELDS"].split()))
    words.setdefault("HEIGHT", "1")
    words.setdefault("POINTS", str(int(words["WIDTH"]) * int(words["HEIGHT"])))
    words["DATA"] = words.pop("DATA")  # the last line
    return [f"{key} {value}" for key, value in words.items()]


def _checked(path: Path, points: Array) -> Array:
    """Return points (n, 3); a FileError if there are none, or too many."""
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise FileError(f"{path}: has no points")
    _refuse_many(path, len(points))
    return points


def _refuse_many(path: Path, points: int) -> None:
    if points > MOST_POINTS:
        raise FileError(f"{path}: {points:,} points; at most {MOST_POINTS:,} are allowed")


_READERS: Mapping[str, Callable[[Path], tuple[Array | trimesh.Trimesh, str]]] = MappingProxyType(
    {"text": _text, "mesh": _mesh, "pcd": _pcd, "las": _las, "e57": _e57, "array": _array, "image": _image}
)
"""Readers of files but bags: of points (n, 3), depths (rows, columns), or a mesh, and their usual unit."""
