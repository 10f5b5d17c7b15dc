"""The map as a grid_map for elevation mapping: its layers as files, and the node of a package that publishes them.

    StepField --layers--> elevation.npy, friction.npy, elevation.json --NODE, in the package--> grid_map_msgs/GridMap

The arrays have one value per cell, with free ground around the map; the node repeats them, so that steps stay steep
between the points of a grid_map, which RViz joins by slopes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rsegen.formats.encoded import as_json, npy
from rsegen.scene.scene import Scene

_MOST_POINTS = 1_000_000
"""Points of a grid_map at the most, if that leaves one per cell: a message of 8 MB with two layers."""

_PER_CELL = 5
"""Points along each side of a cell: 2 cm apart for blocks of 10 cm."""


def layer_files(scene: Scene, margin: int) -> Mapping[str, list[bytes]]:
    """Return the files of a map with `margin` cells of ground around it; heights in metres above the ground."""
    field = scene.field
    levels = np.where(field.frame, -1, field.levels)
    friction = np.full(field.shape, scene.friction, dtype=np.float32)  # of the ground, level 0
    for level in np.unique(levels[levels != 0]).tolist():
        friction[levels == level] = scene.friction_of(max(level, 0))
    layers = {
        "elevation": np.pad(field.heights.astype(np.float32), margin),
        "friction": np.pad(friction, margin, constant_values=scene.friction),
    }
    points = max(1, min(_PER_CELL, int((_MOST_POINTS / layers["elevation"].size) ** 0.5)))
    about = {
        "axes": "axis 0 along +x, axis 1 along +y; the middle of the arrays is the origin of the frame map",
        "cell_size": field.block_width,
        "points_per_cell": points,
        "layers": list(layers),
    }
    return {"elevation.json": [as_json(about)], **{f"{name}.npy": [npy(values)] for name, values in layers.items()}}


NODE = '''\
"""
Publish a map as grid_map_msgs/GridMap on /elevation: its true heights and friction.

It is published once and stays there for late subscribers (transient local).
"""

from array import array
import json
from pathlib import Path

from grid_map_msgs.msg import GridMap
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32MultiArray, MultiArrayDimension


class Elevation(Node):
    """A node that publishes the layers in the folder of a map."""

    def __init__(self):
        """Read the files and publish them."""
        super().__init__('elevation')
        folder = Path(self.declare_parameter('folder', '.').value)
        frame = self.declare_parameter('frame_id', 'map').value
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.publisher = self.create_publisher(GridMap, 'elevation', latched)
        message = grid_map(folder)
        message.header.frame_id = frame
        message.header.stamp = self.get_clock().now().to_msg()
        self.publisher.publish(message)


def grid_map(folder):
    """Return the message with the layers in a folder; its middle is the origin of the map."""
    about = json.loads((folder / 'elevation.json').read_text())
    points = about['points_per_cell']
    message = GridMap()
    message.info.resolution = about['cell_size'] / points
    message.info.pose.orientation.w = 1.0
    for layer in about['layers']:
        values = np.load(folder / f'{layer}.npy').repeat(points, axis=0).repeat(points, axis=1)
        message.layers.append(layer)
        message.data.append(matrix(values))
    rows, columns = values.shape
    message.info.length_x = rows * message.info.resolution
    message.info.length_y = columns * message.info.resolution
    message.basic_layers = ['elevation']
    return message


def matrix(values):
    """
    Return values (n_x, n_y) as the matrix of a grid_map.

    Its rows go along -x and its columns along -y, and it is stored column by column.
    """
    rows, columns = values.shape
    message = Float32MultiArray()
    message.layout.dim = [
        MultiArrayDimension(label='column_index', size=columns, stride=rows * columns),
        MultiArrayDimension(label='row_index', size=rows, stride=rows),
    ]
    message.data = array('f', values[::-1, ::-1].tobytes(order='F'))
    return message


def main():
    """Publish until the node is stopped."""
    rclpy.init()
    node = Elevation()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
'''
