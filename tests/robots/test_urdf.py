"""A robot of URDF is the robot that MuJoCo reads from the same text, and the one that people write in SDF."""

from __future__ import annotations

import time
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.errors import FileError
from rsegen.robots.drives import Tracks
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import ModelFrames, inertials, tensor_of
from rsegen.robots.files.urdf import converted
from tests.robots.two_wheels import ROS_1, two_wheels
from tests.robots.urdf_robots import Limb, tree, two_wheels_urdf

MASS = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
HEAVY = '<link name="{}">' + MASS + "</link>"
JOINT = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>{}</joint>'

lengths = st.floats(-2, 2, allow_subnormal=False).map(lambda value: round(value, 6))
right_angles = st.sampled_from([-np.pi, -np.pi / 2, 0.0, np.pi / 2])
angles = st.floats(-4, 4, allow_subnormal=False).map(lambda value: round(value, 6)) | right_angles
places = st.tuples(lengths, lengths, lengths, angles, angles, angles)


@st.composite
def trees(draw: st.DrawFn) -> list[Limb]:
    """Trees of one to eight links, some of them without a mass on a fixed joint."""
    limbs: list[Limb] = []
    for number in range(draw(st.integers(1, 8))):
        kind = draw(st.sampled_from(["fixed", "continuous", "revolute", "prismatic"])) if number else ""
        mass = draw(st.floats(0.01, 50)) if kind != "fixed" else draw(st.just(0.0) | st.floats(0.01, 50))
        size = draw(st.tuples(*[st.floats(0.01, 1)] * 3))
        parent = draw(st.integers(0, max(number - 1, 0)))
        place, axis, centre = draw(places), draw(st.tuples(angles, angles, angles)), draw(places)
        limbs.append(Limb(parent=parent, kind=kind, place=place, axis=axis, mass=mass, centre=centre, size=size))
    return limbs


def test_negative_moments_count_with_the_link_that_theirs_is_fixed_to() -> None:
    """As of an antenna with moments that are rounded: a simulator gets the sum."""
    antenna = HEAVY.format("antenna").replace('ixx="1"', 'ixx="-0.5"')
    robot = f'<robot name="r">{HEAVY.format("a")}{antenna}{JOINT.format("j", "fixed", "a", "antenna", "")}</robot>'
    model = model_of(robot)
    assert inertials(ModelFrames(model, "r"))["a"].mass == 2
    (inertia,) = model.iter("inertia")
    assert float(inertia.findtext("ixx", "")) == 0.5
    with pytest.raises(FileError, match=r"link 'antenna': a principal moment of inertia of -0\.5 kg"):
        model_of(f'<robot name="r">{antenna}</robot>')


@given(trees())
def test_links_joints_and_masses_are_those_that_mujoco_reads(limbs: list[Limb]) -> None:
    model = model_of(tree(limbs))
    frames = ModelFrames(model, "tree")
    found = inertials(frames)
    # MuJoCo takes the root for a part of the world unless it floats in it, and gives shapes the density of water.
    floating = '<link name="above"/>' + JOINT.format("free", "floating", "above", "l0", "")
    options = '<mujoco><compiler inertiafromgeom="false"/></mujoco>'
    theirs = mujoco.MjModel.from_xml_string(tree(limbs, options + floating))
    state = mujoco.MjData(theirs)
    mujoco.mj_forward(theirs, state)
    bodies = {theirs.body(number).name: number for number in range(1, theirs.nbody)}
    assert set(found) == set(bodies)
    for name, body in bodies.items():
        place = frames.transform(name)
        np.testing.assert_allclose(place[:3, 3], state.xpos[body], atol=1e-9)
        np.testing.assert_allclose(place[:3, :3], state.xmat[body].reshape(3, 3), atol=1e-9)
        assert found[name].mass == pytest.approx(theirs.body_mass[body])
        np.testing.assert_allclose(found[name].centre, state.xipos[body], atol=1e-9)
        turn = state.ximat[body].reshape(3, 3)
        tensor = turn @ np.diag(theirs.body_inertia[body]) @ turn.T
        ours = place[:3, :3] @ tensor_in(frames.elements[name]) @ place[:3, :3].T
        np.testing.assert_allclose(ours, tensor, atol=1e-8 * np.abs(tensor).max())
    moving = {theirs.joint(number).name: number for number in range(theirs.njnt)}
    assert set(frames.joints) == set(moving) - {"free"}
    for name in frames.joints:
        np.testing.assert_allclose(frames.axis(name), state.xaxis[moving[name]], atol=1e-9)
        np.testing.assert_allclose(frames.joint(name)[:3, 3], state.xanchor[moving[name]], atol=1e-9)


