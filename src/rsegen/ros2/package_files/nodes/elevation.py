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
