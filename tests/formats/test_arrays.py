"""Arrays are read back by numpy and by scipy, as the field that they are of."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from rsegen import Scene, imported
from rsegen.formats.arrays import Arrays
from rsegen.heights.table import Table
from rsegen.recipe.codec import decode
from tests.formats.maps import SCENES, made

SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))


def loaded(content: bytes) -> np.ndarray:
    found: np.ndarray = np.load(io.BytesIO(content), allow_pickle=False)
    return found


@SCENE
def test_numpy_reads_levels_heights_and_frame(scene: Scene) -> None:
    files, field = made(Arrays(), scene), scene.field
    for name, expected in (("levels", field.levels), ("heights", field.heights), ("frame", field.frame)):
        found = loaded(files[f"{name}.npy"])
        np.testing.assert_array_equal(found, expected, strict=True)


@SCENE
def test_matlab_s_file_says_the_same(scene: Scene) -> None:
    found, field = loadmat(io.BytesIO(made(Arrays(), scene)["levels.mat"])), scene.field
    np.testing.assert_array_equal(found["levels"], field.levels)
    np.testing.assert_array_equal(found["heights"], field.heights)
    np.testing.assert_array_equal(found["frame"].astype(bool), field.frame)
    lengths = [found[name].item() for name in ("unit", "block_width", "frame_height")]
    assert lengths == [field.unit, field.block_width, field.frame_height]
    assert found["seed"].item() == scene.recipe.seed
    assert found["__header__"].rstrip() == b"MATLAB 5.0 MAT-file, written by rsegen"


@SCENE
def test_the_table_is_north_up_and_can_be_imported(scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "levels.csv").write_bytes(made(Arrays(), scene)["levels.csv"])
    rows = np.loadtxt(tmp_path / "levels.csv", delimiter=",", dtype=int, ndmin=2)
    np.testing.assert_array_equal(rows[::-1].T, scene.field.blocks)
    assert imported(tmp_path / "levels.csv", Table()).unit_cm == scene.recipe.unit_cm


@SCENE
def test_the_meaning_has_lengths_axes_seed_version_and_the_recipe(scene: Scene) -> None:
    said = json.loads(made(Arrays(), scene)["meta.json"])
    assert said["cells"] == list(scene.field.shape)
    lengths = (said["unit_m"], said["block_width_m"], said["frame_height_m"])
    assert lengths == (scene.field.unit, scene.field.block_width, scene.field.frame_height)
    assert (said["seed"], said["generator"].partition(" ")[0]) == (scene.recipe.seed, "rsegen")
    assert "axis 0 along +x" in said["axes"]
    assert decode(said["recipe"]) == scene.alone
    assert {*said["files"], "meta.json"} == set(made(Arrays(), scene))
