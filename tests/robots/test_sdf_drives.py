"""The drive, the size and the speed of a user's robot are read from its file."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rsegen.errors import FileError, ParameterError, UnknownName
from rsegen.robots.drives import BACKENDS, Tracks, Wheels
from rsegen.robots.files.motors import frictions
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import ModelFrames
from tests.robots import tracked_and_legged
from tests.robots.two_wheels import GZ, PLUGINS, RADIUS, ROS_1, SEPARATION, two_wheels

MESH = "<collision name='m'><geometry><mesh><uri>{}</uri></mesh></geometry></collision>"


def read(folder: Path, text: str, wheels: str | None = None) -> SdfRobot:
    path = folder / "mine.sdf"
    path.write_text(text, "utf-8")
    return from_file(path, wheels)


def plugins(robot: SdfRobot, backend: str) -> list[str]:
    model = ElementTree.fromstring(robot.model("one", backend))
    return [plugin.get("filename", "") for plugin in model.iter("plugin")]


@pytest.mark.parametrize("name", [name for name in PLUGINS if name != "none"])
def test_every_spelling_of_a_drive_gives_the_same_wheels(tmp_path: Path, name: str) -> None:
    drive = read(tmp_path, two_wheels(PLUGINS[name])).drive
    assert isinstance(drive, Wheels)
    assert (drive.left, drive.right) == (("left_hub",), ("right_hub",))
    assert (drive.separation, drive.radius) == pytest.approx((SEPARATION, RADIUS))
    assert drive.spread == pytest.approx(1)


@pytest.mark.parametrize("name", [name for name in PLUGINS if name != "none"])
def test_a_plug_in_that_stands_twice_in_a_file_has_each_wheel_once(tmp_path: Path, name: str) -> None:
    assert read(tmp_path, two_wheels(PLUGINS[name] * 2)).drive == read(tmp_path, two_wheels(PLUGINS[name])).drive


@pytest.mark.parametrize("name", [name for name in PLUGINS if name != "none"])
def test_a_plug_in_that_names_joints_which_are_not_there_is_told_of(tmp_path: Path, name: str) -> None:
    robot = read(tmp_path, two_wheels(PLUGINS[name].replace("left_hub", "left_axle")))
    assert robot.remarks == ("its plug-in names joints that it has not, or that do not turn: left_axle",)


@pytest.mark.parametrize("name", [name for name in PLUGINS if name != "none"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_wheels_of_a_plug_in_whose_axes_point_to_the_right_drive_forward(
    tmp_path: Path, name: str, backend: str
) -> None:
    robot = read(tmp_path, two_wheels(PLUGINS[name], axis=-1))
    assert robot.remarks == (
        "the axes of left_hub, right_hub point to the right, so its plug-in turns these wheels backwards; here all"
        " wheels drive it forward, along x",
    )
    model = ElementTree.fromstring(robot.model("one", backend))
    assert [joint.findtext("axis/xyz") for joint in model.findall("joint")] == ["0 0 1"] * 2
    assert read(tmp_path, two_wheels(PLUGINS[name])).remarks == ()


_OTHER = {"left": "right_joint", "right": "left_joint"}


@pytest.mark.parametrize(
    ("own", "text"),
    [
        ("no sizes", re.sub("<wheel_.*_radius>", "", GZ)),
        ("another radius", GZ.replace(">0.05<", ">0.02<")),
        (
            "sides by other names",
            GZ.replace("left_hub", "r").replace("right_hub", "left_hub").replace(">r<", ">right_hub<"),
        ),
    ],
)
def test_a_plug_in_that_is_kept_has_the_sides_and_sizes_that_were_read(tmp_path: Path, own: str, text: str) -> None:
    robot = read(tmp_path, two_wheels(text))
    model = ElementTree.fromstring(robot.model("one", "sim"))
    (drive,) = (plugin for plugin in model.iter("plugin") if "DiffDrive" in plugin.get("name", ""))
    sizes = [[float(part.text or "") for part in drive.findall(tag)] for tag in ("wheel_separation", "wheel_radius")]
    assert sizes == [[pytest.approx(SEPARATION)], [pytest.approx(RADIUS)]], own
    assert [[part.text for part in drive.findall(f"{side}_joint")] for side in ("left", "right")] == [
        ["left_hub"],
        ["right_hub"],
    ]
    assert drive.findtext("max_linear_velocity") == "0.3"


@pytest.mark.parametrize(
    ("turn", "own", "kept"),
    [("0", "", None), ("0.4", "", None), (math.pi, "", [0, 0, math.pi]), (math.pi, "0 0 3.14159265", [0, 0, math.pi])],
)
def test_a_belt_moves_ahead_whichever_way_its_link_points(
    tmp_path: Path, turn: str | float, own: str, kept: list[float] | None
) -> None:
    orientation = f"<track_orientation>{own}</track_orientation>" if own else ""
    belts = "".join(
        f"<plugin name='p' filename='gz-sim-track-controller-system'><link>{side}</link>{orientation}</plugin>"
        for side in ("left", "right")
    )
    pitch_or_yaw = f"0 {turn} 0" if turn == "0.4" else f"0 0 {turn}"  # a pitched flipper is as it should be
    text = tracked_and_legged.tracked().replace(
        "<pose>0 -0.18 0.08 0 0 0</pose>", f"<pose>0 -0.18 0.08 {pitch_or_yaw}</pose>"
    )
    model = ElementTree.fromstring(read(tmp_path, text.replace("</model>", f"{belts}</model>")).model("one", "sim"))
    (right,) = (plugin for plugin in model.iter("plugin") if plugin.findtext("link") == "right")
    found = right.findtext("track_orientation")
    assert (found and [abs(float(value)) for value in found.split()]) == (kept and pytest.approx(kept, abs=1e-6))


def test_why_a_plug_in_is_not_used_is_said(tmp_path: Path) -> None:
    fixed = two_wheels(GZ).replace('type="revolute"', 'type="fixed"')
    along_y = two_wheels(GZ).replace("-1.5707963267948966 0 0", "0 1.5707963267948966 0")  # its axles are along x
    for text, reason in (
        (fixed, "its plug-in names joints that it has not, or that do not turn: left_hub, right_hub"),
        (along_y, "do not turn about axes along y, as those of robots whose front is along x: left_hub, right_hub"),
    ):
        robot = read(tmp_path, text)
        assert robot.read_drive is None
        with pytest.raises(ParameterError, match=f"no wheels or tracks: .*{re.escape(reason)}; name them"):
            _ = robot.drive


@pytest.mark.parametrize("axis", [1, -1])
def test_wheels_that_the_user_names_are_measured_on_the_model(tmp_path: Path, axis: int) -> None:
    for text in ("left_hub,right_hub", "right_hub,left_hub"):
        robot = read(tmp_path, two_wheels(axis=axis), text)
        drive = robot.drive
        assert isinstance(drive, Wheels)
        assert drive.left == ("left_hub",)
        assert (drive.separation, drive.radius) == pytest.approx((SEPARATION, RADIUS))
        # The plug-ins of drives take it that axes point to the left.
        model = ElementTree.fromstring(robot.model("one"))
        assert [joint.findtext("axis/xyz") for joint in model.findall("joint")] == ["0 0 1"] * 2
        assert "x: 0.2" in robot.command("one", 0.2, 0).text


@pytest.mark.parametrize("name", [name for name in PLUGINS if name != "none"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_simulator_gets_its_own_drive_on_a_topic_of_each_robot(tmp_path: Path, name: str, backend: str) -> None:
    robot = read(tmp_path, two_wheels(PLUGINS[name]))
    own = {"classic": "libDiffDrivePlugin.so", "sim": "gz-sim-", "fortress": "ignition-gazebo-"}[backend]
    files = plugins(robot, backend)
    assert files
    assert all(file.startswith(own) for file in files)
    assert "one" in robot.command("one", 0.1, 0, backend).topic
    model = ElementTree.fromstring(robot.model("one", backend))
    assert {topic.text for topic in model.iter("topic")} <= {"/model/one/cmd_vel"}
    assert not list(model.iter("sensor"))


def test_a_file_for_spawning_keeps_the_elements_of_the_model(tmp_path: Path) -> None:
    text = read(tmp_path, two_wheels(ROS_1, version="1.9")).file("two")
    assert "libgazebo_ros_diff_drive.so" in text
    assert "libgazebo_ros_camera.so" in text
    assert '<sdf version="1.7">' in text  # the latest that Gazebo Classic reads
    assert '<sdf version="1.10">' in read(tmp_path, two_wheels(version="1.10")).file("two", "sim")
    assert '<sdf version="1.6">' in read(tmp_path, two_wheels(version="&quot;>")).file("two", "sim")


def test_size_limits_and_height_come_from_the_user_else_from_the_model(tmp_path: Path) -> None:
    robot = read(tmp_path, two_wheels(GZ))
    assert robot.kind == "my_robot"
    assert robot.size == pytest.approx((0.4, 0.32, 0.13))  # the hull reaches from -0.2 to 0.1
    assert (robot.speed, robot.turn) == (0.3, 1.5)
    assert robot.lift == pytest.approx(0.03)
    pose = ElementTree.fromstring(robot.model("one", at=(1, 2, 3, 0, 0, 0.5))).findtext("pose", "")
    assert [float(word) for word in pose.split()] == pytest.approx([1, 2, 3.03, 0, 0, 0.5])
    given = robot.given({"speed": 0.1})
    assert (given.speed, given.turn, given.drive.speed) == (0.1, 1.5, 0.1)
    assert "speed" not in next(robot.given({"speed": 0.1, "turn": 1}).notes("classic")).split("by its model")[0]


def test_notes_list_derived_and_omitted_values(tmp_path: Path) -> None:
    derived, files, sensors = read(tmp_path, two_wheels(ROS_1)).notes("classic")
    assert derived == (
        "my_robot: its wheels are left_hub,right_hub by gazebo_ros_diff_drive, 0.3 m apart, radius 0.05 m by its"
        " plug-in; size 0.400 x 0.320 x 0.130 m around its origin by its model; speed 0.2 m/s, turn rate 0.5"
        " rad/s by assumption"
    )
    assert files.endswith("not here: libgazebo_ros_joint_state_publisher.so")
    assert sensors.endswith(": eye")


def test_the_radius_of_the_wheels_counts_where_the_plug_in_has_another(tmp_path: Path) -> None:
    robot = read(tmp_path, two_wheels(ROS_1.replace("Diameter>0.1", "Diameter>0.02")))
    assert robot.drive.radius == pytest.approx(0.05)
    note = next(robot.notes("classic"))
    assert "0.3 m apart by its plug-in, radius 0.05 m by its wheels, not 0.01 m by its plug-in;" in note


def test_a_library_of_ros_that_is_here_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "libgazebo_ros_joint_state_publisher.so").touch()
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", f"/nowhere:{tmp_path}")
    robot = read(tmp_path, two_wheels(ROS_1))
    assert plugins(robot, "classic") == ["libgazebo_ros_joint_state_publisher.so", "libDiffDrivePlugin.so"]


def test_axes_of_old_files_are_read_in_the_frame_of_the_model(tmp_path: Path) -> None:
    text = two_wheels(version="1.4").replace("<xyz>0 0 1</xyz>", "<xyz>0 1 0</xyz>")
    robot = read(tmp_path, text, "left_hub,right_hub")
    assert robot.read_drive is not None
    assert not robot.read_drive.turned
    assert robot.text.count("<use_parent_model_frame>true") == 2


@pytest.mark.parametrize("length", ["0.2", "3"])
def test_the_length_of_an_axis_does_not_count(tmp_path: Path, length: str) -> None:
    """Simulators make it 1: libsdformat and MuJoCo as they read it, ODE as a joint gets it."""
    light = two_wheels().replace("<izz>0.0008</izz>", "<izz>1e-5</izz>")
    unit, other = read(tmp_path, light), read(tmp_path, light.replace("<xyz>0 0 1</xyz>", f"<xyz>0 0 {length}</xyz>"))
    assert unit.light_wheels
    assert (other.read_drive, other.light_wheels) == (unit.read_drive, unit.light_wheels)
    tilted = read(tmp_path, light.replace("<xyz>0 0 1</xyz>", f"<xyz>0 {length} {length}</xyz>"))
    assert tilted.read_drive is None, "its wheels are at 45 degrees to the ground"
    with pytest.raises(FileError, match="joint 'left_hub': its axis 0 0 0 has no direction"):
        read(tmp_path, light.replace("<xyz>0 0 1</xyz>", "<xyz>0 0 0</xyz>"))


@pytest.mark.parametrize(
    ("wheels", "says"),
    [
        ("left_hub", "'left_hub' is not LEFT,RIGHT"),
        ("left_hub,", "is not LEFT,RIGHT"),
        ("left_hub+right_hub,left_hub", "is not LEFT,RIGHT"),
        ("left_hub,right", "unknown joint 'right'; did you mean 'right_hub'"),
    ],
)
def test_wheels_that_are_none_are_refused(tmp_path: Path, wheels: str, says: str) -> None:
    with pytest.raises((ParameterError, UnknownName)) as caught:
        read(tmp_path, two_wheels(), wheels)
    assert says in str(caught.value)


def test_wheels_without_a_shape_or_along_another_axis_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="a wheel needs a collision shape"):
        read(tmp_path, two_wheels().replace("cylinder>", "heightmap>"), "left_hub,right_hub")
    with pytest.raises(ParameterError, match="not all along y"):
        read(tmp_path, two_wheels().replace("<xyz>0 0 1</xyz>", "<xyz>1 0 0</xyz>"), "left_hub,right_hub")


def test_a_model_without_a_drive_says_how_to_name_one_and_stands(tmp_path: Path) -> None:
    ends = "<limit><lower>-1</lower><upper>1</upper></limit></axis>"
    robot = read(tmp_path, two_wheels().replace("</axis>", ends))
    assert robot.read_drive is None
    with pytest.raises(ParameterError) as caught:
        robot.command("one", 0, 0)
    line = str(caught.value)
    assert line.startswith("my_robot: no wheels or tracks: ")
    assert "tracks='LEFT,RIGHT', or wheels='LEFT,RIGHT' (left_hub, right_hub)" in line
    assert "\n" not in line
    spawned = ElementTree.fromstring(robot.file("one"))
    assert [joint.get("type") for joint in spawned.iter("joint")] == ["fixed"] * 2
    assert list(robot.spawn_notes("classic")) == [
        "my_robot: has no wheels or tracks, so its joints are held as its model has them: left_hub, right_hub"
    ]


def test_joints_that_a_controller_of_ros_may_move_are_not_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ends = "<limit><lower>-1</lower><upper>1</upper></limit></axis>"
    text = two_wheels('<plugin name="ros" filename="libgazebo_ros_control.so"/>').replace("</axis>", ends)
    assert list(read(tmp_path, text).spawn_notes("classic"))
    (tmp_path / "libgazebo_ros_control.so").touch()
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    robot = read(tmp_path, text)
    assert not list(robot.spawn_notes("classic"))
    joints = ElementTree.fromstring(robot.file("one")).iter("joint")
    assert [joint.get("type") for joint in joints] == ["revolute"] * 2
    own = two_wheels('<plugin name="j" filename="gz-sim-joint-position-controller-system"/>').replace("</axis>", ends)
    robot = read(tmp_path, own)
    assert list(robot.spawn_notes("classic"))
    assert not list(robot.spawn_notes("sim"))


def wheel(name: str, place: str, radius: float = 0.05, parent: str = "base", axis: str = "0 0 1") -> str:
    """A wheel of two_wheels at another place, on a joint of its name and _hub."""
    return (
        f'<link name="{name}"><pose>{place} -1.5707963267948966 0 0</pose><collision name="tyre"><geometry><cylinder>'
        f"<radius>{radius}</radius><length>0.02</length></cylinder></geometry></collision></link>"
        f'<joint name="{name}_hub" type="revolute"><parent>{parent}</parent><child>{name}</child>'
        f"<axis><xyz>{axis}</xyz></axis></joint>"
    )


def test_wheels_are_found_by_their_shapes_and_casters_are_not(tmp_path: Path) -> None:
    robot = read(tmp_path, two_wheels())
    assert robot.drive == read(tmp_path, two_wheels(), "left_hub,right_hub").drive
    assert "by the shapes of its links, as its file does not say, 0.3 m apart" in next(robot.notes("classic"))
    others = {
        "in the middle": wheel("back", "-0.2 0 0.02"),
        "smaller": wheel("l", "-0.2 0.1 -0.01", 0.02) + wheel("r", "-0.2 -0.1 -0.01", 0.02),
        "above the ground": wheel("l", "-0.2 0.1 0.2") + wheel("r", "-0.2 -0.1 0.2"),
        "along x": wheel("l", "-0.2 0.1 0.02", axis="1 0 0") + wheel("r", "-0.2 -0.1 0.02", axis="1 0 0"),
        "swivelling": "".join(
            f'<link name="{side}_fork"><pose>-0.18 {y} 0.02 0 0 0</pose></link><joint name="{side}_swivel"'
            f' type="revolute"><parent>base</parent><child>{side}_fork</child><axis><xyz>0 0 1</xyz></axis></joint>'
            + wheel(side, f"-0.2 {y} 0.02", parent=f"{side}_fork")
            for side, y in (("l", 0.1), ("r", -0.1))
        ),
    }
    for case, more in others.items():
        drive = read(tmp_path, two_wheels(more)).drive
        assert isinstance(drive, Wheels), case
        assert (drive.left, drive.right) == (("left_hub",), ("right_hub",)), case
    four = read(tmp_path, two_wheels(wheel("r", "-0.2 -0.15 0.02") + wheel("l", "-0.2 0.15 0.02"))).drive
    assert isinstance(four, Wheels)
    assert (four.left, four.right) == (("left_hub", "l_hub"), ("right_hub", "r_hub"))


def test_arms_are_held_in_a_drive_and_suspensions_are_not(tmp_path: Path) -> None:
    def joint(name: str, inner: str, limits: str = "<limit><lower>-1</lower><upper>1</upper></limit>") -> str:
        return (
            f'<link name="{name}"/><joint name="{name}_joint" type="revolute"><parent>base</parent>'
            f"<child>{name}</child><axis><xyz>0 1 0</xyz>{limits}{inner}</axis></joint>"
        )

    spring = "<dynamics><spring_stiffness>5</spring_stiffness></dynamics>"
    fixed = '<link name="mast"/><joint name="mast_joint" type="fixed"><parent>base</parent><child>mast</child></joint>'
    parts = joint("arm", "") + joint("damper", spring) + joint("lidar", "", "")
    robot = read(tmp_path, two_wheels(GZ + parts + fixed))
    assert robot.held == ("arm_joint",)
    for backend in BACKENDS:
        model = ElementTree.fromstring(robot.model("one", backend))
        kinds = {each.get("name"): each.get("type") for each in model.findall("joint")}
        for name in ("arm_joint", "mast_joint"):
            assert kinds.pop(name, None) == (
                None if backend == "classic" else "fixed"
            )  # there it is a part of the base
        assert {*kinds.values()} == {"revolute"}
    assert any(
        note.endswith("held as its model has them, as nothing drives them: arm_joint") for note in robot.notes("sim")
    )


BOX = "<collision name='c'><geometry><box><size>{} 0.1 0.2</size></box></geometry></collision>"
TRACKS = "".join(
    f"<link name='{name}'><pose>{x} {y} 0.1 0 0 0</pose>{BOX.format(length)}</link><joint name='{name}_joint'"
    f" type='revolute'><parent>base</parent><child>{name}</child><axis><xyz>0 1 0</xyz></axis></joint>"
    for name, x, y, length in (("l", 0, 0.3, 0.6), ("r", 0, -0.3, 0.6), ("lf", 0.4, 0.3, 0.3), ("rf", 0.4, -0.3, 0.3))
)


def tracked(plugin: str = "") -> str:
    return f'<sdf version="1.6"><model name="t"><link name="base"/>{TRACKS}{plugin}</model></sdf>'


def test_tracks_and_flippers_are_those_that_the_user_names(tmp_path: Path) -> None:
    (tmp_path / "mine.sdf").write_text(tracked())
    robot = from_file(tmp_path / "mine.sdf", tracks="r+rf,l+lf")
    drive = robot.drive
    assert isinstance(drive, Tracks)
    assert (drive.body, drive.left, drive.right) == ("base", ("l", "lf"), ("r", "rf"))
    assert (drive.separation, drive.radius) == pytest.approx((0.6, 0.1))
    model = ElementTree.fromstring(robot.model("one"))
    plugin = model.find("plugin")
    assert plugin is not None
    assert (plugin.findtext("left_track"), plugin.findtext("left_flipper")) == ("r", "rf")  # Classic calls left right
    # Nothing moves tracks or flippers, so they keep their angles.
    assert [joint.get("type") for joint in model.findall("joint")] == ["fixed"] * 4
    for text, says in (("l", "is not LEFT,RIGHT"), ("l,x", "unknown link 'x'"), ("l,l", "in one place")):
        with pytest.raises((ParameterError, UnknownName)) as caught:
            from_file(tmp_path / "mine.sdf", tracks=text)
        assert says in str(caught.value)


@pytest.mark.parametrize("file", ["gz-sim-track-controller-system", "libignition-gazebo-track-controller-system.so"])
def test_tracks_are_those_with_a_controller_of_their_own(tmp_path: Path, file: str) -> None:
    controllers = "".join(
        f"<plugin filename='{file}' name='c'><link>{link}</link><max_velocity>0.6</max_velocity></plugin>"
        for link in ("lf", "rf", "l", "r")
    )
    robot = read(tmp_path, tracked(controllers))
    drive = robot.drive
    assert isinstance(drive, Tracks)
    assert (drive.left, drive.right) == (("l", "lf"), ("r", "rf"))
    assert robot.speed == 0.6
    files = plugins(robot, "sim")
    assert (files.count("gz-sim-tracked-vehicle-system"), files.count("gz-sim-track-controller-system")) == (1, 4)


def test_tracks_of_either_gazebo_are_driven_in_both(tmp_path: Path) -> None:
    box = "<collision name='c'><geometry><box><size>0.6 0.1 0.2</size></box></geometry></collision>"
    belts = "".join(
        f"<link name='{side}'><pose>0 {y} 0.1 0 0 0</pose>{box}</link>" for side, y in (("a", 1), ("b", -1))
    )
    sim = (
        '<plugin filename="gz-sim-tracked-vehicle-system" name="gz::sim::systems::TrackedVehicle">'
        "<left_track><link>a</link></left_track><right_track><link>b</link></right_track>"
        "<tracks_separation>2</tracks_separation><linear_velocity><max_velocity>0.7</max_velocity></linear_velocity>"
        "</plugin>"
    )
    classic = (
        '<plugin filename="libSimpleTrackedVehiclePlugin.so" name="t"><body>base</body>'
        "<left_track>b</left_track><right_track>a</right_track><max_linear_speed>0.7</max_linear_speed></plugin>"
    )
    for plugin in (sim, classic):
        text = f'<sdf version="1.6"><model name="t"><link name="base"/>{belts}{plugin}</model></sdf>'
        robot = read(tmp_path, text)
        drive = robot.drive
        assert isinstance(drive, Tracks)
        assert (drive.body, drive.left, drive.right, drive.separation) == ("base", ("a",), ("b",), 2)
        assert (robot.speed, drive.radius) == pytest.approx((0.7, 0.1))
        assert plugins(robot, "classic") == ["libSimpleTrackedVehiclePlugin.so"]
        # Belts without a controller would not move.
        *drives, _ = plugins(robot, "sim")
        assert drives == ["gz-sim-tracked-vehicle-system", *["gz-sim-track-controller-system"] * 2]


def test_controllers_of_belts_are_kept_for_a_drive_but_listen_where_it_commands_them(tmp_path: Path) -> None:
    vehicle = (
        '<plugin filename="gz-sim-tracked-vehicle-system" name="v"><topic>go</topic>'
        + "".join(f"<{s}_track><link>{s[0]}</link></{s}_track>" for s in ("left", "right"))
        + "</plugin>"
    )
    controllers = "".join(
        f'<plugin filename="gz-sim-track-controller-system" name="c"><link>{link}</link>'
        "<velocity_topic>v</velocity_topic><center_of_rotation_topic>c</center_of_rotation_topic>"
        "<max_acceleration>3</max_acceleration></plugin>"
        for link in "lr"
    )
    robot = read(tmp_path, tracked(vehicle + controllers))
    model = ElementTree.fromstring(robot.model("one", "sim"))
    kept = [[(part.tag, part.text) for part in plugin] for plugin in model.iter("plugin")][1:3]
    assert kept == [[("link", link), ("max_acceleration", "3")] for link in "lr"]


def test_meshes_are_found_next_to_the_package_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("models/mine", "models/common/meshes", "elsewhere/far"):
        (tmp_path / folder).mkdir(parents=True)
    solid = "v 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
    (tmp_path / "models/common/meshes/hull.obj").write_text(solid)
    (tmp_path / "elsewhere/far/hull.obj").write_text(solid)
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path / "elsewhere"))
    for uri in ("model://common/meshes/hull.obj", "../common/meshes/hull.obj", "model://far/hull.obj"):
        text = f'<sdf version="1.6"><model name="m"><link name="l">{MESH.format(uri)}</link></model></sdf>'
        robot = read(tmp_path / "models/mine", text)
        found = ElementTree.fromstring(robot.model("m")).findtext(".//uri", "")
        assert Path(found).is_absolute()
        assert Path(found).samefile(tmp_path / "elsewhere/far/hull.obj") or "common" in found
        assert robot.size == pytest.approx((0.6, 0.4, 0.1))


def test_a_mesh_that_is_nowhere_is_refused_in_a_line(tmp_path: Path) -> None:
    text = f'<sdf version="1.6"><model name="m"><link name="l">{MESH.format("model://no/h.stl")}</link></model></sdf>'
    with pytest.raises(FileError, match=r"model://no/h\.stl of a collision shape is not found; put its package"):
        read(tmp_path, text)


@pytest.mark.parametrize("pose", ["1 2", "a b c d e f", "nan 0 0 0 0 0", "1e308 0 0 0 0 0"])
def test_a_pose_that_is_no_pose_is_refused(tmp_path: Path, pose: str) -> None:
    with pytest.raises(FileError, match="is not 6 numbers"):
        read(tmp_path, two_wheels().replace("0 0 0.02 0 0 0", pose, 1))


@pytest.mark.parametrize("mu", ["rubber", " ", "1 1", "nan"])
def test_a_friction_that_is_no_number_is_refused(tmp_path: Path, mu: str) -> None:
    with pytest.raises(FileError, match=r"mine\.sdf: '.*' is not a number, as its <mu> of friction has to be"):
        read(tmp_path, two_wheels().replace("<mu>1</mu>", f"<mu>{mu}</mu>"))


@pytest.mark.parametrize("mu", ["1e16", "inf", "100000000"])
def test_wheels_that_are_not_to_slip_have_any_friction(tmp_path: Path, mu: str) -> None:
    """None beyond a million, as blocks have less, and a pose by it is that by any smaller one above theirs."""
    text = two_wheels(ROS_1)
    usual, robot = read(tmp_path, text), read(tmp_path, text.replace("<mu>1</mu>", f"<mu>{mu}</mu>"))
    frames = ModelFrames(ElementTree.fromstring(robot.model("m")), "m")
    assert frictions(robot.drive, frames) == [1e6] * 2
    assert [part.mu for part in robot.body.parts] == [part.mu for part in usual.body.parts]


def test_links_and_joints_of_old_files_may_have_the_same_names(tmp_path: Path) -> None:
    drive = read(tmp_path, two_wheels().replace("_hub", "_wheel"), "left_wheel,right_wheel").drive
    assert (drive.separation, drive.radius) == pytest.approx((SEPARATION, RADIUS))


@pytest.mark.parametrize("parent", ["__model__", "front", "base"])
def test_joints_on_frames_hang_on_the_links_to_which_these_are_attached(tmp_path: Path, parent: str) -> None:
    text = two_wheels(ROS_1, "1.9")
    frames = (
        "<frame name='front' attached_to='base'><pose>1 0 0 0 0 0</pose></frame>"
        "<frame name='turned' attached_to='left_wheel'><pose degrees='true'>0 0.1 0 90 0 0</pose></frame>"
        "<frame name='hub' attached_to='turned'/>"
    )
    text = text.replace("<child>left_wheel</child><axis><xyz>0 0 1", "<child>hub</child><axis><xyz>0 1 0")
    text = text.replace("<parent>base</parent>", f"<parent>{parent}</parent>").replace("</model>", f"{frames}</model>")
    robot, plain = read(tmp_path, text), read(tmp_path, two_wheels(ROS_1))
    assert robot.drive.joints == plain.drive.joints
    assert (robot.drive.separation, robot.drive.radius) == (plain.drive.separation, plain.drive.radius)
    frames_of = ModelFrames(ElementTree.fromstring(robot.text), "test")
    assert {frames_of.parent(joint) for joint in robot.drive.joints} == {"base"}
    assert frames_of.joint("left_hub")[:3, 3] == pytest.approx((0, 0.15, -0.08))
    assert frames_of.axis("left_hub") == pytest.approx((0, 1, 0))


def test_a_frame_of_a_joint_is_attached_to_the_link_that_the_joint_turns(tmp_path: Path) -> None:
    cap = (
        "<frame name='rim' attached_to='left_hub'/><link name='cap'/>"
        "<joint name='bolt' type='fixed'><parent>rim</parent><child>cap</child></joint>"
    )
    robot = read(tmp_path, two_wheels(ROS_1, "1.9").replace("</model>", f"{cap}</model>"))
    assert ModelFrames(ElementTree.fromstring(robot.text), "test").parent("bolt") == "left_wheel"


@pytest.mark.parametrize("frames", ["<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/>"])
def test_frames_that_are_attached_to_themselves_are_refused(tmp_path: Path, frames: str) -> None:
    text = two_wheels(version="1.9").replace("<child>left_wheel", "<child>a").replace("</model>", f"{frames}</model>")
    with pytest.raises(FileError, match="is attached to itself"):
        read(tmp_path, text)


def test_frames_that_go_round_in_a_circle_are_refused(tmp_path: Path) -> None:
    text = two_wheels().replace("<pose>0 0 0.02", "<pose relative_to='base'>0 0 0.02", 1)
    with pytest.raises(FileError, match="the pose of 'base' is relative to itself"):
        read(tmp_path, text)


def test_poses_may_be_in_degrees_quaternions_and_other_frames(tmp_path: Path) -> None:
    half = math.sqrt(0.5)
    pose = "<pose>0 {y} 0.02 -1.5707963267948966 0 0</pose>"
    for other in (
        '<pose degrees="true">0 {y} 0.02 -90 0 0</pose>',
        f'<pose rotation_format="quat_xyzw">0 {{y}} 0.02 {-half} 0 0 {half}</pose>',
        '<pose relative_to="base">0 {y} 0 -1.5707963267948966 0 0</pose>',
    ):
        text = two_wheels()
        for y in (0.15, -0.15):
            text = text.replace(pose.format(y=y), other.format(y=y))
        assert read(tmp_path, text).size == pytest.approx((0.4, 0.32, 0.13))


@pytest.mark.parametrize(("moment", "is_light"), [("1e-6", True), ("1.7e-5", True), ("2e-4", True), ("5e-2", False)])
def test_wheels_that_are_too_light_for_a_drive_without_torque_are_named(
    tmp_path: Path, moment: str, *, is_light: bool
) -> None:
    """The cylinder of a wheel is about z, and its joint turns it; 3.4 kg weigh 33 N, and 0.05 m is its radius."""
    text = two_wheels(ROS_1).replace("<izz>0.0008</izz>", f"<izz>{moment}</izz>")
    assert text.count(f"<izz>{moment}</izz>") == 2
    robot = read(tmp_path, text)
    notes = [note for note in robot.notes("classic") if "its wheels are light" in note]
    assert len(notes) == is_light
    newtons = 2 * float(moment) * robot.driving_speed / (0.05**2 * 0.001)
    assert all(f"they push with {newtons:.3g} N at 0.2 m/s, and the robot weighs 33.4 N" in note for note in notes)
    assert not any("its wheels are light" in note for note in robot.notes("sim"))


@pytest.mark.parametrize(("moment", "is_light"), [("1e-6", True), ("5e-2", False)])
def test_the_moment_of_a_wheel_is_about_its_axis_however_its_inertial_is_turned(
    tmp_path: Path, moment: str, *, is_light: bool
) -> None:
    turned = f"<inertial><pose>0 0 0 {math.pi / 2} 0 0</pose><mass>0.2</mass>"  # its y is the z of the wheel
    text = two_wheels(ROS_1).replace("<inertial><mass>0.2</mass>", turned)
    text = text.replace("<iyy>0.0005</iyy>", f"<iyy>{moment}</iyy>")
    assert text.count(turned) == text.count(f"<iyy>{moment}</iyy>") == 2
    assert bool(read(tmp_path, text).light_wheels) is is_light


def test_enough_inertia_for_a_drive_without_torque_is_enough(tmp_path: Path) -> None:
    light = read(tmp_path, two_wheels(ROS_1).replace("<izz>0.0008</izz>", "<izz>1e-5</izz>")).light_wheels
    enough = re.search(r"about its axis to (\S+) kg m\^2", light)
    assert enough is not None
    assert not read(tmp_path, two_wheels(ROS_1).replace("<izz>0.0008</izz>", f"<izz>{enough[1]}</izz>")).light_wheels


@pytest.mark.parametrize(
    ("limits", "speed", "turn"),
    [
        ("<max_velocity>0.8</max_velocity>", 0.8, 0.8),
        ("<max_velocity>0.3</max_velocity><max_angular_velocity>1.5</max_angular_velocity>", 0.3, 1.5),
        ("<max_linear_velocity>0.4</max_linear_velocity><max_velocity>0.3</max_velocity>", 0.4, 0.3),
        ("<max_linear_velocity>0.4</max_linear_velocity>", 0.4, 0.5),
    ],
)
def test_a_velocity_of_gazebo_sims_wheels_limits_their_speed_and_turn_rate(
    tmp_path: Path, limits: str, speed: float, turn: float
) -> None:
    """Gazebo Sim's DiffDrive and MecanumDrive take `max_velocity` for both, and those of one of them before it."""
    own = "<max_linear_velocity>0.3</max_linear_velocity><max_angular_velocity>1.5</max_angular_velocity>"
    assert own in GZ
    robot = read(tmp_path, two_wheels(GZ.replace(own, limits)))
    assert (robot.drive.speed, robot.drive.turn) == (speed, turn)
    assert ("turn" in robot.assumed) == ("angular" not in limits and "max_velocity" not in limits)
