"""Points of what sensors record: laser scanners in E57 files, and PointCloud2 messages in bags of ROS 2 and ROS 1.

A file of a scanner has scans from several places, each with its pose; all of them count. A bag has a topic's messages
one after the other, each in the frame of its sensor, which may have moved: the first one with points counts.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.heights.bags import CLOUD, connections_of, named, opened_bag
from rsegen.input_files import open_regular

_NUMBERS = ("", "i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
"""Types of a field's numbers, by their codes in PointField."""

Check = Callable[[int], None]
"""Raises a FileError for a number of points that is too large."""


def e57_points(path: Path, check: Check) -> Array:
    """Return the points of all scans of a file (n, 3), metres, in its frame; ImportError without pye57."""
    import pye57

    with open_regular(path):  # pye57 opens it again, by its name
        pass
    file = pye57.E57(str(path))
    try:
        check(sum(file.get_header(number).point_count for number in range(file.scan_count)))
        scans = [file.read_scan(number, ignore_missing_fields=True) for number in range(file.scan_count)]
    finally:
        file.close()
    names = [f"cartesian{axis}" for axis in "XYZ"]  # pye57 makes them of spherical ones too
    return np.concatenate(
        [np.empty((0, 3)), *(np.stack([scan[name] for name in names], axis=1).astype(np.float64) for scan in scans)]
    )


def bag_points(path: Path, topic: str | None, check: Check) -> Array:
    """Return the points (n, 3), metres, of the first message of a topic that has any; ImportError without rosbags.

    topic: None for the only one with clouds; a ParameterError that names them if there are several, or it is none.
    """
    with opened_bag(path) as bag:
        chosen = connections_of(path, bag, CLOUD, topic, "clouds")
        for connection, _, raw in bag.messages(connections=chosen):
            points = _points_of(bag.deserialize(raw, connection.msgtype), check)
            if len(points):
                return points
    raise FileError(f"{path}: no message of {chosen[0].topic} has points")


def _points_of(message: Any, check: Check) -> Array:
    """Return the points of a message (n, 3) that are numbers; ValueError if its fields do not fit its bytes."""
    rows, columns = int(message.height), int(message.width)
    check(rows * columns)
    fields = {field.name: field for field in message.fields}
    lacking = [axis for axis in "xyz" if axis not in fields]
    if lacking:
        raise ValueError(f"its points have no {lacking[0]}, but {named(list(fields))}")
    order = ">" if message.is_bigendian else "<"
    kind = np.dtype(
        {
            "names": list("xyz"),
            "formats": [order + _NUMBERS[fields[axis].datatype] for axis in "xyz"],
            "offsets": [fields[axis].offset for axis in "xyz"],
            "itemsize": message.point_step,
        }
    )
    data = np.ascontiguousarray(message.data, dtype=np.uint8)
    table = np.ndarray((rows, columns), kind, data, strides=(message.row_step, message.point_step))
    points = np.stack([table[axis].ravel().astype(np.float64) for axis in "xyz"], axis=1)
    return np.asarray(points[np.isfinite(points).all(axis=1)])
