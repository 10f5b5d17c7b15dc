"""Points of what sensors record: laser scanners in E57 files, and PointCloud2 messages in bags of ROS 2 and ROS 1.

A file of a scanner has scans from several places, each with its pose; all of them count. A bag has a topic's messages
one after the other, each in the frame of its sensor, which may have moved: the first one with points counts.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rsegen.errors import FileError, ParameterError, shown
from rsegen.field.stepfield import Array
from rsegen.input_files import open_regular

_CLOUD = "sensor_msgs/msg/PointCloud2"

_NUMBERS = ("", "i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
"""Types of a field's numbers, by their codes in PointField."""

_MOST_TOPICS = 8
"""Topics in a message at most."""

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
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with open_regular(path):
        pass
    # Bags of before ROS 2 Jazzy do not say what their messages are made of.
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        clouds = [connection for connection in reader.connections if connection.msgtype == _CLOUD]
        name = _topic(path, topic, sorted({cloud.topic for cloud in clouds}), [c.topic for c in reader.connections])
        chosen = [cloud for cloud in clouds if cloud.topic == name]
        for connection, _, raw in reader.messages(connections=chosen):
            points = _points_of(reader.deserialize(raw, connection.msgtype), check)
            if len(points):
                return points
    raise FileError(f"{path}: no message of {name} has points")


def _topic(path: Path, topic: str | None, clouds: list[str], others: list[str]) -> str:
    """Return the topic that is read: the one that is given, or the only one with clouds."""
    if not clouds:
        raise FileError(f"{path}: has no topic with {_CLOUD}, but {_named(sorted(set(others))) or 'none at all'}")
    if topic is None and len(clouds) > 1:
        raise ParameterError("topic", f"{path} has clouds on {_named(clouds)}; choose one of them")
    if topic is not None and topic not in clouds:
        raise ParameterError("topic", f"{shown(topic)} has no clouds in {path}; {_named(clouds)} has")
    return topic or clouds[0]


def _named(topics: list[str]) -> str:
    more = len(topics) - _MOST_TOPICS
    return ", ".join(topics[:_MOST_TOPICS]) + (f" and {more} more" if more > 0 else "")


def _points_of(message: Any, check: Check) -> Array:
    """Return the points of a message (n, 3) that are numbers; ValueError if its fields do not fit its bytes."""
    rows, columns = int(message.height), int(message.width)
    check(rows * columns)
    fields = {field.name: field for field in message.fields}
    lacking = [axis for axis in "xyz" if axis not in fields]
    if lacking:
        raise ValueError(f"its points have no {lacking[0]}, but {', '.join(list(fields)[:_MOST_TOPICS])}")
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
