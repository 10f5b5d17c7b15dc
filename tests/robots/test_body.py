"""The body of a robot is that of its collision shapes, whether it is included or in a file."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.errors import FileError, UserError
from rsegen.robots.base import ROBOTS, link_poses
from rsegen.robots.files.sdf_file import from_file
from rsegen.standing.body import Body

FIELD = rsegen.build(rsegen.Recipe(seed=1, boundary="none", unit_cm=1, obstacles=[rsegen.Random(levels=3)]))


def model(tmp_path: Path, *collisions: str, mass: float = 2.0) -> Path:
    """A robot of one link with these collision shapes."""
    shapes = "".join(
        f'<collision name="c{number}">{collision}</collision>' for number, collision in enumerate(collisions)
    )
    file = tmp_path / "robot.sdf"
    inertial = f"<inertial><pose>0.1 0 0.2 0 0 0</pose><mass>{mass}</mass></inertial>"
    file.write_text(
        f'<sdf version="1.6"><model name="m"><link name="l">{inertial}{shapes}</link></model></sdf>', "utf-8"
    )
    return file


@pytest.mark.parametrize("kind", ROBOTS)
def test_a_robot_reaches_down_to_its_origin_and_as_far_as_its_size(kind: str) -> None:
    robot = ROBOTS[kind]
    body = robot.body
    assert abs(body.low[2]) < 1e-3
    assert body.mass == pytest.approx(robot.mass)
    assert (body.low[:2] < body.centre[:2]).all()
    assert (body.centre[:2] < body.high[:2]).all()
    assert body.length <= robot.size[0] + 0.01
    assert body.width <= robot.size[1] + 0.01
    assert body.drives.any()
    assert not body.drives.all()
    np.testing.assert_allclose(np.linalg.norm(body.normals, axis=1), 1)


@pytest.mark.parametrize("kind", ["burger", "jackal"])
def test_the_file_of_a_robot_has_the_same_body(kind: str, tmp_path: Path) -> None:
    file = tmp_path / f"{kind}.sdf"
    file.write_text(ROBOTS[kind].file(kind), "utf-8")
    one, other = ROBOTS[kind].body, from_file(file).body
    assert other.mass == pytest.approx(one.mass)
    np.testing.assert_allclose(other.centre, one.centre, atol=1e-6)
    np.testing.assert_allclose(other.low, one.low, atol=2e-3)
    driven = [{part.name for part in body.parts if part.drives} for body in (one, other)]
    assert driven[0] == driven[1]


def test_flippers_are_where_their_motors_hold_them() -> None:
    up, down = (ROBOTS["crawler"].holding(dict.fromkeys(FLIPPERS, angle)) for angle in (0.6, 0.0))
    assert _flippers(up.body).max() > _flippers(down.body).max() + 0.1
    np.testing.assert_allclose(_flippers(down.body).min(), 0.035, atol=2e-3)  # an axle at 8.5 cm, a radius of 5 cm


FLIPPERS = ("left_flipper_pivot", "right_flipper_pivot")


def _flippers(body: Body) -> np.ndarray:
    """Heights of the samples of the flippers."""
    own = [index for index, part in enumerate(body.parts) if "flipper" in part.name]
    return np.asarray(body.points[np.isin(body.part, own), 2])


def test_a_raised_shoulder_takes_the_arm_along() -> None:
    folded, raised = ROBOTS["crawler"], ROBOTS["crawler"].holding({"shoulder_joint": pi / 2})
    # The hand is 6 cm behind the shoulder and 4.5 cm above it; a quarter turn up brings it 4.5 cm behind, 6 cm below.
    np.testing.assert_allclose(link_poses(folded)["hand"][:3, 3], (-0.12, 0, 0.295))
    np.testing.assert_allclose(link_poses(raised)["hand"][:3, 3], (-0.06 - 0.045, 0, 0.25 - 0.06))
    moved = {name for name, pose in link_poses(raised).items() if not np.allclose(pose, link_poses(folded)[name])}
    assert moved == {"shoulder", "elbow", "wrist", "hand"}
    assert raised.body.centre[2] > folded.body.centre[2]


def test_a_servo_turns_its_link_about_the_anchor_of_its_joint() -> None:
    crawler = ROBOTS["crawler"]
    joints = tuple(replace(joint, anchor=(0.3, 0, 0)) if joint.name in FLIPPERS else joint for joint in crawler.joints)
    poses = link_poses(replace(crawler, joints=joints).holding(dict.fromkeys(FLIPPERS, pi)))
    np.testing.assert_allclose(poses["left_flipper"][0, 3], 0.27 + 2 * 0.3)


def test_every_shape_of_sdf_is_sampled_from_below(tmp_path: Path) -> None:
    shapes = {
        "<box><size>0.4 0.2 0.1</size></box>": -0.05,
        "<sphere><radius>0.1</radius></sphere>": -0.1,
        "<cylinder><radius>0.1</radius><length>0.3</length></cylinder>": -0.15,
        "<capsule><radius>0.1</radius><length>0.3</length></capsule>": -0.25,
        "<ellipsoid><radii>0.2 0.1 0.3</radii></ellipsoid>": -0.3,
    }
    for shape, low in shapes.items():
        robot = from_file(model(tmp_path, f"<geometry>{shape}</geometry>"))
        assert robot.lift == pytest.approx(-low)
        np.testing.assert_allclose(robot.body.low[2], 0, atol=1e-9)  # it is put down on its lowest point
        np.testing.assert_allclose(robot.body.centre, (0.1, 0, 0.2 - low))


def test_a_mesh_is_sampled_at_its_triangles(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box(extents=(0.4, 0.2, 0.1)).export(tmp_path / "box.stl")
    uri = f"<geometry><mesh><uri>{tmp_path}/box.stl</uri></mesh></geometry>"
    robots = [
        from_file(model(tmp_path, shape)) for shape in (uri, "<geometry><box><size>.4 .2 .1</size></box></geometry>")
    ]
    flat = rsegen.build(rsegen.Recipe(seed=1, boundary="none", unit_cm=1))
    for x, y, heading in ((0, 0, 0.3), (-0.2, 0.1, 2)):
        one, other = (rsegen.poses(field, robot, x, y, heading) for robot in robots for field in [flat])
        assert one.z == pytest.approx(other.z, abs=1e-6)
        np.testing.assert_allclose(one.tilt, 0, atol=1e-6)


def test_a_robot_without_collision_shapes_is_refused_in_a_line(tmp_path: Path) -> None:
    robot = from_file(model(tmp_path))
    with pytest.raises(UserError, match=r"^m: has no collision shapes, so it stands on nothing$"):
        rsegen.poses(FIELD, robot, 0, 0, 0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.6, 0, 0), r"^x: 0\.6 m is outside the field, -0\.5\.\.0\.5 m$"),
        ((0, [-0.4, -0.7], 0), r"^y: -0\.7 m is outside the field"),
        (([0, 0.1, 0.2], [0, 0.1], 0), r"^x, y and heading of shapes \(3,\), \(2,\), \(\) do not go together"),
        ((0, 0, float("nan")), "^heading: has a number that is not finite$"),
        (("a", 0, 0), "^x: 'a' is not a number, nor an array of them$"),
    ],
)
def test_a_place_outside_and_what_is_no_number_is_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(UserError, match=message):
        rsegen.poses(FIELD, "burger", *arguments)  # type: ignore[arg-type]


WHEEL = """
<link name="{side}">
  <pose>0 {y} 0.1 -1.5707963 0 0</pose>
  <collision name="c">
    <geometry><cylinder><radius>0.1</radius><length>0.04</length></cylinder></geometry>
  </collision>
