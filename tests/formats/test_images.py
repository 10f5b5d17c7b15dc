"""Images are read back by rsegen import and by Pillow: the same levels, at the same place."""

from __future__ import annotations

import io
import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from rsegen import Matrix, Random, Recipe, Scene, build, compose, imported, load
from rsegen.cli.edge import main
from rsegen.errors import ParameterError
from rsegen.formats.base import Format
from rsegen.formats.heightmap import Heightmap
from rsegen.formats.occupancy import Occupancy
from rsegen.heights.image import OccupancyImage
from tests.formats.maps import SCENES, made

SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
PIXELS = pytest.mark.parametrize("pixels", [1, 3])


def of_levels(levels: list[list[int]], **recipe: float) -> Scene:
    matrix = Matrix.of(np.array(levels))
    size = {"chunk_size": 1, "chunks": matrix.size, "boundary": "none"}
    return compose(replace(Recipe(seed=1, **size, obstacles=(matrix,)), **recipe))  # type: ignore[arg-type]


def put(kind: Format, scene: Scene, folder: Path) -> None:
    for name, content in made(kind, scene).items():
        (folder / name).write_bytes(content)


@SCENE
@PIXELS
def test_every_pixel_of_a_heightmap_is_its_cell_s_height(scene: Scene, pixels: int) -> None:
    files, field = made(Heightmap(pixels=pixels), scene), scene.field
    said = json.loads(files["heightmap.json"])
    with Image.open(io.BytesIO(files[said["image"]])) as image:
        assert image.mode.startswith("I;16")
        grey = np.asarray(image)
    heights = (grey * said["metres_per_grey"])[::-1].T
    expected = field.heights.repeat(pixels, axis=0).repeat(pixels, axis=1)
    assert np.abs(heights - expected).max() <= said["largest_error_m"] + 1e-9
    blocks = ~field.frame.repeat(pixels, axis=0).repeat(pixels, axis=1)
    np.testing.assert_allclose(heights[blocks], expected[blocks], atol=1e-9, rtol=0)
    assert said["largest_error_m"] <= said["metres_per_grey"] / 2
    assert np.array(expected.shape) * said["metres_per_pixel"] == pytest.approx(field.extent)
    assert said["lower_left_corner_m"] == [-side / 2 for side in field.extent]
    assert said["white_m"] == pytest.approx(65535 * said["metres_per_grey"])


