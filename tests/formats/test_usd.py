"""Pixar's own library judges the USD: it opens, its validators find nothing, its triangles are at the heights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from rsegen import Recipe, Scene, compose
from rsegen.formats.parts import srgb_to_linear
from rsegen.formats.usd import Usd
from tests.formats.maps import RECIPES, SCENES, made
from tests.formats.test_meshes import seen_from_above
from tests.real.maps import slippery

pxr = pytest.importorskip("pxr", reason="usd-core is not installed")

SLIPPERY = {scene.recipe.name: scene for scene in map(compose, slippery())}
STANDING = {name: scene for name, scene in SCENES.items() if scene.field.is_raised()}
STAND = pytest.mark.parametrize("scene", STANDING.values(), ids=list(STANDING))
SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
BINARY = pytest.mark.parametrize("binary", [False, True], ids=["usda", "usdc"])


def opened(scene: Scene, folder: Path, *, binary: bool = False) -> Any:
    from pxr import Usd as Library

    ((path, content),) = made(Usd(binary=binary), scene).items()
    assert path == f"{scene.name}.{'usdc' if binary else 'usda'}"
    (folder / path).write_bytes(content)
    return Library.Stage.Open(str(folder / path))


def surface(stage: Any) -> Any:
    """The one mesh of a stage."""
    from pxr import UsdGeom

    (found,) = (prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    return UsdGeom.Mesh(found)


def triangles(mesh: Any) -> Any:
    """It as trimesh has it, in its own single precision."""
    assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    return trimesh.Trimesh(np.array(mesh.GetPointsAttr().Get()), faces, process=False)


def test_images_are_looked_up_at_the_texture_coordinates_of_the_mesh(tmp_path: Path) -> None:
    from pxr import UsdGeom, UsdShade

    scene = compose(replace(RECIPES["one frame of another height"], look="wood"))
    files = made(Usd(binary=False), scene)
    for path, content in files.items():
        (tmp_path / path).write_bytes(content)
    stage = pxr.Usd.Stage.Open(str(tmp_path / f"{scene.name}.usda"))
    shaders = [UsdShade.Shader(prim) for prim in stage.Traverse() if prim.IsA(UsdShade.Shader)]
    images = [shader for shader in shaders if shader.GetShaderId() == "UsdUVTexture"]
    assert images
    for image in images:
        assert image.GetInput("file").Get().path.removeprefix("./") in files
        (source,), _ = image.GetInput("st").GetConnectedSources()
        reader = UsdShade.Shader(source.source.GetPrim())
        assert reader.GetShaderId() == "UsdPrimvarReader_float2"
        assert UsdGeom.PrimvarsAPI(surface(stage)).GetPrimvar(reader.GetInput("varname").Get()).HasValue()
    known = {"UsdPreviewSurface", "UsdUVTexture", "UsdPrimvarReader_float2"}
    assert {shader.GetShaderId() for shader in shaders} == known


@BINARY
@STAND
def test_a_ray_from_above_meets_every_cell_at_its_height(binary: bool, scene: Scene, tmp_path: Path) -> None:
    stage, field = opened(scene, tmp_path, binary=binary), scene.field
    found = triangles(surface(stage))
    seen = seen_from_above(found, field)
    np.testing.assert_array_equal(seen.astype(np.float32), field.heights.astype(np.float32))
    assert found.is_watertight
    assert found.volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-5)
    np.testing.assert_array_equal(surface(stage).GetExtentAttr().Get(), found.bounds)  # by which viewers find it


@BINARY
@SCENE
def test_usd_s_own_validators_find_nothing(binary: bool, scene: Scene, tmp_path: Path) -> None:
    from pxr import UsdValidation

    registry = UsdValidation.ValidationRegistry()
    known = registry.GetOrLoadAllValidators()
    assert len(known) > 20
    errors = UsdValidation.ValidationContext(known).Validate(opened(scene, tmp_path, binary=binary))
    assert [error.GetMessage() for error in errors] == []


@BINARY
@SCENE
def test_the_map_is_the_default_prim_in_metres_with_z_up(binary: bool, scene: Scene, tmp_path: Path) -> None:
    from pxr import UsdGeom

    stage = opened(scene, tmp_path, binary=binary)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetDefaultPrim().GetPath() == f"/{scene.name}"
    assert [prim.GetName() for prim in stage.GetPseudoRoot().GetChildren()] == [scene.name]


@STAND
def test_physics_takes_it_for_static_triangles_with_the_map_s_friction(scene: Scene, tmp_path: Path) -> None:
    from pxr import UsdPhysics, UsdShade

    stage = opened(compose(replace(scene.recipe, friction=0.35)), tmp_path)
    prim = surface(stage).GetPrim()
    assert prim.HasAPI(UsdPhysics.CollisionAPI)
    assert UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() == "none"
    assert not any(each.HasAPI(UsdPhysics.RigidBodyAPI) for each in stage.Traverse())
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    physics = UsdPhysics.MaterialAPI(material.GetPrim())
    for friction in (physics.GetStaticFrictionAttr(), physics.GetDynamicFrictionAttr()):
        assert friction.Get() == pytest.approx(0.35)


@pytest.mark.parametrize("name", ["slippery-default", "slippery-high"])
def test_each_friction_has_a_mesh_of_its_own(name: str, tmp_path: Path) -> None:
    """As engines read one per mesh; together they are the whole surface."""
    from pxr import UsdGeom, UsdPhysics, UsdShade, UsdValidation

    scene = SLIPPERY[name]
    stage = opened(scene, tmp_path)
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    found, frictions, area = {}, [], 0.0
    for mesh in meshes:
        prim = mesh.GetPrim()
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
        physics = UsdPhysics.MaterialAPI(material.GetPrim())
        frictions.append(physics.GetDynamicFrictionAttr().Get())
        assert physics.GetStaticFrictionAttr().Get() == frictions[-1]
        assert prim.HasAPI(UsdPhysics.MeshCollisionAPI)
        for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            found[subset.GetPrim().GetName()] = frictions[-1]
        area += triangles(mesh).area
    assert len(set(frictions)) == len(meshes) > 1
    own = {"frame": 0, "level_1": 1, "level_2": 2}
    assert found == pytest.approx({name: scene.friction_of(kind) for name, kind in own.items()})
    (tmp_path / "whole").mkdir()
    whole = opened(compose(replace(scene.recipe, frame_friction=None, level_friction=None)), tmp_path / "whole")
    assert area == pytest.approx(triangles(surface(whole)).area, rel=1e-5)
    known = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not UsdValidation.ValidationContext(known).Validate(stage)


@STAND
def test_every_level_and_the_frame_have_faces_of_their_colour(scene: Scene, tmp_path: Path) -> None:
    """Those that look up are the area of the cells of the level."""
    from pxr import UsdShade

    stage, field = opened(scene, tmp_path), scene.field
    mesh = surface(stage)
    shown, area = np.array(mesh.GetDisplayColorAttr().Get()), triangles(mesh).area_faces
    upward = np.array(mesh.GetNormalsAttr().Get())[:, 2] > 0.5
    found = {}
    for subset in UsdShade.MaterialBindingAPI(mesh.GetPrim()).GetMaterialBindSubsets():
        faces = np.array(subset.GetIndicesAttr().Get())
        material, _ = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()
        name = subset.GetPrim().GetName()
        assert material.GetPrim().GetName() == name
        colour = srgb_to_linear(scene.colour(int(name.removeprefix("level_") if name != "frame" else 0)))
        shader = material.ComputeSurfaceSource()[0]
        np.testing.assert_allclose(shader.GetInput("diffuseColor").Get(), colour, rtol=1e-6)
        assert shader.GetInput("roughness").Get() == 1  # of 0..1, without gloss
        np.testing.assert_allclose(shown[faces], np.tile(colour, (len(faces), 1)), rtol=1e-6)
        found[name] = area[faces][upward[faces]].sum() / field.block_width**2
    cells = {f"level_{level}": count for level, count in field.level_counts().items() if level}
    if field.frame.any() and field.frame_height:
        cells["frame"] = int(field.frame.sum())
    assert found == pytest.approx(cells, rel=1e-5)


def test_normals_match_the_triangles(tmp_path: Path) -> None:
    stage = opened(SCENES["blocks that touch along an edge"], tmp_path)
    mesh = surface(stage)
    np.testing.assert_allclose(mesh.GetNormalsAttr().Get(), triangles(mesh).face_normals, atol=1e-6)


@BINARY
@pytest.mark.parametrize(("name", "prim"), [("2026-11.pallet", "_2026_11_pallet_0000"), ("blocks", "blocks_0000")])
def test_a_map_of_any_name_is_a_prim(binary: bool, name: str, prim: str, tmp_path: Path) -> None:
    scene = compose(Recipe(name=name, seed=1, chunk_size=2))
    stage = opened(scene, tmp_path, binary=binary)
    assert stage.GetDefaultPrim().GetPath() == f"/{prim}"
    assert surface(stage)


def test_a_binary_file_is_the_same_bytes_each_time_and_smaller(tmp_path: Path) -> None:
    scene = SCENES["one frame of another height"]
    ((_, once),), ((_, again),) = (made(Usd(binary=True), scene).items() for _ in range(2))
    ((_, text),) = made(Usd(binary=False), scene).items()
    assert once == again
    assert len(once) < len(text)


def test_it_is_taken_into_another_stage_by_reference_alone(tmp_path: Path) -> None:
    from pxr import Usd as Library

    scene = SCENES["frames round every chunk"]
    opened(scene, tmp_path)
    stage = Library.Stage.CreateNew(str(tmp_path / "world.usda"))
    stage.DefinePrim("/World/terrain").GetReferences().AddReference(f"{scene.name}.usda")
    found = triangles(surface(stage))
    seen = seen_from_above(found, scene.field)
    np.testing.assert_array_equal(seen.astype(np.float32), scene.field.heights.astype(np.float32))