</link>
<joint name="{side}_axle" type="revolute">
  <parent>hull</parent><child>{side}</child><axis><xyz>0 0 1</xyz></axis>
</joint>
"""


def test_the_wheels_of_a_nested_model_drive(tmp_path: Path) -> None:
    hull = '<link name="hull"><collision name="c"><pose>0 0 0.2 0 0 0</pose>'
    hull += "<geometry><box><size>0.3 0.2 0.1</size></box></geometry></collision></link>"
    wheels = WHEEL.format(side="left", y=0.15) + WHEEL.format(side="right", y=-0.15)
    file = tmp_path / "cart.sdf"
    nested = f'<model name="cart"><model name="base">{hull}{wheels}</model></model>'
    file.write_text(f'<sdf version="1.7">{nested}</sdf>', "utf-8")
    drives = {part.name: part.drives for part in from_file(file).body.parts}
    assert drives == {"base::hull::c": False, "base::left::c": True, "base::right::c": True}


def test_a_robot_that_is_longer_than_the_map_is_refused() -> None:
    small = rsegen.build(rsegen.Recipe(seed=1, boundary="none", chunk_size=4))
    with pytest.raises(UserError, match=r"^robot: is 0\.9\d+ m long, longer than the map of 0\.4 x 0\.4 m$"):
        rsegen.poses(small, "crawler", 0, 0, 0)


def test_numbers_and_arrays_go_together() -> None:
    x, heading = np.linspace(-0.3, 0.3, 5), np.array([[0.0], [1.0]])
    found = rsegen.poses(FIELD, "burger", x, 0.1, heading)
    assert found.z.shape == (10,)
    single = rsegen.poses(FIELD, "burger", x[3], 0.1, 1.0)
    for name in ("x", "y", "z", "roll", "pitch", "yaw", "clearance", "tip_angle", "stands", "holds", "pushes"):
        np.testing.assert_allclose(getattr(found, name)[8], getattr(single, name)[0], atol=1e-5)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_a_mesh_that_is_too_large_is_refused_before_it_is_read(tmp_path: Path, ending: str) -> None:
    with (tmp_path / f"hull.{ending}").open("wb") as file:
        file.truncate((64 << 20) + 1)
    mesh = f"<geometry><mesh><uri>hull.{ending}</uri></mesh></geometry>"
    with pytest.raises(FileError, match=rf"hull\.{ending}: larger than 64 MiB, too large for a mesh of a robot"):
        _ = from_file(model(tmp_path, mesh)).body


def test_only_a_binary_stl_file_may_be_larger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rsegen.robots.files.meshes.MAX_MESH_MIB", 0)
    trimesh = pytest.importorskip("trimesh")
    for ending in ("stl", "ply"):
        trimesh.creation.box(extents=(0.4, 0.3, 0.1)).export(tmp_path / f"hull.{ending}")
    hull = "<geometry><mesh><uri>hull.{}</uri></mesh></geometry>"
    assert from_file(model(tmp_path, hull.format("stl"))).size[0] == pytest.approx(0.4)
    with pytest.raises(FileError, match=r"hull\.ply: larger than 0 MiB.* write it as binary STL, of up to 256 MiB"):
        from_file(model(tmp_path, hull.format("ply")))
