"""Parts of several formats rebuild the field, whatever it is."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import trimesh
from hypothesis import given
from PIL import Image

from rsegen import Scene, StepField, compose
from rsegen.formats.glb import Glb
from rsegen.formats.mjcf import Mjcf
from rsegen.formats.parts import groups
from rsegen.formats.usd import Usd
from rsegen.gazebo.obj import PARTS
from rsegen.geometry import TILES, surface
from rsegen.geometry.box_merging import columns
from rsegen.scene.looks.looks import textures
from tests.formats.maps import RECIPES, made
from tests.formats.test_meshes import seen_from_above
from tests.support.strategies import fields


@given(field=fields())
def test_columns_are_the_heights_and_the_materials_and_do_not_overlap(field: StepField) -> None:
    (x, y), heights = field.edges(), np.zeros(field.shape)
    materials = np.zeros(field.shape, dtype=int)
    for column in columns(field):
        low, high = (np.array(column.centre) + side * np.array(column.size) / 2 for side in (-1, 1))
        assert abs(low[2]) < 1e-12
        middle_x, middle_y = (x[:-1] + x[1:]) / 2, (y[:-1] + y[1:]) / 2
        inside = np.outer((low[0] < middle_x) & (middle_x < high[0]), (low[1] < middle_y) & (middle_y < high[1]))
        assert not heights[inside].any()
        heights[inside], materials[inside] = high[2], column.material
    np.testing.assert_allclose(heights, field.heights, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(materials, field.levels)


@pytest.mark.slow
@given(field=fields())
def test_parts_of_one_colour_are_together_the_surface(field: StepField) -> None:
    from trimesh import Trimesh
    from trimesh.util import concatenate

    mesh = surface(field)
    parts = [(material, mesh.part(chosen)) for material, _, chosen in groups(mesh.materials)]
    assert [material for material, _ in parts] == sorted({material for material, _ in parts})
    for material, part in parts:
        assert set(part.materials) == {material}
        assert np.array_equal(np.unique(part.faces), np.arange(len(part.places)))
    meshes = [Trimesh(part.vertices, part.triangles, process=False) for _, part in parts]
    whole = concatenate(meshes) if meshes else Trimesh()
    np.testing.assert_allclose(seen_from_above(whole, field), field.heights, rtol=0, atol=1e-12)
    assert sum(len(part.faces) for _, part in parts) == len(surface(field).faces)


class Part(NamedTuple):
    """A part of a surface: corners (m, 3, 3), their texture coordinates (m, 3, 2), and its image."""

    corners: np.ndarray
    coordinates: np.ndarray
    image: np.ndarray


def pixels(image: Any) -> np.ndarray:
    return np.asarray((image if isinstance(image, Image.Image) else Image.open(image)).convert("RGB"))


def parts_of_glb(scene: Scene, folder: Path) -> dict[str, Part]:
    (content,) = made(Glb(), scene).values()
    loaded: Any = trimesh.load(io.BytesIO(content), file_type="glb", process=False)
    upright = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    return {
        name: Part(
            (mesh.vertices @ upright)[mesh.faces],
            mesh.visual.uv[mesh.faces],
            pixels(mesh.visual.material.baseColorTexture),
        )
        for name, mesh in loaded.geometry.items()
    }


def parts_of_usd(scene: Scene, folder: Path) -> dict[str, Part]:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    from pxr import Usd as Library
    from pxr import UsdGeom, UsdShade

    for path, content in made(Usd(binary=False), scene).items():
        (folder / path).write_bytes(content)
    stage, parts = Library.Stage.Open(str(folder / f"{scene.name}.usda")), {}
    for mesh in (UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)):
        corners = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())].reshape(
            -1, 3, 3
        )
        known = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened()).reshape(-1, 3, 2)
        binding = UsdShade.MaterialBindingAPI(mesh.GetPrim())
        assert UsdGeom.Subset.ValidateFamily(mesh, UsdGeom.Tokens.face, "materialBind")[0]
        for subset in binding.GetMaterialBindSubsets():
            faces = np.array(subset.GetIndicesAttr().Get())
            material = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
            shader = UsdShade.Shader(stage.GetPrimAtPath(material.GetPath().AppendChild("image")))
            image = pixels(folder / shader.GetInput("file").Get().path)
            parts[subset.GetPrim().GetName()] = Part(corners[faces], known[faces], image)
    return parts


def parts_of_mjcf(scene: Scene, folder: Path) -> dict[str, Part]:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    for path, content in made(Mjcf(shape="mesh"), scene).items():
        (folder / path).write_bytes(content)
    model = mujoco.MjModel.from_xml_path(str(folder / f"{scene.name}.xml"))
    data, parts = mujoco.MjData(model), {}
    mujoco.mj_forward(model, data)
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).tolist():
        mesh, own = model.geom_dataid[geom], model.mat(model.geom_matid[geom])
        first, coordinates = model.mesh_vertadr[mesh], model.mesh_texcoordadr[mesh]
        faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
        places = model.mesh_vert[first:] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        texture = model.tex(own.texid[mujoco.mjtTextureRole.mjTEXROLE_RGB])
        parts[model.mesh(mesh).name.removeprefix(f"{scene.name}_")] = Part(
            places[model.mesh_face[faces]],
            model.mesh_texcoord[coordinates:][model.mesh_facetexcoord[faces]],
            pixels(folder / f"{texture.name}.png"),
        )
    return parts


@pytest.mark.parametrize("read", [parts_of_glb, parts_of_usd, parts_of_mjcf], ids=["glb", "usd", "mjcf"])
def test_tops_and_sides_have_their_own_textures_a_tile_per_block(
    read: Callable[[Scene, Path], dict[str, Part]], tmp_path: Path
) -> None:
    scene = compose(replace(RECIPES["one frame of another height"], look="wood"))
    field, parts = scene.field, read(scene, tmp_path)
    images = dict(zip(PARTS, map(pixels, map(io.BytesIO, textures("wood", scene.recipe.seed or 0))), strict=True))
    area_of_tops = dict.fromkeys(parts, 0.0)
    for name, (corners, coordinates, image) in parts.items():
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        upward = normals[:, 2] / np.linalg.norm(normals, axis=1)
        assert "frame" in name or ((np.abs(upward) > 0.5) == name.endswith("top")).all()
        area_of_tops[name] = normals[upward > 0.5, 2].sum()
        np.testing.assert_array_equal(image, images[name.rpartition("_")[2]])
        edges = [np.linalg.norm(values - np.roll(values, 1, axis=1), axis=2) for values in (corners, coordinates)]
        np.testing.assert_allclose(edges[1] * TILES * field.block_width, edges[0], atol=1e-5)
    cells = {f"level_{level}_top": count for level, count in field.level_counts().items() if level}
    cells["frame_side"] = int(field.frame.sum())  # boards show long grain all over
    found = {name: area / field.block_width**2 for name, area in area_of_tops.items() if area}
    assert found == pytest.approx(cells, rel=1e-4)
