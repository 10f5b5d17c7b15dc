"""Robots of MJCF are as MuJoCo compiles them: masses, shapes that touch, motors of wheels; or refused in a line."""

from __future__ import annotations

import json
from math import pi
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import mujoco
import numpy as np
import pytest
import trimesh

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError, ParameterError
from rsegen.robots.drives import Wheels
from rsegen.robots.files.meshes import INLINE
from rsegen.robots.files.mjcf_compile import compiled
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import ModelFrames, inertia_tensor, inertials
from rsegen.robots.lookup import robot_of
from rsegen.robots.visuals import visuals
from tests.robots.mjcf_robots import DEFAULTS, MOTORS, WHEELS, two_wheels_mjcf
from tests.robots.two_wheels import RADIUS, SEPARATION


def frames_of(robot: SdfRobot) -> ModelFrames:
    return ModelFrames(fromstring(robot.text), robot.kind)


def collision(robot: SdfRobot, name: str) -> Any:
    return next(shape for _, shape, _ in frames_of(robot).collisions() if shape.get("name") == name)


def test_a_file_is_the_robot_that_mujoco_has(tmp_path: Path) -> None:
    robot = from_file(two_wheels_mjcf(tmp_path))
    assert robot.kind == "little_rover"
    assert robot.body.mass == pytest.approx(3 + 0.1 + 2 * 0.2)
    drive = robot.drive
    assert isinstance(drive, Wheels)
    assert (drive.left, drive.right) == (("left_hub",), ("right_hub",))
    assert drive.separation == pytest.approx(SEPARATION)
    assert drive.radius == pytest.approx(RADIUS)
    # A servo of 2 Nm s against a damping of 0.01 Nm s.
    assert robot.speed == pytest.approx(RADIUS * 10 * 2 / 2.01)
    assert robot.lift == pytest.approx(0.05)
    assert robot.size == pytest.approx((0.4, 0.32, 0.13))
    assert [name for name, _ in frames_of(robot).links()] == ["base", "left_wheel", "right_wheel"]
    assert collision(robot, "ball").findtext("surface/friction/ode/mu") == "0"  # it has no sliding friction
    frames = frames_of(robot)
    assert frames.joints["left_hub"].findtext("axis/limit/effort") == "1.5"
    assert "shell" not in {shape.get("name") for _, shape, _ in frames.collisions()}
    assert {visual.get("name") for visual in fromstring(robot.text).iter("visual")} >= {"shell_seen", "hull_seen"}


def test_masses_and_moments_are_those_of_the_compiled_model_with_the_rotors(tmp_path: Path) -> None:
    file = two_wheels_mjcf(tmp_path)
    robot, model = from_file(file), mujoco.MjModel.from_xml_path(str(file))
    frames = frames_of(robot)
    masses = inertials(frames)
    for name, element in frames.links():
        body = model.body(name)
        assert masses[name].mass == pytest.approx(float(body.mass[0]))
        moments = np.linalg.eigvalsh(inertia_tensor(name, element, frames))
        rotor = np.array([0.0005, 0.0005, 0.001]) if "wheel" in name else np.zeros(3)
        assert moments == pytest.approx(np.sort(body.inertia) + rotor)


@pytest.mark.parametrize(
    ("turned", "wheels"),
    [
        ("0 0 77", WHEELS),
        ("0 0 -90", WHEELS),
        ("0 0 180", WHEELS),
        # A body that lies on its side, as makers' CAD has it, with wheels that are turned back.
        ("90 0 0", None),
    ],
)
def test_a_robot_stands_upright_wherever_its_file_has_it(tmp_path: Path, turned: str, wheels: str | None) -> None:
    straight = from_file(two_wheels_mjcf(tmp_path, ball=""))
    hull = 'pos="-0.05 0 0.04"'
    file = two_wheels_mjcf(tmp_path, ball="", turned=turned, wheels=wheels or WHEELS)
    if wheels is None:
        text = (
            file.read_text().replace('size="0.15 0.1 0.04"', 'size="0.15 0.04 0.1"').replace(hull, 'pos="-0.05 0.04 0"')
        )
        text = text.replace('pos="0 0.15 0" euler="-90 0 0"', 'pos="0 0 -0.15" euler="180 0 0"')
        file.write_text(text.replace('pos="0 -0.15 0" euler="-90 0 0"', 'pos="0 0 0.15" euler="180 0 0"'))
    robot = from_file(file)
    assert robot.size == pytest.approx(straight.size)
    assert robot.lift == pytest.approx(straight.lift)
    assert robot.drive == straight.drive


