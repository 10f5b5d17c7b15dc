"""Textures of blocks: the same pixels for the same seed, and enough in them for a camera."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen.gazebo.bundle import export
from rsegen.geometry import TILES
from rsegen.scene.looks.looks import mean_colour, textures
from tests.formats.maps import RECIPES

LOOKS = ("levels", "wood", "friction")


def pixels(image: bytes) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(image)).convert("RGB")).astype(int)


@pytest.mark.parametrize("look", LOOKS)
def test_a_seed_gives_its_textures_again_and_another_one_others(look: str) -> None:
    first = textures(look, 1)
    textures.cache_clear()
    assert textures(look, 1) == first
    assert all(one != other for one, other in zip(textures(look, 2), first, strict=True))


@pytest.mark.parametrize("look", LOOKS)
def test_images_have_a_tile_per_block_and_all_tiles_differ(look: str) -> None:
    top, side = map(pixels, textures(look, 3))
    width = top.shape[1] // TILES
    assert top.shape == side.shape == (TILES * width, TILES * width, 3)
    tiles = top.reshape(TILES, width, TILES, width, 3).transpose(0, 2, 1, 3, 4).reshape(TILES * TILES, -1)
    assert len(np.unique(tiles, axis=0)) > (50 if look == "wood" else 5)
    posts = side.reshape(TILES * width, TILES, width, 3).transpose(1, 0, 2, 3).reshape(TILES, -1)
    assert len(np.unique(posts, axis=0)) > TILES / 2


@pytest.mark.parametrize("look", LOOKS)
def test_blocks_have_dark_edges(look: str) -> None:
    top, side = map(pixels, textures(look, 4))
    width = top.shape[1] // TILES
    for image in (top, side, top.transpose(1, 0, 2)):
        edges = image[:, ::width].mean()
        assert edges < 0.5 * image[width // 4 :, width // 2 :: width].mean()
    assert side[0].mean() < 0.6 * side[width // 2].mean()


@pytest.mark.parametrize("look", LOOKS)
def test_the_colour_from_afar_is_that_of_the_pixels(look: str) -> None:
    top, side = map(pixels, textures(look, 5))
    seen = np.concatenate([top.reshape(-1, 3), side.reshape(-1, 3)]).mean(axis=0) / 255
    assert np.abs(seen - mean_colour(look)).max() < 0.12


@pytest.mark.parametrize("mesh_type", ["single", "multi", "pallet"])
@pytest.mark.parametrize("name", RECIPES)
def test_textured_worlds_name_files_that_they_have(name: str, mesh_type: str) -> None:
    recipe = replace(RECIPES[name], look="wood", mesh_type=mesh_type)
    files = {str(path): b"".join(content) for path, content in export(rsegen.compose(recipe)).items()}
    for path, content in files.items():
        if path.endswith(".obj"):
            assert f"mtllib {rsegen.compose(recipe).name}.mtl".encode() in content
    for path in (path for path in files if path.endswith(".mtl")):
        named = {line.split()[1].decode() for line in files[path].splitlines() if line.startswith(b"map_Kd")}
        assert named == {found.removeprefix("meshes/") for found in files if found.endswith(".png")}
        assert len(named) == 2
    world = next(content for path, content in files.items() if path.endswith(".world")).decode()
    uris = {part.partition("<")[0] for part in world.split("<uri>")[1:]}
    assert uris <= set(files)
    assert not rsegen.compose(recipe).field.is_raised() or uris


@pytest.mark.parametrize("name", ["frames round every chunk", "one frame of another height"])
def test_textures_cost_no_face_and_at_most_a_third_more_bytes(name: str) -> None:
    """Of the mesh; the images are the same however large a map is."""
    recipe = replace(RECIPES[name], chunk_size=20)
    plain, wood = (
        b"".join(next(content for path, content in export(rsegen.compose(made)).items() if path.suffix == ".obj"))
        for made in (recipe, replace(recipe, look="wood"))
    )
    assert plain.count(b"\nf ") == wood.count(b"\nf ")
    assert len(wood) <= 4 / 3 * len(plain)


def test_an_obj_reader_finds_the_surface_and_its_tiles() -> None:
    """trimesh's: the same area per material as without textures, and coordinates inside the images' repetitions."""
    import trimesh

    recipe = replace(RECIPES["frames round every chunk"], look="wood")
    scene = rsegen.compose(recipe)
    found = {str(path): b"".join(content) for path, content in export(scene).items()}
    images = {path.removeprefix("meshes/"): content for path, content in found.items() if path.startswith("meshes/")}
    text = next(content for path, content in images.items() if path.endswith(".obj"))
    resolver = trimesh.resolvers.ZipResolver({name: BytesIO(content) for name, content in images.items()})
    loaded: Any = trimesh.load(BytesIO(text), file_type="obj", resolver=resolver, process=False)
    mesh = rsegen.mesh(scene.field)
    expected = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    parts = loaded.geometry.values()
    assert np.isclose(sum(part.area for part in parts), expected.area)
    assert all(part.visual.uv is not None and part.visual.material.image is not None for part in parts)


def test_colours_that_are_given_stain_the_wood() -> None:
    recipe = replace(
        RECIPES["frames round every chunk"], look="wood", frame_colour="#ff0000", level_colours=("#00ff00",)
    )
    scene = rsegen.compose(recipe)
    assert scene.tint(0) == (1, 0, 0)
    assert scene.tint(1) == (0, 1, 0)
    assert scene.surface_colour(1)[0] == 0
    assert scene.tint(2) != scene.colour(2)


def test_the_look_friction_shows_equal_coefficients_alike() -> None:
    recipe = replace(RECIPES["frames round every chunk"], look="friction", level_friction=(0.2, 1.0, 0.2))
    scene = rsegen.compose(recipe)
    assert scene.tint(1) == scene.tint(3) != scene.tint(2) == scene.tint(0)
    assert sum(scene.tint(1)) > sum(scene.tint(2))


@pytest.mark.parametrize("mesh_type", ["single", "multi", "pallet"])
def test_the_solver_of_contacts_is_in_the_world_if_it_is_another_than_gazebo_s(mesh_type: str) -> None:
    recipe = replace(RECIPES["frames round every chunk"], mesh_type=mesh_type)
    usual, other = (
        b"".join(next(content for path, content in export(rsegen.compose(made)).items() if path.suffix == ".world"))
        for made in (recipe, replace(recipe, solver="pgs"))
    )
    physics = ElementTree.fromstring(other).find("world/physics")
    assert physics is not None
    assert physics.findtext("dart/solver/solver_type") == "pgs"
    assert usual == other.replace(b"\n      <dart><solver><solver_type>pgs</solver_type></solver></dart>", b"")
    assert usual != other


def test_shadows_and_sky_are_in_the_world_on_request() -> None:
    recipe = RECIPES["frames round every chunk"]
    plain, lit = (
        b"".join(next(content for path, content in export(rsegen.compose(made)).items() if path.suffix == ".world"))
        for made in (recipe, replace(recipe, shadows=True, sky=True))
    )
    assert b"<shadows>false</shadows>" in plain
    assert b"<sky>" not in plain
    assert lit.count(b"shadows>true</") == 2
    assert b"<sky></sky>" in lit
