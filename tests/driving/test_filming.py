"""Pictures and videos of drives in MuJoCo: they show map and robots, and change nothing."""

from __future__ import annotations

import io
import json
import sys
from math import hypot
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen.cli.edge import main
from rsegen.driving.drive import DriveResult
from rsegen.driving.filming import FRAME, PICTURE, VIDEO
from rsegen.driving.world_file import camera_model
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.poses import rotation
from rsegen.pictures.camera import south_west_of
from tests.simulators.standins import PROGRAMS, put
from tests.support.complaints import the_line

RECIPE = rsegen.Recipe(seed=1, chunk_size=12, unit_cm=2, boundary="none", obstacles=(rsegen.Random(levels=3),))
GREEN = (0.1, 0.9, 0.2)
"""A colour that neither map nor ground has."""

MODEL = f"""<sdf version="1.7"><model name="cart">
  <link name="base"><pose>0 0 0.1 0 0 0</pose><inertial><mass>2</mass>{{inertia}}</inertial>
    <collision name="hull"><geometry><box><size>0.3 0.16 0.06</size></box></geometry></collision>
    <visual name="hull"><geometry><box><size>0.3 0.16 0.06</size></box></geometry>
      <material><diffuse>{" ".join(map(str, GREEN))} 1</diffuse></material></visual>
  </link>
  {{wheels}}
</model></sdf>"""
WHEEL = """<link name="{side}{x}"><pose>{x} {y} 0.08 -1.5708 0 0</pose><inertial><mass>0.2</mass>{inertia}</inertial>
  <collision name="tread"><geometry><cylinder><radius>0.08</radius><length>0.03</length></cylinder></geometry>
  </collision></link><joint name="{side}{x}_joint" type="revolute"><parent>base</parent><child>{side}{x}</child>
  <axis><xyz>0 0 1</xyz></axis></joint>"""
INERTIA = "<inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.001</izz></inertia>"


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    """A robot of a file, whose hull is green; wheels have no visuals."""
    places = [(side, x, y) for side, y in (("left", 0.12), ("right", -0.12)) for x in (0.1, -0.1)]
    file = tmp_path / "cart.sdf"
    wheels = (WHEEL.format(side=side, x=x, y=y, inertia=INERTIA) for side, x, y in places)
    file.write_text(MODEL.format(inertia=INERTIA, wheels="".join(wheels)))
    return file


def drive(cart: Path, **given: Any) -> DriveResult:
    return rsegen.drive(RECIPE, robot=str(cart), duration=2.0, seed=3, simulator="mujoco", predict=False, **given)


def frames(video: bytes) -> list[tuple[int, Array]]:
    """Each frame with the milliseconds at which it ends."""
    every = []
    with Image.open(io.BytesIO(video)) as image:
        for number in range(image.n_frames):  # type: ignore[attr-defined]  # of animations
            image.seek(number)
            image.load()
            every.append((image.info["timestamp"] + image.info["duration"], np.asarray(image.convert("RGB")) / 255))
    return every


def greens(picture: Array) -> Ints:
    """Rows and columns of pixels in the colour of the hull, lit or not."""
    red, green, blue = np.moveaxis(picture, 2, 0)
    return np.argwhere((green > 3 * red) & (green > 2 * blue) & (green > 0.3))


def hull(row: Array, pixels: tuple[int, int]) -> Array:
    """Row and column of the middle of the hull, for a row of a trajectory."""
    x, y, z, roll, pitch, yaw = row[1:]
    place = np.array([x, y, z]) + rotation(roll, pitch, yaw) @ (0, 0, 0.1)
    column, row, _ = south_west_of(rsegen.compose(RECIPE).field.extent, pixels).projected(place)
    return np.array([row, column])


def test_a_picture_shows_the_map_and_the_robot_where_it_is_at_the_end(cart: Path, tmp_path: Path) -> None:
    result = drive(cart, picture=True, output=tmp_path / "out")
    with Image.open(tmp_path / "out" / "picture.jpg") as image:
        assert image.size == PICTURE
        picture = np.asarray(image.convert("RGB")) / 255
    assert (tmp_path / "out" / "picture.jpg").read_bytes() == result.image
    scene, places = result.scene, greens(picture)
    assert len(places) > 300
    assert hypot(*(places.mean(axis=0) - hull(result.robots[0].trajectory.rows[-1], PICTURE))) < 12
    for level in range(1, 3):  # a JPEG, so colours are near
        assert (np.abs(picture - scene.surface_colour(level)).max(axis=2) < 0.05).mean() > 0.005


