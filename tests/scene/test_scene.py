"""Colours of levels and of frames: the recipe's, wherever a map is seen."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

import rsegen
from rsegen import Random, Recipe, Scene, compose
from rsegen.build_sheets.page import block_colour
from rsegen.cli.edge import main
from rsegen.formats.base import FORMATS
from rsegen.gazebo import export
from rsegen.pictures.preview import preview
from rsegen.scene.colours import Colour
from rsegen.scene.scene import FRAME_COLOUR

PLAIN = Recipe(seed=1, chunk_size=4, obstacles=(Random(levels=4),))
PAINTED = replace(PLAIN, frame_colour="#336699", level_colours=("#ff0000", "#00FF33"))
OWN: dict[int, Colour] = {0: (0.2, 0.4, 0.6), 1: (1.0, 0.0, 0.0), 2: (0.0, 1.0, 0.2)}
USUAL: dict[int, Colour] = {0: FRAME_COLOUR, 1: (0.18, 0.45, 0.55), 2: (0.353, 0.683, 0.437), 3: (0.93, 0.85, 0.3)}
GONE = {USUAL[material] for material in OWN}


def made(scene: Scene) -> dict[str, str]:
    return {str(path): b"".join(content).decode() for path, content in export(scene).items()}


def test_levels_beyond_the_list_keep_the_colours_that_they_have_anyway() -> None:
    scene = compose(PAINTED)
    assert {material: scene.colour(material) for material in range(4)} == USUAL | OWN
    assert {material: compose(PLAIN).colour(material) for material in range(4)} == USUAL


def test_gazebo_is_given_them_and_nothing_else_has_changed() -> None:
    painted, plain = (made(compose(recipe)) for recipe in (PAINTED, PLAIN))
    assert {path for path in plain if painted[path] != plain[path]} == {"meshes/rse_0000.mtl", "recipe.json"}
    lines = painted["meshes/rse_0000.mtl"].splitlines()
    assert [line for line in lines if line.startswith("Kd")][:3] == ["Kd 0.2 0.4 0.6", "Kd 1 0 0", "Kd 0 1 0.2"]
    world = made(compose(replace(PAINTED, mesh_type="multi")))["rse_0000.world"]
    for diffuse in ("0.2 0.4 0.6 1", "1 0 0 1", "0 1 0.2 1"):
        assert f"<diffuse>{diffuse}</diffuse>" in world


def test_trimesh_finds_them_in_ply() -> None:
    (content,) = FORMATS["ply"]().files(compose(PAINTED)).values()
    mesh: Any = trimesh.load_mesh(io.BytesIO(b"".join(content)), file_type="ply")
    found = {tuple(colour) for colour in mesh.visual.vertex_colors[:, :3].tolist()}
    assert {(0x33, 0x66, 0x99), (0xFF, 0, 0), (0, 0xFF, 0x33)} < found


def test_pictures_are_in_them_alone() -> None:
    pixels = np.asarray(Image.open(io.BytesIO(preview(compose(PAINTED)))).convert("RGB")) / 255
    for colour in [*OWN.values(), *GONE]:
        share = (np.abs(pixels - colour).max(axis=2) < 0.02).mean()
        assert share > 0.005 if colour in OWN.values() else share < 0.001


def test_the_build_sheet_is_in_them() -> None:
    scene = compose(PAINTED)
    assert block_colour(scene, 1) == OWN[1]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("frame_colour", "red", "--frame-colour: invalid value 'red': expected #rrggbb, in quotes"),
        ("level_colours", "#ffffff,#12345", "--level-colours[1]: invalid value '#12345': expected #rrggbb, in quotes"),
    ],
)
def test_an_invalid_colour_is_refused_in_one_line(
    name: str, text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", f"--{name.replace('_', '-')}", text, "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == f"rsegen: {said}\n"


@pytest.mark.parametrize("suffix", ["json", "yaml"])
def test_a_recipe_file_keeps_them(suffix: str, tmp_path: Path) -> None:
    rsegen.save(PAINTED, tmp_path / f"recipe.{suffix}")
    assert rsegen.load(tmp_path / f"recipe.{suffix}") == PAINTED
    assert not {"frame_colour", "level_colours"} & set(json.loads(made(compose(PLAIN))["recipe.json"]))