def test_axles_along_x_are_turned_across_and_that_is_said(tmp_path: Path) -> None:
    sideways = WHEELS.replace('euler="-90 0 0"', 'euler="0 90 0"')
    sideways = sideways.replace('"0 0.15 0"', '"0.15 0 0"').replace('"0 -0.15 0"', '"-0.15 0 0"')
    robot = from_file(two_wheels_mjcf(tmp_path, wheels=sideways, ball=""))
    assert robot.drive.separation == pytest.approx(SEPARATION)
    assert any("turned by -90 degrees about z" in remark for remark in robot.remarks)


@pytest.mark.parametrize(
    ("motor", "speed", "effort"),
    [
        ('<motor joint="{}" gear="3" ctrlrange="-0.1 0.1"/>', RADIUS * 3 * 0.1 / 0.01, 0.3),
        ('<motor joint="{}" gear="3" ctrlrange="-1 1" forcerange="-0.05 0.05"/>', RADIUS * 0.15 / 0.01, 0.15),
        ('<velocity joint="{}" kv="0.5" ctrlrange="-4 4" forcerange="-0.02 0.02"/>', RADIUS * 0.02 / 0.01, 0.02),
        ('<velocity joint="{}" kv="0.5"/>', None, None),
        ('<motor joint="{}" gear="3" forcerange="-0.05 0.05"/>', None, 0.15),  # any control
        ('<general joint="{}" gaintype="affine" gainprm="0.05 0 0.01" ctrlrange="-1 1"/>', None, None),
        ('<velocity joint="{}" kv="0.5" ctrlrange="-4 4"/><!-- RUBS -->', RADIUS * (2 - 0.1) / 0.51, 2.0),
        ('<velocity joint="{}" kv="0.5" ctrlrange="-4 4" gear="2"/>', RADIUS * 2 * 0.5 * 4 / (0.01 + 0.5 * 4), 4.0),
        ('<position joint="{}" kp="5" ctrlrange="-100 100" forcerange="-7 7"/>', None, 7.0),
        ('<intvelocity joint="{}" kp="5" actrange="-100 100" ctrlrange="-6 6" gear="2"/>', RADIUS * 6 / 2, None),
        ('<intvelocity joint="{}" kp="5" actrange="-100 100" ctrlrange="-6 6"/>', RADIUS * 6, None),
        (
            '<general joint="{}" gainprm="30" biastype="affine" biasprm="0 0 -3" ctrlrange="-1 1"/>',
            RADIUS * 30 / 3.01,
            30.0,
        ),
    ],
)
def test_speed_and_torque_are_those_of_the_motors(
    tmp_path: Path, motor: str, speed: float | None, effort: float | None
) -> None:
    file = two_wheels_mjcf(tmp_path, motors=motor.format("left_hub") + motor.format("right_hub"))
    if "RUBS" in motor:
        defaults = file.with_name("defaults.xml")
        defaults.write_text(DEFAULTS.replace('damping="0.01"', 'damping="0.01" frictionloss="0.1"'))
    robot = from_file(file)
    assert robot.read_drive is not None
    assert robot.read_drive.origin == "its actuators"
    if speed:
        assert RADIUS * native_rate(file) == pytest.approx(speed, rel=1e-3)
    assert ("speed" in robot.derived) is (speed is not None)
    assert robot.speed == pytest.approx(speed or 0.2)
    found = frames_of(robot).joints["left_hub"].findtext("axis/limit/effort")
    assert (found and float(found)) == (effort and pytest.approx(effort))


def native_rate(file: Path) -> float:
    """Return the speed at which MuJoCo itself turns the left wheel in the end, rad/s, of a robot that is held."""
    held = file.with_name("held.xml")
    held.write_text(file.read_text().replace("<freejoint/>", "").replace('name="floor"', 'contype="0" conaffinity="0"'))
    model = mujoco.MjModel.from_xml_path(str(held))
    model.opt.gravity[:], model.opt.integrator = 0, int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    data = mujoco.MjData(model)
    data.ctrl[:] = model.actuator_ctrlrange[:, 1]
    mujoco.mj_step(model, data, 2500)
    return float(data.joint("left_hub").qvel[0])


