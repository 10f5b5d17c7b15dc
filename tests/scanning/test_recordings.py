"""Scans of laser scanners, bags of ROS, and meshes of several parts: the levels of the field in them come back."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pye57
import pytest
import trimesh
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_typestore

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.field.stepfield import Array
from rsegen.scanning.clouds import read_clouds
from rsegen.scanning.meshes import seen_from_above
from tests.scanning.test_meshes import LEVELS, blocks, slab
from tests.support.bags import write_bag

POINTS = seen_from_above(slab(0.02), (0, 0, 1)).points[:60_000]

HUMBLE, NOETIC = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS1_NOETIC)
CLOUD = "sensor_msgs/msg/PointCloud2"
bag = partial(write_bag, store=HUMBLE)


def scanner(path: Path, *places: Sequence[float]) -> None:
    """One scan from each place, each with a part of the points, in a frame that is turned by 90 degrees about z."""
    file = pye57.E57(str(path), mode="w")
    for number, place in enumerate(places):
        part = POINTS[number :: len(places)] - place
        local = np.stack([part[:, 1], -part[:, 0], part[:, 2]], axis=1)
        names = [f"cartesian{axis}" for axis in "XYZ"]
        data = {name: np.ascontiguousarray(values) for name, values in zip(names, local.T, strict=True)}
        half = np.sqrt(0.5)
        file.write_scan_raw(data, rotation=np.array([half, 0, 0, half]), translation=np.array(place, float))
    file.close()


def spherical(path: Path, place: Sequence[float]) -> None:
    """One scan as ranges, azimuths and elevations around a scanner, as many terrestrial ones store it."""
    file = pye57.E57(str(path), mode="w")
    image, make = file.image_file, pye57.libe57
    away = POINTS - place
    local = np.stack([away[:, 1], -away[:, 0], away[:, 2]], axis=1)  # turned by 90 degrees about z
    distance = np.linalg.norm(local, axis=1)
    columns = {
        "sphericalRange": distance,
        "sphericalAzimuth": np.arctan2(local[:, 1], local[:, 0]),
        "sphericalElevation": np.arcsin(local[:, 2] / distance),
    }
    scan, prototype, pose = (make.StructureNode(image) for _ in range(3))
    scan.set("guid", make.StringNode(image, "{one}"))
    buffers = make.VectorSourceDestBuffer()
    for name, values in columns.items():
        prototype.set(name, make.FloatNode(image, 0.0, make.E57_DOUBLE, -1e3, 1e3))
        columns[name] = np.ascontiguousarray(values)
        buffers.append(make.SourceDestBuffer(image, name, columns[name], len(values), True, True))  # noqa: FBT003  # its arguments have no names
    for name, numbers in (("rotation", {"w": 0.5**0.5, "x": 0, "y": 0, "z": 0.5**0.5}), ("translation", None)):
        node = make.StructureNode(image)
        for axis, value in (numbers or dict(zip("xyz", place, strict=True))).items():
            node.set(axis, make.FloatNode(image, float(value)))
        pose.set(name, node)
    scan.set("pose", pose)
    points = make.CompressedVectorNode(image, prototype, make.VectorNode(image, True))  # noqa: FBT003  # likewise
    scan.set("points", points)
    file.data3d.append(scan)
    writer = points.writer(buffers)
    writer.write(len(POINTS))
    writer.close()
    file.close()


def message(points: Array, store: Any = HUMBLE, form: str = "<f4", padding: int = 0) -> Any:
    """A cloud with an intensity, and bytes that nothing uses, in rows of 100 points."""
    kind = np.dtype([("intensity", "u1"), *((axis, form) for axis in "zyx"), ("unused", "u1", (3,))])
    rows = len(points) // 100
    table = np.zeros((rows, 100), kind)
    for axis, values in zip("xyz", points[: rows * 100].T, strict=True):
        table[axis] = values.reshape(rows, 100)
    lines = np.zeros((rows, 100 * kind.itemsize + padding), np.uint8)
    lines[:, : 100 * kind.itemsize] = table.view(np.uint8).reshape(rows, 100 * kind.itemsize)
    types = store.types
    fields = [
        types["sensor_msgs/msg/PointField"](name, kind.fields[name][1], code, 1)  # type: ignore[index]  # it has fields
        for name, code in (("intensity", 2), *((axis, {"f4": 7, "f8": 8}[form[1:]]) for axis in "zyx"))
    ]
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    more = {"seq": 0} if store is NOETIC else {}
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera", **more)
    return types[CLOUD](
        header, rows, 100, fields, form[0] == ">", kind.itemsize, lines.shape[1], lines.ravel(), is_dense=True
    )


def ros1(path: Path) -> None:
    with Ros1Writer(path) as writer:
        connection = writer.add_connection("/camera/points", CLOUD, typestore=NOETIC)
        writer.write(connection, 1, NOETIC.serialize_ros1(message(POINTS, NOETIC), CLOUD))


def parts() -> trimesh.Scene:
    """A scene of boxes, each an object at its place: their meshes are in the middle."""
    scene = trimesh.Scene()
    for number, part in enumerate(slab(0.02).split()):
        middle = part.bounds.mean(axis=0)
        place = trimesh.transformations.translation_matrix(middle)
        scene.add_geometry(part.apply_translation(-middle), node_name=f"block{number}", transform=place)
    return scene


def gltf(path: Path) -> None:
    for name, content in trimesh.exchange.gltf.export_gltf(parts()).items():
        (path.parent / (path.name if name.endswith("gltf") else name)).write_bytes(content)


def objects(path: Path) -> None:
    """An OBJ with an object for each block, whose corners are numbered through all of them."""
    lines, before = ["mtllib none.mtl"], 1
    for number, part in enumerate(slab(0.02).split()):
        lines.append(f"o block{number}")
        lines.append(f"usemtl colour{number % 3}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in part.faces + before]
        before += len(part.vertices)
    path.write_text("\n".join(lines) + "\n")


def collada(path: Path, unit: str = "1", scale: float = 1.0) -> None:
    """A COLLADA file of pycollada, whose numbers are in a unit of its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # pycollada's, by numpy 2.5
        content = slab(0.02).apply_scale(scale).export(file_type="dae").decode()
    assert content.count("<asset>") == 1
    path.write_text(re.sub(r"<unit [^>]*>", "", content).replace("<asset>", f'<asset><unit meter="{unit}"/>'))


