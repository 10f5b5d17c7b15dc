"""Valid input of every sort, small, from which hostile input is made."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from rsegen import KINDS, Recipe
from rsegen.cli.edge import main
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import encode
from rsegen.recipe.examples import EXAMPLES
from tests.support.samples import sample

SMALL = {"chunk_size": 4, "chunks": 1, "seed": 7}


@cache
def recipes() -> tuple[dict[str, Any], ...]:
    """Trees of recipes: the examples, one for every kind of obstacle, and one of every parameter of all maps."""
    examples = [yaml.safe_load(path.read_text("utf-8")) for path in EXAMPLES.values()]
    kinds = [SMALL | {"obstacles": [_obstacle(kind)]} for kind in KINDS if kind != "matrix"]
    bare = Recipe(seed=0)
    others = [SMALL | {name: _plain(parameter, getattr(bare, name))} for name, parameter in parameters(Recipe).items()]
    written = encode(Recipe(seed=3, chunk_size=4))
    return (*examples, *kinds, *others, written)


def _obstacle(kind: str) -> dict[str, Any]:
    """An obstacle with every parameter that has an own value."""
    cls = KINDS[kind]
    values = {"kind": kind, "levels": 3, "key": "k", "blend": "max", "first": [0, 0], "last": [3, 3]}
    return values | {name: 3 for name in parameters(cls) if name == "softness"}


def _plain(parameter: Any, default: object) -> Any:
    return sample(parameter, default)


@contextmanager
def _elsewhere() -> Iterator[Path]:
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
        os.chdir(folder)
        try:
            yield Path(folder)
        finally:
            os.chdir(before)


def _files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@cache
def map_folder() -> Mapping[str, bytes]:
    """Two maps as `generate` writes them, with files of other formats."""
    with _elsewhere() as folder:
        flags = ["--maps", "2", "--chunk-size", "4", "--seed", "7", "--formats", "heightmap,ply", "--workers", "1"]
        assert main(["generate", "--obstacle", "random levels=3", *flags, "-o", "maps"]) == 0
        return _files(folder)


@cache
def data_set(metrics: str) -> Mapping[str, bytes]:
    """A data set of four maps in two shards."""
    with _elsewhere() as folder:
        flags = ["--maps", "4", "--chunk-size", "4", "--seed", "7", "--shard-maps", "2", "--workers", "1"]
        assert main(["dataset", "--obstacle", "random levels=3", *flags, "--metrics", metrics, "-o", "set"]) == 0
        return _files(folder)


@cache
def data_set_of_several(metrics: str) -> Mapping[str, bytes]:
    """A data set of two recipes, a shard each."""
    with _elsewhere() as folder:
        flags = ["--maps", "2", "--metrics", metrics, "--workers", "1", "-o", "set"]
        assert main(["dataset", "peak", "diagonal-barrier", *flags]) == 0
        return _files(folder)


@cache
def unfinished(metrics: str) -> Mapping[str, bytes]:
    """The same after its run was stopped: no manifest, and one shard less."""
    gone = ("00001", "manifest.json")
    whole = {name: content for name, content in data_set(metrics).items() if not any(one in name for one in gone)}
    lines = whole["set/.rsegen.jsonl"].splitlines(keepends=True)
    whole["set/.rsegen.jsonl"] = b"".join(line for line in lines if not any(one.encode() in line for one in gone))
    return whole


@cache
def build_sheet() -> bytes:
    """A build sheet in CSV."""
    with _elsewhere() as folder:
        assert (
            main(["sheet", "--obstacle", "peak levels=3", "--chunk-size", "4", "--seed", "7", "-o", "sheet.csv"]) == 0
        )
        return (folder / "sheet.csv").read_bytes()


@cache
def images() -> Mapping[str, bytes]:
    """Small images in every format and of many modes that heights are read from."""
    from PIL import Image

    grey = np.arange(0, 240, 15, dtype=np.uint8).reshape(4, 4)
    found: dict[str, bytes] = {}

    def add(name: str, image: Any, **options: Any) -> None:
        stream = io.BytesIO()
        form = {"jpg": "JPEG", "tif": "TIFF", "pgm": "PPM"}.get(name.rpartition(".")[2])
        image.save(stream, form or name.rpartition(".")[2].upper(), **options)
        found[name] = stream.getvalue()

    base = Image.fromarray(grey)
    add("grey.png", base)
    add("deep.png", Image.fromarray(grey.astype(np.uint16) * 256))
    add("one.png", base.convert("1"))
    add("palette.png", base.convert("RGB").quantize(8), transparency=0)
    add("clear.png", base.convert("LA"))
    add("colours.png", base.convert("RGBA"))
    add("grey.jpg", base, exif=b"Exif\0\0II*\0\x08\0\0\0\0\0")
    add("grey.bmp", base)
    add("colours.bmp", base.convert("RGB"))
    add("grey.pgm", base)
    found["plain.pgm"] = b"P2\n# a comment\n4 4\n255\n" + b" ".join(b"%d" % value for value in grey.flat) + b"\n"
    found["deep.pgm"] = b"P5 4 4 65535\n" + (grey.astype(">u2") * 256).tobytes()
    for name, compression in (("raw", None), ("lzw", "tiff_lzw"), ("zip", "tiff_deflate"), ("packed", "packbits")):
        add(f"{name}.tif", base, compression=compression)
    add("float.tif", Image.fromarray(grey.astype(np.float32) / 255))
    add("deep.tif", Image.fromarray(grey.astype(np.uint16) * 256))
    return found


def array(values: Any) -> bytes:
    """An array in a NPY file."""
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()


def cloud(rng: np.random.Generator) -> Any:
    """Points on a field of 4 x 4 random blocks of 10 cm, and on some floor around: (n, 3), in metres."""
    levels = np.pad(np.floor(rng.random((4, 4)) * 4), 4)
    points = rng.random((3000, 3)) * (1.2, 1.2, 0) - (0.6, 0.6, 0)
    i, j = np.floor(points[:, :2].T / 0.1).astype(int) + 6
    points[:, 2] = 0.1 * levels[i, j]
    return points


@cache
def clouds() -> Mapping[str, bytes]:
    """A cloud of blocks in every format that is read, as the libraries write it; depth images of a camera above."""
    import laspy
    import trimesh
    from PIL import Image
    from pypcd4.pypcd4 import Encoding, PointCloud

    points = cloud(np.random.default_rng(5))
    found: dict[str, bytes] = {"points.npy": array(points), "single.npy": array(points.astype("f4"))}
    for name, options in (("points.xyz", {}), ("points.csv", {"delimiter": ";", "header": "x;y;z", "comments": ""})):
        text = io.StringIO()
        np.savetxt(text, points, fmt="%.4f", **options)
        found[name] = text.getvalue().encode()
    for encoding in ("ascii", "binary"):
        found[f"{encoding}.ply"] = trimesh.PointCloud(points).export(file_type="ply", encoding=encoding)
    with _elsewhere():
        for kind in (Encoding.ASCII, Encoding.BINARY, Encoding.BINARY_COMPRESSED):
            PointCloud.from_xyz_points(points.astype("f4")).save(Path("c.pcd"), encoding=kind)
            found[f"{kind.name.lower()}.pcd"] = Path("c.pcd").read_bytes()
        for suffix in ("las", "laz"):
            laser = laspy.LasData(laspy.LasHeader(point_format=0, version="1.2"))
            laser.header.scales = np.full(3, 1e-4)
            laser.x, laser.y, laser.z = points.T
            laser.write(f"c.{suffix}")
            found[f"laser.{suffix}"] = Path(f"c.{suffix}").read_bytes()
    heights = np.floor(np.random.default_rng(6).random((4, 4)) * 4) * 0.1 + 0.05
    boxes = [trimesh.creation.box((2, 2, 0.1))]
    for (i, j), height in np.ndenumerate(heights):
        boxes.append(trimesh.creation.box((0.1, 0.1, height)).apply_translation((i / 10, j / 10, height / 2)))
    mesh = trimesh.util.concatenate(boxes)
    for name, form in (("mesh.stl", "stl"), ("ascii.stl", "stl_ascii"), ("mesh.obj", "obj"), ("mesh.glb", "glb")):
        content = mesh.export(None, file_type=form)
        found[name] = content.encode() if isinstance(content, str) else content
    found["mesh.ply"] = mesh.export(None, file_type="ply")
    depth = np.full((48, 64), 1500.0)
    depth[16:32, 16:32] -= np.kron(np.rint(heights * 1000), np.ones((4, 4)))
    for name, image in (("depth.png", depth.astype("u2")), ("depth.tif", (depth / 1000).astype("f4"))):
        stream = io.BytesIO()
        Image.fromarray(image).save(stream, "PNG" if name.endswith("png") else "TIFF")
        found[name] = stream.getvalue()
    found["depth.pgm"] = b"P5 64 48 65535\n" + depth.astype(">u2").tobytes()
    found["depth.npy"] = array(depth.astype("u2"))
    return found


@cache
def robots() -> tuple[bytes, ...]:
    """Robots: a small one, one with a mesh, and those that come along, for every simulator, as SDF; two as URDF."""
    from rsegen.robots.base import ROBOTS
    from rsegen.robots.drives import BACKENDS

    box = b"<box><size>0.4 0.3 0.1</size></box>"
    meshed = ROBOT.replace(box, b"<mesh><uri>part.stl</uri><scale>0.2 0.2 0.2</scale></mesh>")
    return (
        ROBOT,
        URDF,
        CONTROLLED,
        CONTROLLED,
        meshed,
        meshed,
        *(robot.file("cart", each).encode() for robot in ROBOTS.values() for each in BACKENDS),
    )


@cache
def plans() -> tuple[dict[str, Any], ...]:
    """Plans of experiments: a small one, and those that come along."""
    from rsegen.experiments.plan import PLANS

    return (PLAN, *(yaml.safe_load(Path(str(path)).read_text("utf-8")) for path in PLANS.values()))


ROS_MAP = {"image": "grey.pgm", "resolution": 0.05, "origin": [0.0, 0.0, 0.0], "negate": 0, "occupied_thresh": 0.65}
ROS_MAP |= {"free_thresh": 0.196, "mode": "trinary"}
TABLES = (
    b"0,10,20\n10,0,10\n20,30,0\n",
    b"0;10;20\r\n10;0;10\r\n",
    b"0\t10\n10\t0\n",
    b"# levels\n0 1 2\n1 2 3\n",
    b"x,y,height\n0,0,10\n0,1,0\n1,0,20\n1,1,10\n",
    b"0,0,10\n0,1,0\n1,0,20\n1,1,10\n",
)
INVENTORY = b"height_cm,count\n10,100\n20,100\n30,50\n40,50\n"
ROBOT = b"""<?xml version="1.0"?>
<sdf version="1.6"><model name="cart"><pose>0 0 0.1 0 0 0</pose><link name="base"><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><box><size>0.4 0.3 0.1</size></box></geometry></collision></link>
<plugin name="drive" filename="libDiffDrivePlugin.so"><robot_namespace>cart</robot_namespace></plugin>
<plugin name="other" filename="libgz-sim-diff-drive-system.so"><topic>/model/{name}/cmd_vel</topic></plugin>
</model></sdf>
"""
URDF = b"""<?xml version="1.0"?>
<robot name="cart"><material name="grey"><color rgba="0.5 0.5 0.5 1"/></material><link name="foot"/>
<joint name="j" type="fixed"><origin xyz="0 0 0.1"/><parent link="foot"/><child link="base"/></joint>
<link name="base"><inertial><origin xyz="0.1 0 0" rpy="0 0 0.3"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
<visual><geometry><sphere radius="0.1"/></geometry><material name="grey"/></visual>
<collision><origin xyz="0 0 0.1"/><geometry><box size="0.4 0.3 0.1"/></geometry></collision></link>
<joint name="k" type="continuous"><origin xyz="0 0.1 0" rpy="-1.5708 0 0"/><parent link="base"/><child link="wheel"/>
<axis xyz="0 0 1"/><limit effort="2" velocity="9"/><dynamics damping="0.1"/></joint>
<link name="wheel"><inertial><mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/>
</inertial><collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
<gazebo reference="base"><mu1>0.5</mu1><sensor name="s" type="imu"><pose>0 0 1 0 0 0</pose></sensor></gazebo>
<gazebo><plugin name="drive" filename="libDiffDrivePlugin.so"><left_joint>k</left_joint></plugin></gazebo></robot>
"""
_HAND = b"""<joint name="m" type="revolute"><origin xyz="0 -0.1 0" rpy="-1.5708 0 0"/><parent link="base"/>
<child link="other"/><axis xyz="0 0 1"/></joint>
<link name="other"><inertial><mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/>
</inertial><collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
<ros2_control name="c" type="system"><joint name="k"><command_interface name="velocity"><param name="max">8</param>
</command_interface></joint><joint name="m"><command_interface name="velocity"/></joint></ros2_control>
<transmission name="t"><joint name="m"><hardwareInterface>hardware_interface/VelocityJointInterface</hardwareInterface>
</joint></transmission><gazebo><plugin name="ros" filename="libgazebo_ros2_control.so"><parameters>c.yaml</parameters>
</plugin></gazebo></robot>
"""
CONTROLLED = URDF.partition(b"<gazebo><plugin")[0] + _HAND
CONTROLLER = b"""c:
  ros__parameters:
    left_wheel_names: ["k"]
    right_wheel_names: ["m"]
    wheel_separation: 0.2
    wheel_separation_multiplier: 1.5
    wheel_radius: 0.05
    linear.x.max_velocity: 0.5
    angular: {z: {has_velocity_limits: true, max_velocity: 1}}
"""
PACKAGE = b'<?xml version="1.0"?><package format="3"><name>cart_description</name></package>'
PLAN: dict[str, Any] = {
    "name": "small",
    "seconds": 5,
    "repeats": 2,
    "seed": 3,
    "paces": ["real", "free"],
    "rows": [
        {
            "robot": "burger",
            "robots": 2,
            "sizes": [0, 10],
            "levels": 3,
            "unit_cm": 1.0,
            "recipe": {"mesh": "merged"},
        },
        {"robot": "jackal", "robots": 1, "sizes": [20]},
    ],
}
PLUGIN = b'''"""A kind of obstacle."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen import Obstacle
from rsegen.obstacles.base import Region
from rsegen.params.sorts import Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(Region):
    """Sand."""

    kind: ClassVar[str] = "dune"
    grain: Annotated[int, Integer(1, 9, help="size of its grains")] = 2

    def drawn(self, uniform):
        return (uniform * self.levels).astype("int16")
'''


def prepare() -> None:
    """Make all that is made once, while nothing is watched."""
    recipes(), map_folder(), build_sheet(), images(), clouds(), robots(), plans()
    for metrics in ("npy", "none", "parquet"):
        data_set(metrics), unfinished(metrics)