def test_motors_pull_wheels_by_tendons_too(tmp_path: Path) -> None:
    pulled = '<fixed name="{}"><joint joint="left_hub" coef="{}"/><joint joint="right_hub" coef="0.5"/></fixed>'
    tendons = f"<tendon>{pulled.format('on', 0.5)}{pulled.format('round', -0.5)}</tendon>"
    motors = '<motor tendon="on" ctrlrange="-0.2 0.2"/><motor tendon="round" ctrlrange="-0.2 0.2"/>'
    robot = from_file(two_wheels_mjcf(tmp_path, motors=motors, after=tendons))
    assert robot.drive.left == ("left_hub",)
    assert robot.speed == pytest.approx(RADIUS * 0.5 * 0.2 / 0.01)


def mesh_file(folder: Path, name: str) -> Any:
    (folder / "meshes").mkdir(exist_ok=True)
    mesh = trimesh.creation.box((0.2, 0.1, 0.3))
    mesh.apply_translation((0.3, 0.1, 0.05))
    mesh.export(folder / "meshes" / name)
    return mesh


@pytest.mark.parametrize("name", ["part.stl", "part.obj"])
@pytest.mark.parametrize(
    "how",
    [
        "",
        'scale="0.1 0.2 -0.3"',
        'refpos="0.1 0.2 0.3" scale="0.5 1 2"',
        'refquat="1 0.3 1 0.2" refpos="0.1 0.2 0.3" scale="0.2 0.2 0.2"',
        'refquat="1 0.3 1 0.2" scale="0.2 0.4 0.3"',
    ],
)
def test_a_mesh_is_where_mujoco_has_it(tmp_path: Path, name: str, how: str) -> None:
    mesh_file(tmp_path, name)
    shape = '<geom name="part" type="mesh" mesh="part" pos="0.1 0.2 2" euler="10 20 30"/>'
    file = two_wheels_mjcf(tmp_path, more=shape, assets=f'<mesh name="part" file="{name}" {how}/>')
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geom, base = model.geom("part").id, model.body("base").id
    points = model.mesh_vert @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom] - data.xpos[base]
    extent = frames_of(from_file(file)).shapes.of("base")
    assert extent is not None
    low = np.minimum(points.min(axis=0), (-0.2, -0.1, -0.05))  # of the hull and the ball
    assert (extent.low <= low + 1e-6).all()  # the box of a turned mesh is that of its own box
    own = fromstring(from_file(file).text)
    part = next(shape for shape in own.iter("collision") if shape.get("name") == "part")
    uri = part.findtext("geometry/mesh/uri", "")
    assert uri.startswith(INLINE) is ("refquat" in how and "0.4" in how)
    seen = np.concatenate([visual.points for visual in visuals(from_file(file))["base"]])
    distance = np.linalg.norm(points[:, None] - seen[None], axis=2).min(axis=1)
    assert distance.max() < 1e-5


@pytest.mark.parametrize("ending", ["mjcf", "XML"])
def test_a_file_of_any_ending_is_the_same_robot(tmp_path: Path, ending: str) -> None:
    """MuJoCo reads *.xml alone; parts and meshes are next to the file all the same."""
    mesh_file(tmp_path, "part.stl")
    shape = '<geom type="mesh" mesh="part" mass="0.5"/>'
    file = two_wheels_mjcf(tmp_path, more=shape, assets='<mesh name="part" file="part.stl"/>')
    (other := file.with_suffix(f".{ending}")).write_bytes(file.read_bytes())
    robot = from_file(other)
    assert robot.body.mass == pytest.approx(4.0)
    assert robot.text == from_file(file).text
    other.write_text(file.read_text().replace("<freejoint/>", "<freejoint><b/></freejoint>"))
    with pytest.raises(FileError, match=rf"rover\.{ending}: line \d+: <b>: MuJoCo .* does not know this element"):
        from_file(other)