def test_a_video_shows_the_drive_in_real_time(cart: Path, tmp_path: Path) -> None:
    result = drive(cart, video=True, output=tmp_path / "out")
    assert (tmp_path / "out" / "drive.webp").read_bytes() == result.video
    shown, rows = frames(result.video), result.robots[0].trajectory.rows
    assert shown[0][1].shape[1::-1] == VIDEO
    assert shown[-1][0] == pytest.approx(1000 * (rows[-1, 0] + FRAME), abs=1000 * FRAME)
    assert len(shown) > 10
    for end, picture in shown[::5]:
        now = np.array([np.interp(end / 1000 - FRAME, rows[:, 0], column) for column in rows.T])
        assert hypot(*(greens(picture).mean(axis=0) - hull(now, VIDEO))) < 6
    start, end = (greens(shown[at][1]).mean(axis=0) for at in (0, -1))
    assert hypot(*(end - start)) > 20


def test_a_drive_is_the_same_with_pictures(cart: Path, tmp_path: Path) -> None:
    plain, pictured = drive(cart), drive(cart, picture=True, video=True, output=tmp_path / "out")
    assert plain.as_json() == pictured.as_json()
    assert np.array_equal(plain.robots[0].trajectory.rows, pictured.robots[0].trajectory.rows)
    assert plain.contact_samples == pictured.contact_samples
    assert (plain.image, plain.video) == (b"", b"")
    again = drive(cart, picture=True, video=True, output=tmp_path / "again")
    assert (again.image, again.video) == (pictured.image, pictured.video)


@pytest.mark.long(reason="one robot in make test")
def test_several_robots_are_in_one_picture(tmp_path: Path) -> None:
    given: dict[str, Any] = {"duration": 0.5, "seed": 3, "simulator": "mujoco", "predict": False, "picture": True}
    one, two = (rsegen.drive(RECIPE, robots=number, output=tmp_path / str(number), **given) for number in (1, 2))
    pictures = [np.asarray(Image.open(io.BytesIO(result.image)).convert("RGB")) for result in (one, two)]
    dark = [(picture.max(axis=2) < 40).sum() for picture in pictures]
    assert 1.5 < dark[1] / dark[0] < 2.5  # wheels and lidar of the burger


def test_gazebo_s_camera_is_at_the_same_place(tmp_path: Path) -> None:
    frames = tmp_path / "R&D <1>"
    camera = south_west_of((2.0, 3.0))
    model = fromstring(camera_model((2.0, 3.0), (1280, 720), rate=1, frames=frames))
    assert model.findtext(".//save/path") == str(frames)
    pose = [float(word) for word in (model.findtext("pose") or "").split()]
    assert pose == pytest.approx([*camera.place, 0, camera.pitch, camera.yaw], abs=1e-6)
    assert float(model.findtext(".//horizontal_fov") or 0) == camera.view


def test_a_dry_run_names_pictures(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    flags = ["--duration", "1", "--picture", "--video", "-o", str(tmp_path / "out"), "--dry-run", "--json"]
    assert main(["drive", "peak", "--simulator", "mujoco", *flags]) == 0
    listed = json.dumps(json.loads(capsys.readouterr().out))
    assert "picture.jpg" in listed
    assert "drive.webp" in listed
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
def test_gazebo_needs_a_screen_for_a_picture_and_has_no_video(
    programs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put(programs, PROGRAMS["classic"])
    given: dict[str, Any] = {"simulator": "classic", "output": tmp_path / "out"}
    with pytest.raises(ParameterError, match=r"^picture: Gazebo's camera needs a screen"):
        rsegen.drive(RECIPE, picture=True, **given)
    with pytest.raises(ParameterError, match=r"^video: is for MuJoCo; Gazebo cannot record a video"):
        rsegen.drive(RECIPE, video=True, **given)
    assert main(["drive", "peak", "--video"]) == 2
    assert the_line(capsys.readouterr().err) == "rsegen: --video: needs a folder to write into; set --output DIR too"
