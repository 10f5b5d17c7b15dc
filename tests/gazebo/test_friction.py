"""Friction of levels and of frames: a shape that is touched has that of all its blocks; what is seen stays as it is."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen import Scene, compose
from rsegen.cli.edge import main
from rsegen.field.stepfield import StepField
from rsegen.gazebo import MESH_TYPES, export
from rsegen.gazebo.map_summary import costs, warnings
from rsegen.recipe.codec import decode
from tests.real.maps import Shape
from tests.support.strategies import fields, recipes

MESHES: tuple[Shape, ...] = (
    {},
    {"mesh": "watertight"},
    {"mesh": "blocks"},
    {"tile": 3},
    {"simulator": "classic"},
    {"mesh_type": "pallet"},
    {"mesh_type": "pallet", "mesh": "watertight"},
)
BOXES: tuple[Shape, ...] = (
    {"collision": "boxes"},
    {"collision": "blocks"},
    {"collision": "boxes", "tile": 3},
    {"mesh_type": "pallet", "collision": "boxes"},
    {"mesh_type": "multi"},
)
COEFFICIENTS = st.sampled_from([0.05, 0.3, 1.0])
LEVELS = {"kind": "matrix", "levels": 4, "rows": ["1 2 0", "3 1 2"]}
SMALL = {"chunk_size": 3, "chunks": 1, "seed": 1, "obstacles": [LEVELS]}

Face = tuple[tuple[float, ...], ...]
"""Its corners in turn, metres."""


@st.composite
def gripping(draw: st.DrawFn, shapes: tuple[Shape, ...]) -> Scene:
    """A map in one of some shapes whose levels and frames have frictions of their own."""
    shape = draw(st.sampled_from(shapes))
    return compose(
        replace(
            draw(recipes()),
            **{"mesh_type": "single", **shape},
            friction=0.7,
            frame_friction=draw(st.none() | COEFFICIENTS),
            level_friction=draw(st.none() | st.lists(COEFFICIENTS, min_size=1, max_size=5).map(tuple)),
        )
    )


def scene_of(**entries: object) -> Scene:
    return compose(decode({**SMALL, **entries}))


def files_of(scene: Scene) -> dict[str, bytes]:
    return {str(path): b"".join(content) for path, content in export(scene).items()}


def models(files: Mapping[str, bytes], scene: Scene) -> Iterator[ET.Element]:
    """All but the ground, whose friction is the map's."""
    for model in ET.fromstring(files[f"{scene.name}.world"]).iter("model"):  # our own file
        if model.get("name") != "ground_plane":
            yield model
        else:
            assert [mu(each) for each in model.iter("collision")] == [scene.friction]


def mu(collision: ET.Element) -> float:
    one, other = (float(collision.findtext(f"surface/friction/ode/{name}") or "nan") for name in ("mu", "mu2"))
    assert one == other
    return one


def uris(model: ET.Element, what: str) -> list[str]:
    return [uri.text or "" for uri in model.findall(f"link/{what}/geometry/mesh/uri")]


def faces(obj: bytes) -> Iterator[tuple[int, Face]]:
    """Every face of an OBJ file with its material."""
    corners, material = [], -1
    for line in obj.decode().splitlines():
        word, *rest = line.split()
        if word == "v":
            corners.append(tuple(map(float, rest)))
        elif word == "usemtl":
            material = int(rest[0].removeprefix("level_").replace("frame", "0"))
        elif word == "f":
            yield material, tuple(corners[int(corner.partition("/")[0]) - 1] for corner in rest)


@pytest.mark.slow
@settings(max_examples=12)
@given(gripping(MESHES))
def test_meshes_that_are_touched_are_together_the_faces_that_are_seen_each_of_one_friction(scene: Scene) -> None:
    files = files_of(scene)
    for model in models(files, scene):
        seen = Counter(face for uri in uris(model, "visual") for face in faces(files[uri]))
        touched: Counter[tuple[int, Face]] = Counter()
        for collision in model.iter("collision"):
            found = list(faces(files[collision.findtext("geometry/mesh/uri") or ""]))
            assert found
            assert {round(scene.friction_of(material), 9) for material, _ in found} == {mu(collision)}
            touched.update(found)
        assert touched == seen


@pytest.mark.slow
@settings(max_examples=12)
@given(gripping(MESHES))
def test_only_frictions_and_collisions_differ_from_a_map_of_one_friction(scene: Scene) -> None:
    plain = compose(replace(scene.recipe, frame_friction=None, level_friction=None), scene.index)
    own, other = files_of(scene), files_of(plain)
    assert {path for path in own if "/touched/" not in path} == set(other)
    assert all(own[path] == other[path] for path in other if path.startswith("meshes/"))
    told, usual = costs(scene), costs(plain)
    assert (told.faces, told.models) == (usual.faces, usual.models)
    shapes = [len(model.findall("link/collision")) for model in models(own, scene)]
    assert sum(shapes) == told.collisions == MESH_TYPES[scene.recipe.mesh_type].counts(scene)[1]
    used = {uri for model in models(own, scene) for uri in uris(model, "collision") + uris(model, "visual")}
    assert used == {path for path in own if path.endswith(".obj")}