def test_a_mesh_of_points_in_the_model_drives_in_mujoco_and_is_refused_for_gazebo(tmp_path: Path) -> None:
    points = "0 0 0  0.2 0 0  0 0.2 0  0 0 0.2"
    shape = '<geom name="nose" type="mesh" mesh="nose" mass="0.1"/>'
    robot = from_file(two_wheels_mjcf(tmp_path, more=shape, assets=f'<mesh name="nose" vertex="{points}"/>'))
    assert robot.size[2] == pytest.approx(0.05 + 0.2, abs=1e-6)
    assert robot.body.mass == pytest.approx(3.6)
    with pytest.raises(FileError, match="Gazebo reads no other; drive it in MuJoCo"):
        robot.model("one", "sim")
    with pytest.raises(FileError, match="drive it in MuJoCo"):
        robot.file("one")
    unseen = shape.replace("<geom", '<geom contype="0" conaffinity="0"')
    seen = from_file(two_wheels_mjcf(tmp_path, more=unseen, assets=f'<mesh name="nose" vertex="{points}"/>'))
    assert INLINE in seen.text
    assert INLINE not in seen.model("one", "sim")


def test_what_is_only_seen_may_be_missing_and_is_named(tmp_path: Path) -> None:
    shell = '<geom class="seen" type="mesh" mesh="shell"/>'
    assets = '<mesh name="shell" file="shell.stl"/><texture name="grid" type="2d" file="grid.png"/>'
    robot = from_file(two_wheels_mjcf(tmp_path, more=shell, assets=assets))
    assert any("these visual meshes are not found: shell.stl" in remark for remark in robot.remarks)
    assert robot.body.mass == pytest.approx(3.5)
    for geom, why in (
        (shell.replace('class="seen"', ""), "of a collision shape"),
        (shell.replace("<geom", '<geom mass="1"'), "that gives a body its mass"),
    ):
        with pytest.raises(FileError, match=rf"rover\.xml: the mesh shell\.stl {why} is not found in .*meshes"):
            from_file(two_wheels_mjcf(tmp_path, more=geom, assets=assets))


def test_bodies_without_a_joint_are_one_link_and_several_joints_are_links_between(tmp_path: Path) -> None:
    more = """
      <body name="mast" pos="0 0 0.1"><geom name="mast" type="cylinder" size="0.01 0.1" mass="0.4"/>
        <body name="eye" pos="0 0 0.1">
          <joint name="pan" axis="0 0 1" range="-50 50"/><joint name="tilt" axis="0 1 0" range="-20 30"/>
          <geom type="box" size="0.02 0.02 0.02" mass="0.5"/>
        </body>
      </body>"""
    robot = from_file(two_wheels_mjcf(tmp_path, more=more))
    frames = frames_of(robot)
    assert [name for name, _ in frames.links()] == ["base", "left_wheel", "right_wheel", "eye", "eye_on_pan"]
    assert robot.body.mass == pytest.approx(3.5 + 0.9)
    assert (frames.parent("pan"), frames.child("pan"), frames.parent("tilt"), frames.child("tilt")) == (
        "base",
        "eye_on_pan",
        "eye_on_pan",
        "eye",
    )
    assert float(frames.joints["tilt"].findtext("axis/limit/upper", "")) == pytest.approx(pi / 6)
    assert robot.held == ("pan", "tilt")
    assert frames.transform("eye")[2, 3] == pytest.approx(0.2)


def test_joints_are_where_mujoco_has_them(tmp_path: Path) -> None:
    more = """<body name="arm" pos="0 0 0.1" euler="0 0 30"><joint name="swing" pos="0.05 0.02 0.01" axis="1 1 0"
      range="-50 50"/><geom type="box" size="0.02 0.02 0.02" mass="0.5"/></body>"""
    file = two_wheels_mjcf(tmp_path, more=more, ball="")
    frames, model = frames_of(from_file(file)), mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for name in ("left_hub", "right_hub", "swing"):
        place = data.joint(name).xanchor - data.body("base").xpos
        assert frames.joint(name)[:3, 3] == pytest.approx(place, abs=1e-9), name
        assert frames.axis(name) == pytest.approx(data.joint(name).xaxis, abs=1e-9), name