WRITERS: Mapping[str, Callable[[Path], Any]] = {
    "one.e57": lambda path: scanner(path, (0, 0, 0)),
    "spherical.e57": lambda path: spherical(path, (3, -1, 1)),
    "three.e57": lambda path: scanner(path, (0, 0, 0), (3, -1, 1), (-2, 4, 0.5)),
    "one.mcap": lambda path: bag(path, {"/points": [message(POINTS)]}),
    "padded.db3": lambda path: bag(path, {"/points": [message(POINTS, padding=7)]}),
    "empty_first.mcap": lambda path: bag(path, {"/points": [message(POINTS[:0]), message(POINTS)]}),
    "big_endian.db3": lambda path: bag(path, {"/points": [message(POINTS, form=">f8")]}),
    "ros1.bag": ros1,
    "parts.gltf": gltf,
    "parts.glb": lambda path: path.write_bytes(parts().export(file_type="glb")),
    "objects.obj": objects,
    "metres.dae": collada,
    "centimetres.DAE": lambda path: collada(path, "0.01", 100),
}
CLOUDS = [name for name in WRITERS if name.endswith(("e57", "mcap", "db3", "bag"))]


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("name", ["one.e57", "one.mcap", *(name for name in WRITERS if name not in CLOUDS)])
def test_the_levels_of_a_recording_come_back(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    scan = rsegen.scan(tmp_path / name).scan
    assert scan.unit == 0.1
    assert scan.block_width == 0.1
    assert any(np.array_equal(np.rot90(scan.blocks, turns), LEVELS) for turns in range(4))


@pytest.mark.parametrize("name", CLOUDS)
def test_the_points_of_a_recording_come_back(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    found = read_clouds([tmp_path / name]).points
    assert len(found) == len(POINTS)
    assert np.abs(np.sort(found, axis=0) - np.sort(POINTS, axis=0)).max() < 1e-5


def test_a_topic_is_chosen_where_a_bag_has_several(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "two.mcap"
    bag(path, {"/left": [message(POINTS)], "/right": [message(POINTS + 1)], "/far": [message(POINTS[:0])]})
    assert np.allclose(np.sort(read_clouds([path], topic="/right").points, axis=0), np.sort(POINTS + 1, axis=0))
    with pytest.raises(ParameterError, match=r"has clouds on /far, /left, /right; choose one of them"):
        read_clouds([path])
    with pytest.raises(ParameterError, match=r"'/up' has no clouds in .*; /far, /left, /right has"):
        read_clouds([path], topic="/up")
    with pytest.raises(FileError, match="no message of /far has points"):
        read_clouds([path], topic="/far")
    assert main(["scan", str(path), "--topic", "/up", "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.startswith("rsegen")
    assert not (tmp_path / "out").exists()


def test_what_is_no_recording_is_refused_in_one_line(tmp_path: Path) -> None:
    header = HUMBLE.types["std_msgs/msg/Header"](
        stamp=HUMBLE.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id=""
    )
    bag(tmp_path / "other.mcap", {"/heads": [header]})
    flat = message(POINTS)
    flat.fields.pop()
    bag(tmp_path / "flat.db3", {"/points": [flat]})
    short = message(POINTS)
    short.data = short.data[:1000]
    bag(tmp_path / "short.db3", {"/points": [short]})
    for name in ("broken.e57", "broken.mcap", "broken.db3", "broken.bag"):
        (tmp_path / name).write_bytes(b"ASTM-E57" + bytes(90))
    np.savetxt(tmp_path / "points.xyz", POINTS[:100])
    for name, said in {
        "other.mcap": "has no topic with sensor_msgs/msg/PointCloud2, but /heads",
        "flat.db3": "its points have no x, but intensity, z, y",
        "short.db3": "not a DB3 file that can be read",
        "broken.e57": "not a E57 file that can be read",
        "broken.mcap": "not a MCAP file that can be read",
        "broken.db3": "not a DB3 file that can be read",
        "broken.bag": "not a BAG file that can be read",
    }.items():
        with pytest.raises(FileError) as refused:
            read_clouds([tmp_path / name])
        assert said in str(refused.value)
        assert "\n" not in str(refused.value)
    collada(tmp_path / "cm.dae", "0.01", 100)
    with pytest.raises(ParameterError, match="says itself what its unit is"):
        read_clouds([tmp_path / "cm.dae"], values="cm")
    with pytest.raises(ParameterError, match="is no bag, and has no topics"):
        read_clouds([tmp_path / "points.xyz"], topic="/points")


@pytest.mark.parametrize(("name", "library"), [("one.e57", "pye57"), ("one.mcap", "rosbags")])
def test_a_library_that_is_missing_is_named_with_what_installs_it(
    name: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    WRITERS[name](tmp_path / name)
    for module in [module for module in sys.modules if module.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(UserError, match=f"needs {library}.*, which is not installed; .* -m pip install"):
        read_clouds([tmp_path / name])


def test_blocks_are_what_the_scenes_are_made_of() -> None:
    assert len(parts().geometry) == len(slab(0.02).split()) == len(blocks().split()) + 1
