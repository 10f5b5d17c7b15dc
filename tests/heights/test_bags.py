"""Grid maps in bags of ROS: the heights of a layer come back, whatever the order of their numbers."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.field.stepfield import Array
from rsegen.heights.bags import CLOUD, GRID_MAP, Bag
from rsegen.heights.base import heights_in, reads
from rsegen.recipe.recipe_file import load
from tests.support.bags import write_bag

INFO = "grid_map_msgs/msg/GridMapInfo"
SIZES = "float64 resolution\nfloat64 length_x\nfloat64 length_y\ngeometry_msgs/Pose pose\n"
REST = "string[] layers\nstring[] basic_layers\nstd_msgs/Float32MultiArray[] data\n"
REST += "uint16 outer_start_index\nuint16 inner_start_index\n"
HUMBLE, NOETIC = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS1_NOETIC)
HUMBLE.register(get_types_from_msg(SIZES, INFO))
HUMBLE.register(get_types_from_msg(f"std_msgs/Header header\ngrid_map_msgs/GridMapInfo info\n{REST}", GRID_MAP))
NOETIC.register(get_types_from_msg(f"std_msgs/Header header\n{SIZES}", INFO))
NOETIC.register(get_types_from_msg(f"grid_map_msgs/GridMapInfo info\n{REST}", GRID_MAP))

bag = partial(write_bag, store=HUMBLE)

LEVELS = np.random.default_rng(4).integers(0, 5, (7, 4)).astype(np.float64)


def message(
    levels: Array = LEVELS,
    start: tuple[int, int] = (0, 0),
    order: Literal["C", "F"] = "F",
    store: Any = HUMBLE,
    **other: Any,
) -> Any:
    """A grid map whose first row and column in memory are not those of the map; order: F by columns, C by rows."""
    kinds = store.types
    matrix = np.roll(levels[::-1, ::-1] * 0.1, start, axis=(0, 1)).astype("f4")
    dimension, layout = kinds["std_msgs/msg/MultiArrayDimension"], kinds["std_msgs/msg/MultiArrayLayout"]
    sizes = [
        dimension(label=label, size=size, stride=0)
        for label, size in zip(("row_index", "column_index"), matrix.shape, strict=True)
    ]
    layer = kinds["std_msgs/msg/Float32MultiArray"](
        layout=layout(dim=sizes if order == "C" else sizes[::-1], data_offset=0), data=matrix.ravel(order=order)
    )
    time = kinds["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    more = {"seq": 0} if store is NOETIC else {}
    header = kinds["std_msgs/msg/Header"](stamp=time, frame_id="odom", **more)
    pose = kinds["geometry_msgs/msg/Pose"](
        position=kinds["geometry_msgs/msg/Point"](x=3.0, y=-2.0, z=0.0),
        orientation=kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    info = {"resolution": 0.05, "length_x": 0.35, "length_y": 0.2, "pose": pose}
    values = {"layers": ["variance", "elevation"], "basic_layers": ["elevation"], "data": [layer, layer], **other}
    values |= {"outer_start_index": start[0], "inner_start_index": start[1]}
    if store is NOETIC:
        return kinds[GRID_MAP](info=kinds[INFO](header=header, **info), **values)
    return kinds[GRID_MAP](header=header, info=kinds[INFO](**info), **values)


def ros1(path: Path) -> Path:
    with Ros1Writer(path) as writer:
        connection = writer.add_connection("/elevation_map", GRID_MAP, typestore=NOETIC)
        content = message(start=(2, 1), store=NOETIC)
        writer.write(connection, 1, NOETIC.serialize_ros1(content, GRID_MAP))
    return path


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "old.db3", "a.bag"])
@pytest.mark.parametrize("order", ["F", "C"])
def test_the_levels_of_the_last_grid_map_come_back(name: str, order: Literal["C", "F"], tmp_path: Path) -> None:
    path = tmp_path / name
    if name == "a.bag":
        ros1(path)
    else:
        messages = [message(LEVELS * 0), message(start=(5, 3), order=order)]
        bag(path, {"/elevation_map": messages}, 8 if name == "old.db3" else 9)
    heights = heights_in(path, Bag(), 10)
    np.testing.assert_array_equal(heights.levels, LEVELS)
    assert LEVELS.any()
    assert heights.recipe_values == {"block_width_cm": pytest.approx(5)}
    assert reads(path, b"") == "rsegen import (for heights)"


def test_a_grid_map_is_imported_with_its_holes_filled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seen = LEVELS.copy()
    seen[3, 2] = np.nan
    seen[0, 0] = np.inf
    path = bag(tmp_path / "a.mcap", {"/ground": [message(seen)]})
    with pytest.raises(FileError, match=r"nan cm is a hole \(1 more such cell\); fill_holes"):
        heights_in(path, Bag(), 10)
    assert main(["import", str(path), "--fill-holes", "-o", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr()
    assert "2 holes filled from the neighbours" in shown.out + shown.err
    recipe = load(tmp_path / "out/a_0000/recipe.json")
    assert recipe.block_width_cm == pytest.approx(5)
    known = np.isfinite(seen)
    np.testing.assert_array_equal(rsegen.build(recipe, recipe.first_map).levels[known], LEVELS[known])


def test_a_topic_and_a_layer_are_chosen_where_there_are_several(tmp_path: Path) -> None:
    path = bag(tmp_path / "a.db3", {"/a": [message(LEVELS * 0)], "/b": [message(layers=["rough", "top"])]})
    np.testing.assert_array_equal(heights_in(path, Bag(topic="/b", layer="top"), 10).levels, LEVELS)
    for reading, name, said in (
        (Bag(), "topic", "has grid maps on /a, /b; choose one of them"),
        (Bag(topic="/c"), "topic", "'/c' has no grid maps in "),
        (Bag(topic="/b"), "layer", "'elevation' is none of .*, which has rough, top"),
    ):
        with pytest.raises(ParameterError, match=f"^{name}: .*{said}"):
            heights_in(path, reading)


def test_a_bag_without_grid_maps_says_who_reads_it(tmp_path: Path) -> None:
    field = HUMBLE.types["sensor_msgs/msg/PointField"]("x", 0, 7, 1)
    header = message().header
    cloud = HUMBLE.types[CLOUD](header, 1, 1, [field], False, 4, 4, np.zeros(4, "u1"), is_dense=True)  # noqa: FBT003  # its arguments by their order
    for name, messages, said in (
        ("cloud.mcap", {"/points": [cloud]}, f"no topic with {GRID_MAP}, but /points; rsegen scan reads clouds"),
        ("other.mcap", {"/heads": [header]}, f"no topic with {GRID_MAP}, but /heads"),
    ):
        with pytest.raises(FileError) as refused:
            heights_in(bag(tmp_path / name, messages), Bag())
        assert str(refused.value) == f"{tmp_path / name}: has {said}"
    grid = bag(tmp_path / "grid.mcap", {"/ground": [message()]})
    with pytest.raises(FileError, match=r"has no topic with .*PointCloud2, but /ground; rsegen import reads grid maps"):
        rsegen.scan(grid)
    with pytest.raises(
        FileError, match=r"grid_folder: a folder; use the files in it, such as .*grid_folder/again.mcap"
    ):
        rsegen.scan(grid.rename(tmp_path / "grid_folder/again.mcap").parent)


def test_a_damaged_grid_map_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    short = message()
    short.data[1].data = short.data[1].data[:-1]
    huge = message()
    for dimension in huge.data[1].layout.dim:
        dimension.size = 2**31
    empty = message()
    empty.data[1].layout.dim = []
    for name, content, said in (
        ("short.mcap", short, r"not a MCAP file that can be read \(a layer has 27 numbers for 7 x 4 cells\)"),
        ("huge.mcap", huge, "2147483648 x 2147483648 cells; from 1 up to"),
        ("empty.mcap", empty, "0 x 0 cells; from 1 up to"),
    ):
        with pytest.raises(FileError, match=rf"{name}: {said}") as refused:
            heights_in(bag(tmp_path / name, {"/ground": [content]}), Bag())
        assert "\n" not in str(refused.value)
    for module in [module for module in sys.modules if module.partition(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(UserError, match=r"needs rosbags.*, which is not installed; .* -m pip install"):
        heights_in(tmp_path / "short.mcap", Bag())