def test_angles_count_from_where_the_file_has_the_robot(tmp_path: Path) -> None:
    more = """<body name="leg" pos="0 0 0.1"><joint name="knee" axis="0 1 0" ref="20" range="10 50" stiffness="3"
      springref="30"/><geom type="box" size="0.02 0.02 0.02" mass="0.5"/></body>"""
    joint = frames_of(from_file(two_wheels_mjcf(tmp_path, more=more))).joints["knee"]
    ends = [float(joint.findtext(f"axis/limit/{end}", "")) for end in ("lower", "upper")]
    assert ends == pytest.approx(np.radians([-10, 30]))
    assert float(joint.findtext("axis/dynamics/spring_reference", "")) == pytest.approx(np.radians(10))
    assert float(joint.findtext("axis/dynamics/spring_stiffness", "")) == 3


@pytest.mark.parametrize(
    ("geom", "ground", "touches"),
    [
        ('contype="0" conaffinity="1"', "", True),
        ('contype="2" conaffinity="0"', "", False),
        ('contype="2" conaffinity="0"', 'contype="1" conaffinity="2"', True),
        ('contype="0" conaffinity="0"', "", False),
        ('contype="1" conaffinity="1"', 'contype="4" conaffinity="4"', False),
        ('contype="1" conaffinity="1"', 'contype="4" conaffinity="4" type="plane" size="5 5 0.1"/><geom', True),
    ],
)
def test_what_touches_the_ground_of_the_file_touches(tmp_path: Path, geom: str, ground: str, touches: bool) -> None:
    file = two_wheels_mjcf(tmp_path, more=f'<geom name="bumper" type="box" size="0.01 0.01 0.01" {geom}/>')
    file.write_text(file.read_text().replace('name="floor"', f'name="floor" {ground}'))
    shapes = {shape.get("name") for _, shape, _ in frames_of(from_file(file)).collisions()}
    assert ("bumper" in shapes) is touches


@pytest.mark.parametrize(
    ("geom", "touches"),
    [
        ('contype="4" conaffinity="0"', True),
        ('contype="0" conaffinity="2"', True),
        ("", True),
        ('contype="0" conaffinity="0"', False),
    ],
)
def test_without_a_ground_in_the_file_touches_what_may_touch_anything(tmp_path: Path, geom: str, touches: bool) -> None:
    file = two_wheels_mjcf(tmp_path, more=f'<geom name="bumper" type="box" size="0.01 0.01 0.01" {geom}/>')
    text = file.read_text()
    file.write_text(text.replace('<geom name="floor" type="plane" size="5 5 0.1"/>', ""))
    assert file.read_text() != text
    shapes = {shape.get("name") for _, shape, _ in frames_of(from_file(file)).collisions()}
    assert ("bumper" in shapes) is touches


def test_a_shape_of_a_pair_touches(tmp_path: Path) -> None:
    more = '<geom name="toe" contype="0" conaffinity="0" type="sphere" size="0.01"/>'
    pair = '<contact><pair geom1="toe" geom2="floor"/></contact>'
    shapes = {
        s.get("name") for _, s, _ in frames_of(from_file(two_wheels_mjcf(tmp_path, more=more, after=pair))).collisions()
    }
    assert "toe" in shapes


def test_a_scene_is_the_robot_in_it(tmp_path: Path) -> None:
    two_wheels_mjcf(tmp_path)
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<mujoco><worldbody><body name="can" pos="1 0 1"><freejoint/><geom type="sphere" size="1"/></body></worldbody>'
        '<include file="rover.xml"/></mujoco>'
    )
    robot = from_file(scene)
    assert robot.body.mass == pytest.approx(3.5)
    assert any("other bodies of the scene: can" in remark for remark in robot.remarks)


_LEG = """<body pos="{0} {1} 0"><joint name="hip{2}" axis="0 1 0" limited="false"/>
  <geom type="capsule" size="0.02 0.15" pos="0 0 -0.15"/></body>"""
_HIPS = "".join(
    _LEG.format(x, y, n) for n, (x, y) in enumerate([(0.2, 0.1), (0.2, -0.1), (-0.2, 0.1), (-0.2, -0.1)], 1)
)
LEGS = f"""\
<mujoco model="dog">
  <worldbody>
    <body name="trunk" pos="0 0 0.4"><freejoint/><geom type="box" size="0.2 0.1 0.05" mass="5"/>{_HIPS}</body>
  </worldbody>
  <actuator><position joint="hip1" kp="50"/><motor joint="hip2"/><velocity joint="hip3"/></actuator>
</mujoco>"""


