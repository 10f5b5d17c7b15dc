"""The node of a ROS 2 package that publishes a grid_map, run with stand-ins for ROS's modules.

Its message is read as grid_map_core reads it; that library itself, the rest of the message and CDR were tried by hand
(docs/ros2.md).
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rsegen import Recipe, Scene, compose
from rsegen.ros2.elevation import layer_files
from tests.formats.maps import RANDOM, SCENES
from tests.ros2.test_ros2 import SLIPPERY, written


def grid_map() -> SimpleNamespace:
    """An empty message, with the fields of grid_map_msgs/GridMap."""
    pose = SimpleNamespace(position=SimpleNamespace(x=0.0, y=0.0, z=0.0), orientation=SimpleNamespace(w=0.0))
    return SimpleNamespace(
        header=SimpleNamespace(frame_id="", stamp=None),
        info=SimpleNamespace(resolution=0.0, length_x=0.0, length_y=0.0, pose=pose),
        layers=[],
        basic_layers=[],
        data=[],
        outer_start_index=0,
        inner_start_index=0,
    )


def message_of(folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, str, dict[str, Any]]:
    """Run the node of the package on one of its maps; its message, the topic and its quality of service."""
    said: list[Any] = []
    topics: list[tuple[str, dict[str, Any]]] = []

    class Node:
        def __init__(self, name: str) -> None:
            self.name = name

        def declare_parameter(self, name: str, default: str) -> SimpleNamespace:
            return SimpleNamespace(value=str(folder) if name == "folder" else default)

        def create_publisher(self, kind: object, topic: str, qos: dict[str, Any]) -> SimpleNamespace:
            topics.append((topic, qos))
            return SimpleNamespace(publish=said.append)

        def get_clock(self) -> SimpleNamespace:
            return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: "now"))

        def destroy_node(self) -> None:
            pass

    def array() -> SimpleNamespace:
        return SimpleNamespace(layout=SimpleNamespace(dim=[], data_offset=0), data=None)

    modules: dict[str, dict[str, Any]] = {
        "grid_map_msgs": {},
        "grid_map_msgs.msg": {"GridMap": grid_map},
        "std_msgs": {},
        "std_msgs.msg": {"Float32MultiArray": array, "MultiArrayDimension": SimpleNamespace},
        "rclpy": {"init": lambda: None, "spin": lambda node: None, "try_shutdown": lambda: None},
        "rclpy.executors": {"ExternalShutdownException": KeyboardInterrupt},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"DurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL="latched"), "QoSProfile": dict},
    }
    for name, members in modules.items():
        module = ModuleType(name)
        vars(module).update(members)
        monkeypatch.setitem(sys.modules, name, module)
    runpy.run_path(str(folder.parents[1] / "nodes" / "elevation.py"), run_name="__main__")
    ((topic, qos),) = topics
    (message,) = said
    return message, topic, qos


def at(message: Any, layer: str, x: float, y: float) -> float:
    """The value at a place as grid_map_core finds it: indices count from the corner of the largest x and y."""
    info, values = message.info, message.data[message.layers.index(layer)]
    columns, rows = values.layout.dim
    assert (columns.label, rows.label) == ("column_index", "row_index")
    assert (columns.stride, rows.stride) == (rows.size * columns.size, rows.size)
    row = int((info.length_x / 2 - x) / info.resolution)
    column = int((info.length_y / 2 - y) / info.resolution)
    return float(values.data[column * rows.stride + row])


@pytest.mark.parametrize("scene", [*SCENES.values(), SLIPPERY], ids=[*SCENES, "several frictions"])
def test_a_grid_map_has_the_height_and_friction_of_every_cell(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    message, topic, qos = message_of(written(scene, tmp_path) / "maps" / scene.name, monkeypatch)
    assert (topic, qos) == ("elevation", {"depth": 1, "durability": "latched"})
    assert (message.header.frame_id, message.layers) == ("map", ["elevation", "friction"])
    assert message.info.pose.orientation.w == 1
    field, rng = scene.field, np.random.default_rng(0)
    edges_x, edges_y = field.edges()
    for i, j in np.ndindex(field.shape):
        for along, across in rng.uniform(0.01, 0.99, (3, 2)):
            x = edges_x[i] + along * (edges_x[i + 1] - edges_x[i])
            y = edges_y[j] + across * (edges_y[j + 1] - edges_y[j])
            assert at(message, "elevation", x, y) == np.float32(field.heights[i, j])
            if field.levels[i, j]:
                assert at(message, "friction", x, y) == np.float32(scene.friction_of(int(field.levels[i, j])))
    assert at(message, "elevation", edges_x[0] - 1, 0) == 0
    assert at(message, "friction", edges_x[0] - 1, 0) == np.float32(scene.friction)


def test_a_large_map_has_one_point_per_cell() -> None:
    scene = compose(Recipe(seed=3, chunk_size=1000, boundary="none", obstacles=(RANDOM,)))
    files = layer_files(scene, 0)
    assert b'"points_per_cell": 1' in files["elevation.json"][0]
