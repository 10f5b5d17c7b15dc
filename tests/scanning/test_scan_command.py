"""`rsegen scan` and `rsegen compare`: from a cloud to a world and back to the person with the mallet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import rsegen
from benchmarks.depth_camera import DepthCamera, Flaws, cast, scanned, turned
from rsegen import Random, Recipe
from rsegen.cli.edge import main

RECIPE = Recipe(seed=5, boundary="outer", obstacles=(Random(levels=5),))
EYES = (DepthCamera(place=(0.5, 0.2, 2.3)), DepthCamera(place=(-0.4, -0.4, 2.3)))


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cloud of RECIPE with one block that is a level too high, in a frame of its own, and the recipe beside it."""
    folder = tmp_path_factory.mktemp("cloud")
    field = rsegen.build(RECIPE, 0)
    levels = field.levels.copy()
    levels[4, 5] += 1
    built = rsegen.StepField(
        levels=levels, frame=field.frame, block_width=0.1, unit=0.1, frame_height=field.frame_height
    )
    rng = np.random.default_rng(2)
    points = turned(scanned(built, EYES, Flaws(noise=0.004, missing=0.2, outliers=0.02), rng), rng)
    np.savetxt(folder / "pallet.xyz", points, fmt="%.4f")
    rsegen.save(RECIPE, folder / "wanted.yaml")
    return folder / "pallet.xyz"


def width(picture: Path) -> int:
    with Image.open(picture) as opened:
        return opened.size[0]


@pytest.mark.slow
def test_a_scan_becomes_a_world_a_sheet_and_a_picture(
    cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scan", str(cloud), "-o", str(tmp_path), "--name", "twin", "--friction", "0.7"]) == 0
    said = capsys.readouterr().out
    assert "10 x 10 blocks 10 cm wide" in said
    assert "outer frames 10 cm high" in said
    assert {path.name for path in tmp_path.iterdir()} == {
        *(".rsegen.jsonl", "twin_0000", "twin_fit.png", "twin_confidence.csv")
    }
    assert {"twin_0000.world", "sheet.pdf", "sheet.csv", "recipe.json"} <= {
        path.name for path in (tmp_path / "twin_0000").iterdir()
    }
    assert width(tmp_path / "twin_fit.png") > 1000
    recipe = rsegen.load(tmp_path / "twin_0000" / "recipe.json")
    assert (recipe.boundary, recipe.friction, recipe.unit_cm) == ("outer", 0.7, 10)
    assert main(["compare", str(tmp_path / "twin_0000"), str(cloud.parent / "wanted.yaml")]) == 1
    assert "too high" in capsys.readouterr().out


@pytest.mark.slow
def test_blocks_longer_than_the_stock_get_no_sheet_unasked(
    cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "inches.xyz", np.loadtxt(cloud) / 0.0254)
    assert main(["scan", str(tmp_path / "inches.xyz"), "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "set the unit of the numbers (--values mm, cm or in)" in said
    assert "no build sheet: stock_cm: 240 cm is too short" in said


@pytest.mark.slow
def test_a_scan_says_which_block_to_change(cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wanted = str(cloud.parent / "wanted.yaml")
    assert main(["compare", str(cloud), wanted, "-o", str(tmp_path / "off.png"), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    field = rsegen.build(RECIPE, 0)
    assert [(each["x"], each["y"], each["cell"]) for each in found["differences"]] == [(3, 4, [4, 5])]
    assert found["differences"][0]["height_m"] == pytest.approx(field.heights[4, 5] + 0.1, abs=0.01)
    assert found["differences"][0]["wanted_m"] == pytest.approx(field.heights[4, 5])
    assert width(tmp_path / "off.png") > 1000
    assert main(["compare", str(cloud), wanted]) == 1
    said = capsys.readouterr().out
    assert "x and y count the blocks of MAP from its south-west corner" in said
    assert "  x 3 y 4: " in said


def test_equal_maps_are_equal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rsegen.save(RECIPE, tmp_path / "a.yaml")
    assert main(["compare", str(tmp_path / "a.yaml"), str(tmp_path / "a.yaml")]) == 0
    assert capsys.readouterr().out == "144 of 144 cells are right\n"


@pytest.mark.slow
def test_a_depth_image_is_enough(tmp_path: Path) -> None:
    """One image of 16 bits, in millimetres, from right above."""
    field = rsegen.build(RECIPE, 0)
    camera = DepthCamera(place=(0.02, 0.01, 2.6), columns=480, rows=360, focal=420)
    away = cast(field, camera).reshape(camera.rows, camera.columns)
    forward = np.subtract(camera.target, camera.place)
    along = camera.directions().reshape(camera.rows, camera.columns, 3) @ (forward / np.linalg.norm(forward))
    depth = np.nan_to_num(away * along * 1000)
    Image.fromarray(np.rint(depth).astype(np.uint16)).save(tmp_path / "depth.png")
    intrinsics = "420,420,239.5,179.5"
    rsegen.save(RECIPE, tmp_path / "wanted.yaml")
    found = rsegen.compare(
        tmp_path / "depth.png", RECIPE, rsegen.ScanOptions(intrinsics=(420, 420, 239.5, 179.5))
    ).comparison
    assert not found.wrong.any()
    assert found.seen.mean() > 0.9
    arguments = ["compare", str(tmp_path / "depth.png"), str(tmp_path / "wanted.yaml"), "--intrinsics", intrinsics]
    assert main(arguments) == (0 if found.seen.all() else 1)


@pytest.mark.slow
@pytest.mark.long(reason="tests/scanning has holes")
def test_holes_are_filled_on_request_and_listed_apart(tmp_path: Path) -> None:
    field = rsegen.build(RECIPE, 0)
    points = scanned(field, EYES, Flaws(), np.random.default_rng(1))
    hole = (np.abs(points[:, :2] - (0.15, 0.25)) < 0.06).all(axis=1)
    left = points[~hole]
    ground = rsegen.scan(left)
    filled = rsegen.scan(left, rsegen.ScanOptions(fill_holes=True))
    assert [each.key for each in filled.recipe.obstacles] == ["heights", "filled-holes"]
    assert (~ground.scan.seen).any()
    assert (ground.field.levels[~ground.scan.seen & ~ground.field.frame] == 0).all()
    assert filled.field.levels.sum() >= ground.field.levels.sum()