def test_legs_stand_and_have_no_wheels_to_be_driven_by(tmp_path: Path) -> None:
    file = tmp_path / "dog.xml"
    file.write_text(LEGS)
    robot = from_file(file)
    assert robot.body.mass > 5
    with pytest.raises(ParameterError, match=r"no wheels or tracks.* \(hip1, hip2, hip3, hip4\).* it only stands"):
        _ = robot.drive
    assert robot.held == ("hip1", "hip2", "hip3", "hip4")
    field = rsegen.build(rsegen.Recipe(name="flat", boundary="none"))
    assert rsegen.poses(field, robot, 0.0, 0.0, 0.0).stands.all()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("<mujoco/>", "a scene of MuJoCo without a <body>, so without a robot"),
        (
            '<mujoco><worldbody><body nam="a"/></worldbody></mujoco>',
            "robot.xml: line 1: <body>: MuJoCo {version} does not know its attribute 'nam'; delete it if the file is"
            " for an older version; update MuJoCo if it is for a newer one",
        ),
        (
            "<mujoco>\n<equality><distance geom1='a' geom2='b'/></equality></mujoco>",
            "robot.xml: line 2: <distance>: MuJoCo {version} does not know this element in this place; delete it if",
        ),
        (
            "<mujoco><compiler coordinate='global'/></mujoco>",
            "robot.xml: line 1: <compiler>: MuJoCo {version} does not read it: global coordinates no longer supported.",
        ),
        ("<mujoco><include file='parts.xml'/></mujoco>", "parts.xml, and there is no such file"),
        (
            "<mujoco><worldbody><body><joint/></body></worldbody></mujoco>",
            "MuJoCo {version} does not read it: Error: mass and inertia of moving bodies must be larger",
        ),
        (
            "<mujoco><worldbody><replicate count='999'><replicate count='99999'><geom size='1'/></replicate>"
            "</replicate></worldbody></mujoco>",
            "<replicate> makes more than 10000 copies, with a count of '99999'",
        ),
        (
            "<mujoco><worldbody><body name='frame'/></worldbody></mujoco>",
            "body 'frame' has no mass; a simulator needs one",
        ),
        (
            "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='1 1 1 1'/></asset><worldbody><body>"
            "<geom name='hill' type='hfield' hfield='h' mass='1'/></body></worldbody></mujoco>",
            "the shape 'hill' is of the type hfield, which a robot cannot have",
        ),
    ],
)
def test_what_cannot_be_read_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, says: str
) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(text)
    assert main(["robot", str(file)]) == 2
    error = capsys.readouterr().err
    assert says.format(version=mujoco.mj_versionString()) in error
    assert error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]  # and no log of MuJoCo


def test_a_robot_of_very_many_files_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    for count, problem in ((100, "a scene of MuJoCo without a <body>"), (101, "includes more than 100 files")):
        names = [f"part_{number}.xml" for number in range(count)]
        includes = "".join(f"<include file='{name}'/>" for name in names)
        file.write_text(f"<mujoco>{includes}</mujoco>")
        for name in names:
            (tmp_path / name).write_text("<mujoco><worldbody/></mujoco>")
        with pytest.raises(FileError, match=problem):
            from_file(file)


def test_a_missing_mujoco_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = two_wheels_mjcf(tmp_path)
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    with pytest.raises(FileError, match=r"MJCF is read by MuJoCo, which is not installed; pip install"):
        from_file(file)


def test_rsegen_robot_lists_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", str(two_wheels_mjcf(tmp_path)), "--json"]) == 0
    figures = {figure["name"]: figure for figure in json.loads(capsys.readouterr().out)["figures"]}
    assert (figures["mass"]["value"], figures["mass"]["unit"]) == (3.5, "kg")
    assert figures["speed"]["origin"] == "its actuators"
    assert (figures["motor"]["value"], figures["motor"]["unit"]) == ([1.5], "Nm")
    assert figures["friction"]["value"] == [0.9]


