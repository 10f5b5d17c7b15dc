"""Read what robots recorded of the ground: bags of ROS 2 and ROS 1, and the grid maps in them (grid_map_msgs/GridMap).

A grid map is a matrix per layer, in metres: its rows go along -x and its columns along -y, and it is stored column by
column. While the robot moves, the matrix is not: its first row and column are anywhere, and others go on behind the
last (Fankhauser and Hutter 2016). Its cells that were not seen are nan. Maps grow, so the last one counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from rsegen.errors import FileError, ParameterError, shown
from rsegen.heights import BAG
from rsegen.heights.base import USUAL_UNIT_CM, Heights, refuse_too_many_cells, register
from rsegen.heights.coordinate_system import CellSides
from rsegen.heights.measured import Measured
from rsegen.input_files import open_regular
from rsegen.params.extras import read_with
from rsegen.params.sorts import CENTIMETRES, Text

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array

GRID_MAP, CLOUD = "grid_map_msgs/msg/GridMap", "sensor_msgs/msg/PointCloud2"

_READ_BY = {GRID_MAP: "rsegen import reads grid maps", CLOUD: "rsegen scan reads clouds"}

_DEFINITIONS = {
    "grid_map_msgs/msg/GridMapInfo": """float64 resolution
float64 length_x
float64 length_y
geometry_msgs/Pose pose
""",
    GRID_MAP: """std_msgs/Header header
grid_map_msgs/GridMapInfo info
string[] layers
string[] basic_layers
std_msgs/Float32MultiArray[] data
uint16 outer_start_index
uint16 inner_start_index
""",
}
"""Messages of grid_map for ROS 2, which rosbags does not know, and bags of before ROS 2 Jazzy do not say."""

_MOST_TOPICS = 8
"""Topics, or layers, in a message at most."""

TopicName = Annotated[
    str | None,
    Text(r"[^\s]{1,255}", "the name of a topic", help="topic of a bag with grid maps; default: the only one with any"),
]


@contextmanager
def opened_bag(path: Path) -> Iterator[Any]:
    """An open bag, whose messages can be read; ImportError without rosbags."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    with open_regular(path):  # refuses what is no file; rosbags opens it by its path
        pass
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in _DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    with AnyReader([path], default_typestore=store) as reader:
        yield reader


def connections_of(path: Path, bag: Any, kind: str, topic: str | None, what: str) -> list[Any]:
    """Return the connections of a topic with messages of a kind: the one that is given, or the only one.

    what: such messages in words, for a FileError if there are none, and a ParameterError that names their topics
    """
    types = {connection.topic: connection.msgtype for connection in bag.connections}
    topics = sorted({connection.topic for connection in bag.connections if connection.msgtype == kind})
    if not topics:
        advice = [f"; {text}" for other_kind, text in _READ_BY.items() if other_kind in types.values()]
        raise FileError(
            f"{path}: has no topic with {kind}, but {named(sorted(types)) or 'none at all'}{''.join(advice)}"
        )
    if topic is None and len(topics) > 1:
        raise ParameterError("topic", f"{path} has {what} on {named(topics)}; choose one of them")
    if topic is not None and topic not in topics:
        raise ParameterError("topic", f"{shown(topic)} has no {what} in {path}; {named(topics)} has")
    chosen = topic or topics[0]
    return [connection for connection in bag.connections if (connection.topic, connection.msgtype) == (chosen, kind)]


def named(names: Sequence[str]) -> str:
    """Return some names, and how many more there are."""
    more = len(names) - _MOST_TOPICS
    return ", ".join(names[:_MOST_TOPICS]) + (f" and {more} more" if more > 0 else "")


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Bag(Measured):
    """A grid map in a bag of ROS (grid_map_msgs/GridMap), the last one on its topic, in metres; nan are holes."""

    name: ClassVar[str] = "bag of ROS"
    suffixes: ClassVar[tuple[str, ...]] = (".mcap", ".db3", ".bag")

    topic: TopicName = None
    layer: Annotated[str, Text(r"[^\s]{1,255}", "the name of a layer", help="layer with the heights")] = "elevation"

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights of the layer in the last message that has any."""
        heights, resolution = read_with(BAG, path, lambda: self._last(path))
        cells = CellSides(resolution, resolution, 1.0) if resolution > 0 else None
        return self.measured(path, heights * CENTIMETRES["m"], unit_cm or USUAL_UNIT_CM, cells=cells)

    def _last(self, path: Path) -> tuple[Array, float]:
        """Return the heights (n_x, n_y) of the last message, metres, and the side of its cells."""
        with opened_bag(path) as bag:
            chosen = connections_of(path, bag, GRID_MAP, self.topic, "grid maps")
            last = None
            # Only the last message is decoded: each may have millions of cells.
            for connection, _, raw in bag.messages(connections=chosen):
                last = connection, raw
            if last is None:
                raise FileError(f"{path}: no message on {chosen[0].topic}")
            message = bag.deserialize(last[1], last[0].msgtype)
        layers = list(message.layers)
        if self.layer not in layers[: len(message.data)]:
            raise ParameterError("layer", f"{shown(self.layer)} is none of {path}, which has {named(layers) or 'none'}")
        return _heights(path, message, message.data[layers.index(self.layer)]), float(message.info.resolution)


def _heights(path: Path, message: Any, layer: Any) -> Array:
    """Return a layer as heights (n_x, n_y), x and y ascending; ValueError if its sizes do not fit its numbers."""
    import numpy as np

    sizes = {dimension.label: int(dimension.size) for dimension in layer.layout.dim}
    n_x, n_y = sizes.get("row_index", 0), sizes.get("column_index", 0)
    refuse_too_many_cells(path, n_x, n_y)
    numbers = np.asarray(layer.data, dtype=np.float64)[int(layer.layout.data_offset) :]
    if len(numbers) != n_x * n_y:
        raise ValueError(f"a layer has {len(numbers):,} numbers for {n_x} x {n_y} cells")
    is_by_rows = layer.layout.dim[0].label == "row_index"
    matrix = numbers.reshape((n_x, n_y), order="C" if is_by_rows else "F")
    starts = int(message.outer_start_index), int(message.inner_start_index)
    # The first row and column come to the start; they have the largest x and y, so both axes are reversed.
    ordered = np.roll(matrix, [-start for start in starts], axis=(0, 1))[::-1, ::-1]
    return np.where(np.isfinite(ordered), ordered, np.nan)