@given(trees())
def test_no_mass_and_no_shape_is_lost(limbs: list[Limb]) -> None:
    model = model_of(tree(limbs))
    assert sum(each.mass for each in inertials(ModelFrames(model, "tree")).values()) == pytest.approx(
        sum(limb.mass for limb in limbs)
    )
    names = [shape.get("name") for shape in model.iter("collision")]
    assert len(names) == len(set(names)) == len(limbs)


def test_the_same_robot_in_urdf_and_in_sdf_is_driven_alike(tmp_path: Path) -> None:
    urdf, sdf = read(tmp_path, two_wheels_urdf()), from_file(written(tmp_path, "mine.sdf", two_wheels(ROS_1)))
    assert urdf.drive == sdf.drive
    assert (urdf.kind, urdf.joints) == (sdf.kind, ("left_hub", "right_hub"))
    assert (*urdf.size, urdf.lift) == pytest.approx((*sdf.size, sdf.lift))
    assert urdf.command("one", 0.1, 0.2) == sdf.command("one", 0.1, 0.2)
    notes = list(urdf.notes("classic"))
    assert notes[-1].endswith("as sensors move nothing: eye")
    assert ElementTree.fromstring(urdf.file("one")).tag == "sdf"
    model = ElementTree.fromstring(urdf.text)
    assert [link.get("name") for link in model.findall("link")] == ["base_footprint", "left_wheel", "right_wheel"]