def test_metrics_of_it_are_those_of_the_same_robot_in_sdf(tmp_path: Path) -> None:
    robot = robot_of(two_wheels_mjcf(tmp_path))
    assert isinstance(robot, SdfRobot)
    same = tmp_path / "same.sdf"
    same.write_text(robot.file("little_rover"))
    recipe = rsegen.Recipe(
        name="hills", boundary="none", seed=4, obstacles=[rsegen.Peak(levels=4, first=(2, 2), last=(7, 7))]
    )
    field = rsegen.build(recipe)
    x, y = np.meshgrid([-0.3, 0.0, 0.2], [-0.2, 0.1])
    ours, theirs = (rsegen.poses(field, one, x, y, 0.3) for one in (robot, from_file(same)))
    assert ours.stands.any()
    assert ours.roll == pytest.approx(theirs.roll)
    assert ours.pitch == pytest.approx(theirs.pitch)


def test_the_defaults_are_those_of_the_class(tmp_path: Path) -> None:
    slow = DEFAULTS.replace('ctrlrange="-10 10"', 'ctrlrange="-1 1"')
    assert slow != DEFAULTS
    file = two_wheels_mjcf(tmp_path, motors=MOTORS)
    (tmp_path / "defaults.xml").write_text(slow)
    assert from_file(file).speed == pytest.approx(RADIUS * 2 / 2.01)


def touching_mesh(folder: Path, more: str = "") -> Path:
    """Write a robot whose hull is a mesh that touches."""
    trimesh.creation.icosphere(radius=0.1).export(folder / "hull.stl")
    return two_wheels_mjcf(
        folder,
        compiler=f'<compiler angle="degree" eulerseq="xyz" {more}/>',
        assets='<mesh name="hull_mesh" file="hull.stl"/>',
        more='<geom name="touching" type="mesh" mesh="hull_mesh" mass="1" pos="0 0 0.1"/>',
    )


@pytest.mark.parametrize("more", ["", 'discardvisual="true"'])
def test_no_hull_is_made_of_a_mesh_and_it_touches_all_the_same(tmp_path: Path, more: str) -> None:
    file = touching_mesh(tmp_path, more)
    model = mujoco.MjModel.from_xml_path(str(file))
    assert model.nmeshgraph > 0  # MuJoCo makes one
    ours = compiled(fromstring(file.read_text("utf-8")), str(file)).model
    assert (ours.nmeshgraph > 0) == bool(more)
    names = [model.geom(geom).name for geom in range(model.ngeom)]
    assert names == [ours.geom(geom).name for geom in range(ours.ngeom)]
    assert "touching" in names
    np.testing.assert_array_equal(ours.geom_contype, model.geom_contype)
    np.testing.assert_array_equal(ours.geom_conaffinity, model.geom_conaffinity)
    np.testing.assert_array_equal(ours.body_mass, model.body_mass)
    assert "touching" in {shape.get("name") for _, shape, _ in frames_of(from_file(file)).collisions()}


def test_a_large_mesh_is_refused_before_mujoco_reads_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = touching_mesh(tmp_path)
    monkeypatch.setattr("rsegen.robots.files.meshes.MAX_MESH_MIB", 0)
    monkeypatch.setattr(
        "rsegen.robots.files.mjcf_compile._compiled_without_hulls", lambda spec: pytest.fail("was compiled")
    )
    monkeypatch.setattr("rsegen.robots.files.mjcf_compile.MANY_FACES", 100)
    with pytest.raises(FileError, match=r"hull\.stl: 1,280 faces; .* up to 100; simplify it, or write it as OBJ"):
        from_file(file)
    trimesh.load_mesh(tmp_path / "hull.stl").export(tmp_path / "hull.obj")
    file.write_text(file.read_text("utf-8").replace("hull.stl", "hull.obj"))
    with pytest.raises(FileError, match=r"hull\.obj: larger than 0 MiB, too large for a mesh of a robot; simplify it$"):
        from_file(file)


def test_a_mesh_of_a_form_that_mujoco_does_not_read_is_refused_with_advice(tmp_path: Path) -> None:
    file = touching_mesh(tmp_path)
    assert frames_of(from_file(file)).collisions()
    trimesh.load_mesh(tmp_path / "hull.stl").export(tmp_path / "hull.stl", file_type="stl_ascii")
    with pytest.raises(FileError, match=r"hull\.stl: of STL files MuJoCo reads binary ones alone; write it as such"):
        from_file(file)
    with pytest.raises(ValueError, match="STL"):
        mujoco.MjModel.from_xml_path(str(file))
