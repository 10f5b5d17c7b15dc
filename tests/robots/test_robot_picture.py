"""A picture shows what a robot looks like, and beside it what of it touches; what is not in it is said."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.geometry.mesh_files import Triangles
from rsegen.robots import robot_picture as module
from rsegen.robots import visuals
from rsegen.robots.base import ROBOTS
from rsegen.robots.files import meshes
from rsegen.robots.files.meshes import read_mesh
from rsegen.robots.lookup import robot_of
from rsegen.robots.visuals import placed_shapes

RED = "<material><diffuse>1 0 0 1</diffuse></material>"
BALL = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
BOX = "<geometry><box><size>0.4 0.2 0.1</size></box></geometry>"


def model(folder: Path, *shapes: str) -> Path:
    file = folder / "thing.sdf"
    link = f"<link name='base'><pose>0 0 0.3 0 0 0</pose>{''.join(shapes)}</link>"
    file.write_text(f"<sdf version='1.7'><model name='thing'>{link}</model></sdf>")
    return file


def visual(geometry: str, name: str = "v", material: str = "") -> str:
    return f"<visual name='{name}'>{geometry}{material}</visual>"


def collision(geometry: str) -> str:
    return f"<collision name='c'>{geometry}</collision>"


def halves(content: bytes) -> tuple[Array, Array]:
    pixels = np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(np.float64)
    middle = pixels.shape[1] // 2
    return pixels[:, :middle], pixels[:, middle:]


def reddish(pixels: Array) -> int:
    red, green, blue = np.moveaxis(pixels, -1, 0)
    return int(((red > green + 60) & (red > blue + 60)).sum())


def test_visual_shapes_are_on_the_left_and_collision_shapes_on_the_right(tmp_path: Path) -> None:
    file = model(tmp_path, visual(BALL, material=RED), collision(BOX))
    left, right = halves(rsegen.robot_picture(file))
    assert reddish(left) > 5000
    assert reddish(right) == 0
    file = model(tmp_path, visual(BOX, material=RED), collision(BOX))
    assert reddish(halves(rsegen.robot_picture(file))[0]) > 5000


@pytest.mark.parametrize("kind", ROBOTS)
def test_all_of_a_robot_and_the_ground_below_it_are_seen(kind: str) -> None:
    robot = robot_of(kind)
    for half in ("visual", "collision"):
        drawn = placed_shapes(robot, half)
        assert not drawn.not_drawn
        points = np.concatenate([shape.points for shape in drawn.shapes])
        assert points[:, 2].min() == pytest.approx(0, abs=2e-3)
        if half == "visual":  # collision shapes may leave out what nothing touches
            assert np.ptp(points, axis=0) == pytest.approx(robot.size, rel=0.1)
        ruler = module._ruler(points.min(axis=0), points.max(axis=0), module._step(float(np.ptp(points[:, 0]))))
        every = np.concatenate([points, ruler.corners.reshape(-1, 3)]) + np.array([5.0, -3.0, 2.0])  # wherever it is
        seen = module._camera(every).projected(every)[:, :2]
        assert (seen > 0).all()
        assert (seen < module._SIDE).all()
        assert np.ptp(seen, axis=0).max() > 0.7 * module._SIDE


@pytest.mark.parametrize(
    ("length", "step"), [(0.975, 0.2), (0.138, 0.02), (0.4, 0.1), (1.0, 0.2), (3.0, 0.5), (0.0, 0.0002)]
)
def test_a_ruler_has_round_parts_and_is_as_long_as_the_robot(length: float, step: float) -> None:
    assert module._step(length) == pytest.approx(step)
    if length:
        ruler = module._ruler(np.array([-length / 2, -0.1, 0.0]), np.array([length / 2, 0.1, 0.1]), step)
        x = ruler.corners[..., 0]
        assert np.ptp(x) >= length - 1e-9
        assert np.ptp(x) < length + step
        assert np.ptp(x, axis=1) == pytest.approx(step)
        assert ruler.corners[..., 1].max() < -0.1
        assert len(np.unique(ruler.colours, axis=0)) == 2


def test_meshes_that_are_missing_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gone = "<geometry><mesh><uri>{}</uri></mesh></geometry>"
    here = [visual(gone.format(uri), name) for name, uri in (("a", "package://shop/hull.dae"), ("b", "arm.stl"))]
    file = model(tmp_path, *here, visual(BALL, "c"), collision(BOX))
    (tmp_path / "arm.stl").write_bytes(b"no mesh")
    out = tmp_path / "thing.png"
    assert main(["robot", str(file), "--picture", str(out), "--json"]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")
    remarks = json.loads(capsys.readouterr().out)["remarks"]
    first, second = (remark for remark in remarks if remark.startswith("not in the picture, of the visual of base: "))
    assert first.endswith("package://shop/hull.dae is not found")
    assert "arm.stl: " in second
    drawn = placed_shapes(robot_of(file), "visual")
    assert len(drawn.shapes) == 1
    assert module._in_words(drawn) == "1 shapes, 0.195 x 0.195 x 0.200 m, lowest at -0.050 m, 2 not drawn"


def test_shapes_that_are_not_known_are_named_and_a_robot_without_any_is_refused(tmp_path: Path) -> None:
    line = "<geometry><polyline><height>1</height></polyline></geometry>"
    robot = robot_of(model(tmp_path, visual(line), collision(BOX)))
    assert placed_shapes(robot, "visual").not_drawn == {"a <polyline> is not drawn": ["base"]}
    assert module.picture_and_gaps(robot, "png")[1] == [
        "not in the picture, of the visual of base: a <polyline> is not drawn"
    ]
    with pytest.raises(ParameterError, match="thing: has no shapes that can be drawn"):
        rsegen.robot_picture(model(tmp_path))


@pytest.mark.long(reason="the files of other pictures in make test")
def test_the_file_is_written_as_any_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "burger.png"
    assert main(["robot", "burger", "--picture", str(out)]) == 0
    content = out.read_bytes()
    assert content == rsegen.robot_picture("burger")
    assert main(["robot", "burger", "--picture", str(out)]) == 2
    assert main(["robot", "burger", "--picture", str(out), "--force"]) == 0
    assert out.read_bytes() == content
    capsys.readouterr()
    assert main(["robot", "burger", "--picture", str(tmp_path / "burger.txt")]) == 2
    assert "a picture's name must end in" in capsys.readouterr().err
    assert main(["robot", "--picture", str(tmp_path / "all.png")]) == 2
    assert "--picture: is for one robot: name it first" in capsys.readouterr().err
    assert main(["robot", "burger", "--picture", str(tmp_path / "b.svg"), "--dry-run"]) == 0
    assert not (tmp_path / "b.svg").exists()


def test_a_mesh_of_many_faces_is_read_once_and_drawn_with_fewer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.2)
    ball.export(tmp_path / "ball.stl")
    mesh = "<geometry><mesh><uri>ball.stl</uri></mesh></geometry>"
    robot = robot_of(model(tmp_path, visual(mesh), collision(mesh)))
    exact, read = halves(rsegen.robot_picture(robot)), []

    def counted(path: Path) -> Triangles:
        read.append(path.name)
        return read_mesh(path)

    monkeypatch.setattr(visuals, "read_mesh", counted)
    monkeypatch.setattr(meshes, "MANY_FACES", 1000)
    monkeypatch.setattr(visuals, "_FINEST", 40)
    few = halves(rsegen.robot_picture(robot))
    assert read == ["ball.stl"]
    (drawn,) = placed_shapes(robot, "visual").shapes
    assert 1000 < len(drawn.corners) < len(ball.faces) / 2
    for half, wanted in zip(few, exact, strict=True):
        off = np.abs(half.astype(int) - wanted.astype(int)).max(axis=-1)
        assert 0 < (off > 40).mean() < 0.02