def test_a_mesh_in_a_package_is_found(tmp_path: Path) -> None:
    (tmp_path / "mine_description/urdf").mkdir(parents=True)
    (tmp_path / "mine_description/hull.obj").write_text("v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    for name in ("package://mine_description/hull.obj", "../hull.obj"):
        mesh = f'<geometry><mesh filename="{name}" scale="0.1 0.1 0.1"/></geometry>'
        text = f'<robot name="m"><link name="l">{MASS}<collision>{mesh}</collision></link></robot>'
        robot = from_file(written(tmp_path, "mine_description/urdf/mine.urdf", text))
        assert robot.size == pytest.approx((0.6, 0.4, 0.1))


def test_limits_and_damping_are_kept_and_a_wheel_has_no_ends() -> None:
    inner = '<limit {}effort="5" velocity="3"/><dynamics damping="0.1" friction="0.2"/>'
    kinds = {"wheel": ("continuous", ""), "arm": ("revolute", 'lower="-1" upper="2" '), "lift": ("prismatic", "")}
    links = "".join(map(HEAVY.format, ("base", *kinds)))
    joints = "".join(
        JOINT.format(f"{name}_joint", kind, "base", name, inner.format(ends)) for name, (kind, ends) in kinds.items()
    )
    model = model_of(f'<robot name="r">{links}{joints}</robot>')
    for name, ends in (("wheel", (None, None)), ("arm", ("-1", "2")), ("lift", ("0", "0"))):
        joint = next(joint for joint in model.findall("joint") if joint.findtext("child") == name)
        assert (joint.findtext("axis/limit/lower"), joint.findtext("axis/limit/upper")) == ends
        assert (joint.findtext("axis/limit/effort"), joint.findtext("axis/limit/velocity")) == ("5", "3")
        assert joint.findtext("axis/dynamics/damping") == "0.1"
        assert joint.findtext("axis/xyz") == "1 0 0"


def test_extensions_of_gazebo_go_where_they_belong() -> None:
    text = f"""<robot name="r">{HEAVY.format("base")}
    <link name="part"><collision name="c"><geometry><sphere radius="1"/></geometry></collision>
      <visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="1 0 0 1"/></material></visual>
    </link>{JOINT.format("fixed", "fixed", "base", "part", '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>')}
    {HEAVY.format("arm")}{JOINT.format("arm_joint", "revolute", "part", "arm", "")}
    <gazebo reference="part"><mu1 value="0.3"/><mu2>0.4</mu2><kp>1e6</kp><kd>10</kd><fdir1>1 0 0</fdir1>
      <material>Gazebo/Blue</material><selfCollide>true</selfCollide>
      <sensor name="s" type="imu"><pose>1 0 0 0 0 0</pose></sensor></gazebo>
    <gazebo reference="arm_joint"><springStiffness>3</springStiffness><stopCfm>0.1</stopCfm></gazebo>
    <gazebo><static>false</static><plugin name="p" filename="libp.so"/></gazebo></robot>"""
    model = model_of(text)
    link, joint = model.find("link"), model.find("joint")
    assert link is not None
    assert joint is not None
    surface = {tag: link.findtext(f"collision/surface/friction/ode/{tag}") for tag in ("mu", "mu2", "fdir1")}
    assert surface == {"mu": "0.3", "mu2": "0.4", "fdir1": "1 0 0"}
    assert [link.findtext(f"collision/surface/contact/ode/{tag}") for tag in ("kp", "kd")] == ["1e6", "10"]
    assert link.findtext("visual/material/diffuse") == "1 0 0 1"
    assert link.findtext("visual/material/script/name") == "Gazebo/Blue"
    assert link.findtext("self_collide") == "true"
    pose = [float(word) for word in link.findtext("sensor/pose", "").split()]
    assert pose == pytest.approx([1, 1, 0, 0, 0, np.pi / 2])
    assert joint.findtext("parent") == "base"
    assert joint.findtext("axis/dynamics/spring_stiffness") == "3"
    assert joint.findtext("physics/ode/limit/cfm") == "0.1"
    assert [plugin.get("filename") for plugin in model.findall("plugin")] == ["libp.so"]


def test_a_joint_is_preserved_if_both_of_its_links_have_a_mass() -> None:
    keep = '<gazebo reference="j"><preserveFixedJoint>true</preserveFixedJoint></gazebo>'
    for parent, count in ((HEAVY.format("a"), 2), ('<link name="a"/>', 1)):
        joint = JOINT.format("j", "fixed", "a", "b", "")
        model = model_of(f'<robot name="r">{parent}{HEAVY.format("b")}{joint}{keep}</robot>')
        assert len(model.findall("link")) == count
        assert [joint.get("type") for joint in model.findall("joint")] == ["fixed"] * (count - 1)


def test_tracks_that_the_user_names_stay_links_on_their_fixed_joints(tmp_path: Path) -> None:
    box = '<collision><geometry><box size="0.6 0.1 0.2"/></geometry></collision></link>'
    links = "".join(HEAVY.format(name).replace("</link>", box) for name in ("a", "b"))
    joints = "".join(
        JOINT.format(f"{name}_joint", "fixed", "base", name, f'<origin xyz="0 {y} 0"/>')
        for name, y in (("a", 0.3), ("b", -0.3))
    )
    file = written(tmp_path, "mine.urdf", f'<robot name="r">{HEAVY.format("base")}{links}{joints}</robot>')
    drive = from_file(file, tracks="b,a").drive
    assert isinstance(drive, Tracks)
    assert (drive.body, drive.left, drive.right) == ("base", ("a",), ("b",))
    assert drive.separation == pytest.approx(0.6)
    assert len(ElementTree.fromstring(from_file(file).text).findall("link")) == 1


def test_a_robot_may_be_fixed_in_the_world() -> None:
    joint = JOINT.format("j", "fixed", "world", "base", '<origin xyz="0 0 1"/>')
    model = model_of(f'<robot name="r"><link name="world"/>{HEAVY.format("base")}{joint}</robot>')
    assert [link.get("name") for link in model.findall("link")] == ["base"]
    assert (model.findtext("joint/parent"), model.findtext("link/pose")) == ("world", "0 0 1 0 0 0")


def test_what_moves_without_a_mass_is_left_out_and_named(tmp_path: Path) -> None:
    joints = JOINT.format("j", "continuous", "base", "air", "") + JOINT.format("k", "continuous", "air", "tip", "")
    text = f'<robot name="r">{HEAVY.format("base")}<link name="air"/>{HEAVY.format("tip")}{joints}</robot>'
    robot = read(tmp_path, text)
    assert robot.remarks == ("left out, as they have no mass, or are attached to such a link: air, tip",)
    assert robot.joints == ()


@pytest.mark.parametrize(
    ("inner", "says"),
    [
        ("", "the robot has no <link>"),
        ('<link name="a"/>', "link 'a' has no mass; a simulator needs its <inertial>"),
        (
            '<link name="a"/><link name="b"/>' + JOINT.format("j", "fixed", "a", "b", ""),
            "link 'a' has no mass, nor have those that are fixed to it: 'b'; a simulator needs an <inertial>",
        ),
        (HEAVY.format("a") * 2, "two elements <link> have the name 'a'"),
        (HEAVY.format(""), "a <link> has the name ''; it needs letters, and no ::"),
        (HEAVY.format("a::b"), "a <link> has the name 'a::b'"),
        (HEAVY.format("a") + HEAVY.format("b"), "2 links are the child of no joint: 'a', 'b'; a robot has one"),
        (HEAVY.format("a") + JOINT.format("j", "fixed", "a", "a", ""), "0 links are the child of no joint"),
        (
            HEAVY.format("a") + HEAVY.format("b") + HEAVY.format("c")
            + JOINT.format("j", "fixed", "c", "b", "") + JOINT.format("k", "fixed", "b", "c", ""),
            "the joints above link 'b' form a loop",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b") + JOINT.format("j", "fixed", "a", "b", "") * 2,
            "two elements <joint> have the name 'j'",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b")
            + JOINT.format("j", "fixed", "a", "b", "") + JOINT.format("k", "fixed", "a", "b", ""),
            "link 'b' is the child of two joints, 'j' and 'k'",
        ),
        (
            HEAVY.format("a") + JOINT.format("j", "fixed", "a", "b", ""),
            "joint 'j': there is no link 'b'; if it is a part of a robot, use the file of the robot",
        ),
        (HEAVY.format("a") + '<joint name="j" type="fixed"/>', "joint 'j': there is no link ''"),
        (HEAVY.format("a") + JOINT.format("j", "planar", "a", "a", ""), "joint 'j': its type 'planar' is none of"),
        (HEAVY.format("a").replace('value="1"', 'value="nan"'), "link 'a': mass: 'nan' is not a number"),
        (HEAVY.format("a").replace('value="1"', 'value="-1"'), "link 'a': a mass of -1 kg is not above 0"),
        (HEAVY.format("a").replace('value="1"', 'value="1e300"'), "link 'a': mass: '1e300' is not a number"),
        (HEAVY.format("a").replace('ixx="1"', 'ixx="-1"'), "link 'a': a principal moment of inertia of -1 kg m^2 is"),
        (
            HEAVY.format("a") + HEAVY.format("b").replace('ixx="1"', 'ixx="-3"')
            + JOINT.format("j", "fixed", "a", "b", ""),
            "link 'a' with those that are fixed to it: a principal moment of inertia of -2 kg m^2 is negative",
        ),
        (HEAVY.format("a").replace('ixx="1"', ""), "link 'a': ixx: '' is not a number"),
        (
            '<link name="a"><collision><geometry><cone/></geometry></collision>' + MASS + "</link>",
            "link 'a': a <collision> has none of the shapes box, cylinder, sphere, capsule, mesh",
        ),
        (
            '<link name="a"><visual><geometry><box size="1 1"/></geometry></visual>' + MASS + "</link>",
            "link 'a': a <visual>: '1 1' is not 3 numbers",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b") + JOINT.format("j", "fixed", "a", "b", '<origin xyz="inf 0 0"/>'),
            "joint 'j': 'inf 0 0' is not 3 numbers",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b") + JOINT.format("j", "revolute", "a", "b", '<axis xyz="0 0 0"/>'),
            "joint 'j': its axis 0 0 0 has no direction",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b") + JOINT.format("j", "revolute", "a", "b", '<limit lower="nan"/>'),
            "joint 'j': 'nan' is not a number",
        ),
        (
            HEAVY.format("a") + HEAVY.format("b") + JOINT.format("j", "fixed", "a", "b", '<origin xyz="1 0 0"/>')
            + '<gazebo reference="b"><sensor><pose>1 2</pose></sensor></gazebo>',
            "the pose of a <sensor>: '1 2' is not 6 numbers",
        ),
    ],
)  # fmt: skip
def test_urdf_that_is_no_robot_is_refused_in_one_line(tmp_path: Path, inner: str, says: str) -> None:
    with pytest.raises(FileError, match=r"mine\.urdf: ") as caught:
        read(tmp_path, f'<robot name="r">{inner}</robot>')
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_chain_and_a_heap_of_thousands_take_seconds() -> None:
    """Work that is quadratic in the links, shapes or extensions would take minutes."""
    count = 5000
    chain = "".join(HEAVY.format(f"l{number}") for number in range(count)) + "".join(
        JOINT.format(f"j{number}", "continuous" if number % 2 else "fixed", f"l{number - 1}", f"l{number}", "")
        for number in range(1, count)
    )
    shape = '<collision><geometry><sphere radius="1"/></geometry></collision>'
    lump = "".join(f'<link name="l{number}">{MASS}{shape}</link>' for number in range(count)) + "".join(
        JOINT.format(f"j{number}", "fixed", "l0", f"l{number}", "") for number in range(1, count)
    )
    heap = f'<link name="l">{MASS}{shape * count}</link><gazebo reference="l">{"<mu1>1</mu1>" * count}</gazebo>'
    begin = time.process_time()
    for inner in (chain, lump, heap):
        model_of(f'<robot name="r">{inner}</robot>')
    assert time.process_time() - begin < 20


def model_of(text: str) -> Element:
    model = converted(ElementTree.fromstring(text), "tree").sdf.find("model")
    assert model is not None
    return model


def tensor_in(link: Element) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The tensor of inertia of a link of SDF, in its frame."""
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    return np.asarray(tensor_of([float(link.findtext(f"inertial/inertia/{name}", "")) for name in names]))


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text, "utf-8")
    return folder / name


def read(folder: Path, text: str) -> SdfRobot:
    return from_file(written(folder, "mine.urdf", text))


def test_joints_that_should_follow_another_are_named_in_a_note(tmp_path: Path) -> None:
    links = "".join(HEAVY.format(name) for name in ("base", "a", "b", "c"))
    limit, follows = '<limit lower="0" upper="1"/>', '<mimic joint="left" multiplier="-1"/>'
    joints = (
        JOINT.format("left", "revolute", "base", "a", limit)
        + JOINT.format("right", "revolute", "base", "b", limit + follows)
        + JOINT.format("stuck", "fixed", "base", "c", follows)
    )
    (tmp_path / "hand.urdf").write_text(f'<robot name="hand">{links}{joints}</robot>')
    robot = from_file(tmp_path / "hand.urdf")
    note = "<mimic> has no effect in Gazebo, so these joints move on their own, unless they are held: right"
    assert f"hand: {note}" in list(robot.spawn_notes("classic"))
    assert f"hand: {note}" in list(robot.notes("sim"))
    assert not [said for said in robot.notes("mujoco") if "mimic" in said]
    assert "<mimic" not in robot.file("hand", "sim") + robot.model("hand", "classic")


@pytest.mark.parametrize(
    "plugin",
    [
        "<plugin name='p' filename='libSimpleTrackedVehiclePlugin.so'><body>base</body>"
        "<left_track>left_wheel</left_track><right_track>right_wheel</right_track></plugin>",
        "<plugin name='p' filename='gz-sim-tracked-vehicle-system'><left_track><link>left_wheel</link></left_track>"
        "<right_track><link>right_wheel</link></right_track></plugin>",
        "<plugin name='l' filename='gz-sim-track-controller-system'><link>left_wheel</link></plugin>"
        "<plugin name='r' filename='gz-sim-track-controller-system'><link>right_wheel</link></plugin>",
    ],
)
def test_tracks_that_a_plug_in_names_on_fixed_joints_are_links(tmp_path: Path, plugin: str) -> None:
    file = tmp_path / "tracked.urdf"
    file.write_text(two_wheels_urdf(plugin).replace('type="continuous"', 'type="fixed"'))
    robot = from_file(file)
    assert robot.drive.left == ("left_wheel",)
    assert robot.drive.right == ("right_wheel",)
    assert robot.drive.separation == pytest.approx(0.3)
    read = robot.read_drive
    assert read is not None
    assert (read.separation_by, read.radius_by) == ("its shapes", "its shapes")