@SCENE
@PIXELS
def test_a_heightmap_says_how_it_is_imported_and_so_gives_the_same_map(
    scene: Scene, pixels: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    put(Heightmap(pixels=pixels), scene, tmp_path)
    command = shlex.split(json.loads(Path("heightmap.json").read_text("utf-8"))["import"])
    assert main(command[1:]) == 0
    (folder,) = Path("DIR").iterdir()
    again, field = build(load(folder / "recipe.json")), scene.field
    np.testing.assert_array_equal(again.levels, field.levels)
    np.testing.assert_array_equal(again.frame, field.frame)
    assert (again.unit, again.block_width, again.frame_height) == (field.unit, field.block_width, field.frame_height)
    assert load(folder / "recipe.json").chunks == scene.recipe.chunks or scene.recipe.boundary == "none"


@pytest.mark.parametrize("boundary", ["divided", "outer"])
@pytest.mark.parametrize(("frame_cm", "unit_cm"), [(7, 8.9), (4, 10), (12.34, 3.3), (0, 5)])
def test_frames_of_a_heightmap_keep_their_height(
    boundary: str, frame_cm: float, unit_cm: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    recipe = Recipe(seed=2, boundary=boundary, frame_height_cm=frame_cm, unit_cm=unit_cm, chunk_size=4, chunks=(3, 2))
    scene = compose(replace(recipe, obstacles=[Random(levels=4)]))
    put(Heightmap(pixels=2), scene, tmp_path)
    assert main(shlex.split(json.loads(Path("heightmap.json").read_text("utf-8"))["import"])[1:]) == 0
    again = load(Path("DIR") / "rse_0000_0000" / "recipe.json")
    assert (again.boundary, again.frame_height_cm, again.chunk_size, again.chunks) == (boundary, frame_cm, 4, (3, 2))
    np.testing.assert_array_equal(build(again).heights, scene.field.heights)


@pytest.mark.parametrize(
    ("framed", "says"),
    [
        ("9x10", "--framed: 9x10 blocks with frames are 11 x 12 cells, which do not divide 24 x 12"),
        ("6x10", "--framed: 6x10: chunks are squares; use the blocks of one, as in 10x10"),
    ],
)
def test_frames_that_an_image_cannot_have_are_refused(
    framed: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put(Heightmap(), compose(Recipe(seed=2, chunks=(2, 1), obstacles=[Random(levels=4)])), tmp_path)
    image = str(next(tmp_path.glob("*.png")))
    assert main(["import", image, "--framed", framed, "-o", str(tmp_path / "out")]) == 2
    assert f"rsegen: {says}" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("top", [1, 4, 255, 256, 1000, 21845])
def test_levels_are_exact_for_any_number_of_levels(top: int, tmp_path: Path) -> None:
    scene = of_levels([[0, top], [top // 2, top - 1]])
    put(Heightmap(), scene, tmp_path)
    command = shlex.split(json.loads((tmp_path / "heightmap.json").read_text("utf-8"))["import"])
    words = [str(tmp_path / command[2]), *command[3:-1], str(tmp_path / "out")]
    assert main(["import", *words]) == 0
    (folder,) = (tmp_path / "out").iterdir()
    np.testing.assert_array_equal(build(load(folder / "recipe.json")).levels, scene.field.levels)


def test_frames_too_high_for_16_bits_are_refused() -> None:
    scene = compose(Recipe(seed=1, unit_cm=0.001, frame_height_cm=100))
    with pytest.raises(
        ParameterError, match=r"frame_height_cm: frames of 100 cm are higher than 65535 units of 0\.001"
    ):
        Heightmap().files(scene)


@SCENE
@PIXELS
def test_cells_above_the_climb_are_occupied_at_their_place(scene: Scene, pixels: int, tmp_path: Path) -> None:
    put(Occupancy(pixels=pixels), scene, tmp_path)
    field, said = scene.field, yaml.safe_load((tmp_path / "map.yaml").read_text("utf-8"))
    recipe = imported(tmp_path / said["image"].replace("pgm", "yaml"), OccupancyImage())
    walls = build(recipe).levels > 0
    expected = (field.heights > field.unit).repeat(pixels, axis=0).repeat(pixels, axis=1)
    np.testing.assert_array_equal(walls, expected)
    assert said["resolution"] == pytest.approx(field.block_width / pixels, abs=1e-9)
    assert said["origin"] == [-field.extent[0] / 2, -field.extent[1] / 2, 0]
    with Image.open(tmp_path / "map.pgm") as image:
        assert set(np.unique(np.asarray(image)).tolist()) <= {0, 254}


@pytest.mark.parametrize(("climb_cm", "free"), [(0, 1), (10, 2), (15, 2), (20, 3), (30, 4)])
def test_a_step_as_high_as_the_climb_is_free(climb_cm: float, free: int, tmp_path: Path) -> None:
    put(Occupancy(climb_cm=climb_cm), of_levels([[0, 1, 2, 3]]), tmp_path)
    assert list((tmp_path / "map.pgm").read_bytes()[-4:][::-1]) == [254] * free + [0] * (4 - free)


@pytest.mark.parametrize(("margin_cm", "cells"), [(0, 0), (1, 1), (10, 1), (25, 3)])
def test_a_margin_is_free_ground_of_whole_cells_around_the_map(margin_cm: float, cells: int, tmp_path: Path) -> None:
    scene = of_levels([[2, 0, 2], [0, 2, 2]])
    put(Occupancy(), scene, tmp_path)
    map_alone = np.asarray(Image.open(tmp_path / "map.pgm"))
    said = yaml.safe_load((tmp_path / "map.yaml").read_text())
    put(Occupancy(margin_cm=margin_cm), scene, tmp_path)
    assert (np.asarray(Image.open(tmp_path / "map.pgm")) == np.pad(map_alone, cells, constant_values=254)).all()
    corner = [*(side - cells * scene.field.block_width for side in said["origin"][:2]), 0]
    assert yaml.safe_load((tmp_path / "map.yaml").read_text())["origin"] == pytest.approx(corner, abs=1e-9)


def test_a_margin_of_whole_cells_is_not_a_cell_wider_by_rounding() -> None:
    scene = compose(Recipe(seed=1, chunk_size=2, boundary="none", block_width_cm=15))
    assert 105 / 100 / 0.15 > 7
    assert made(Occupancy(margin_cm=105), scene)["map.pgm"].startswith(b"P5\n16 16\n")


def test_a_margin_that_makes_a_huge_image_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"margin_cm: 100000 cm .* 20002 x 20003 pixels; use less"):
        made(Occupancy(margin_cm=100_000), of_levels([[2, 0, 2], [0, 2, 2]]))


def test_both_commands_take_options(tmp_path: Path) -> None:
    (tmp_path / "recipe.yaml").write_text("seed: 1\nchunk_size: 2\n")
    recipe, formats = str(tmp_path / "recipe.yaml"), "heightmap pixels=4, occupancy pixels=4 climb_cm=20"
    assert main(["export", recipe, "--to", formats, "-o", str(tmp_path / "a")]) == 0
    assert main(["generate", recipe, "--formats", formats, "-o", str(tmp_path / "b")]) == 0
    for folder in (tmp_path / "a", tmp_path / "b"):
        said = json.loads((folder / "rse_0000" / "formats.json").read_text("utf-8"))
        assert said == {"heightmap": {"pixels": 4}, "occupancy": {"climb_cm": 20, "margin_cm": 0, "pixels": 4}}