@pytest.mark.slow
@given(gripping(BOXES))
def test_boxes_rebuild_the_map_each_of_one_friction(scene: Scene) -> None:
    field = scene.field
    (x, y), frictions = field.edges(), grips(scene)
    middle_x, middle_y = (x[:-1] + x[1:]) / 2, (y[:-1] + y[1:]) / 2
    heights = np.zeros(field.shape)
    for model in models(files_of(scene), scene):
        place = numbers(model.findtext("pose"))[:3]
        for collision in model.iter("collision"):
            size = numbers(collision.findtext("geometry/box/size"))
            centre = place + numbers(collision.findtext("pose") or "0 0 0")[:3]
            inside = [abs(middle - centre[axis]) < size[axis] / 2 for axis, middle in enumerate((middle_x, middle_y))]
            cells = np.outer(*inside)
            heights[cells] += size[2]
            assert set(frictions[cells]) == {mu(collision)}
    np.testing.assert_allclose(heights, field.heights, atol=1e-8)


def grips(scene: Scene) -> np.ndarray:
    """Friction of each cell by the recipe."""
    recipe, field = scene.recipe, scene.field
    known = [recipe.friction, *(recipe.level_friction or ())]
    of_level = np.array([known[level] if level < len(known) else recipe.friction for level in range(40)])
    framed = recipe.friction if recipe.frame_friction is None else recipe.frame_friction
    return np.where(field.frame, framed, of_level[field.levels])


def numbers(text: str | None) -> np.ndarray:
    return np.array((text or "").split(), dtype=float)


@given(field=fields())
def test_surfaces_by_material_are_the_whole_field(field: StepField) -> None:
    materials = field.materials()
    parts = [field.only([material]) for material in materials]
    assert bool(materials) == field.is_raised()
    assert all(part.materials() == [material] for part, material in zip(parts, materials, strict=True))
    np.testing.assert_array_equal(sum((part.heights for part in parts), np.zeros(field.shape)), field.heights)
    assert field.only(materials).heights.tolist() == field.heights.tolist()


def test_levels_beyond_the_list_and_frames_that_are_not_told_have_the_friction_of_the_map() -> None:
    scene = scene_of(friction=0.6, level_friction=[0.1, 0.2])
    assert [scene.friction_of(material) for material in range(5)] == [0.6, 0.1, 0.2, 0.6, 0.6]
    assert scene_of(friction=0.6, frame_friction=0).friction_of(0) == 0


@pytest.mark.parametrize("entries", [{"level_friction": [0.3] * 3, "frame_friction": 0.3}, {"friction": 0.3}])
def test_with_one_friction_the_collision_is_the_visual_mesh(entries: dict[str, object]) -> None:
    scene = scene_of(**entries)
    files = files_of(scene)
    (model,) = models(files, scene)
    assert uris(model, "collision") == uris(model, "visual") == [f"meshes/{scene.name}.obj"]
    assert [mu(collision) for collision in model.iter("collision")] == [0.3]
    assert not [path for path in files if "touched" in path]


def test_coefficients_that_are_written_alike_are_one() -> None:
    scene = scene_of(friction=1, level_friction=[0.3, 0.3 + 1e-12])
    assert scene.by_friction(scene.field) == [(0.3, [1, 2]), (1.0, [0, 3])]


def test_a_file_of_a_map_that_gives_none_says_nothing_of_them() -> None:
    assert not {"frame_friction", "level_friction"} & set(json.loads(files_of(scene_of())["recipe.json"]))
    said = json.loads(files_of(scene_of(level_friction=0.5, frame_friction=1))["recipe.json"])
    assert (said["level_friction"], said["frame_friction"]) == ([0.5], 1)


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--frame-friction", "-0.1"], "--frame-friction: -0.1 is outside 0..1000"),
        (["--level-friction", "0.1,rough"], "--level-friction[1]: 'rough' is not a number; expected 0..1000"),
    ],
)
def test_a_friction_that_cannot_be_is_one_line(
    flags: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", *flags, "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == f"rsegen: {said}\n"
    assert not (tmp_path / "out").exists()


def test_a_map_of_a_data_set_has_the_frictions_of_its_recipe(tmp_path: Path) -> None:
    flags = ["--level-friction", "0.9,0.1", "--frame-friction", "0.2", "--seed", "1", "--chunk-size", "4"]
    obstacle = ["--obstacle", "random levels=3"]
    assert main(["dataset", *obstacle, *flags, "--maps", "5", "-o", str(tmp_path / "set")]) == 0
    assert main(["generate", f"{tmp_path / 'set'}#3", "-o", str(tmp_path / "worlds")]) == 0
    assert main(["generate", *obstacle, *flags, "--first-map", "3", "-o", str(tmp_path / "plain")]) == 0
    world = "rse_0003/rse_0003.world"
    text = (tmp_path / "worlds" / world).read_text()
    assert text == (tmp_path / "plain" / world).read_text()
    assert [f"<mu>{friction}</mu>" in text for friction in ("1", "0.9", "0.1", "0.2")] == [True] * 4


@pytest.mark.parametrize(
    ("changes", "is_told"),
    [
        ({}, False),
        ({"friction": 0.5}, True),
        ({"level_friction": (0.5,)}, True),
        ({"level_friction": (1.0,)}, False),
        ({"friction": 0.5, "collision": "boxes"}, False),
        ({"friction": 0.5, "mesh_type": "multi"}, False),
        ({"friction": 0.5, "mesh_type": "pallet"}, True),
        ({"friction": 0.5, "simulator": "classic"}, False),
    ],
)
def test_friction_that_gazebo_sim_ignores_is_warned_of(changes: dict[str, Any], is_told: bool) -> None:
    scene = compose(decode({**SMALL, **changes}))
    assert any("ignores the friction" in text for text in warnings(scene)) == is_told
