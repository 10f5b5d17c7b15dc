"""The format `usd`: the map as one mesh with a material per colour, and a static triangle mesh collider."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.exporters.formats.base import Extra, Format, register
from rsegen.exporters.formats.solid import Solid, solid
from rsegen.exporters.formats.srgb import srgb_to_linear
from rsegen.exporters.gazebo.obj import material_name
from rsegen.exporters.scene import Colour, Scene
from rsegen.field.stepfield import Array
from rsegen.params.sorts import Flag


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Usd(Format):
    """A watertight mesh with colours, friction and a static collider (USD) for Isaac Sim and usdview, metres, z up."""

    name: ClassVar[str] = "usd"
    extra: ClassVar[Extra | None] = Extra("usd", "pxr")

    binary: Annotated[bool, Flag(help="binary file (.usdc) instead of text (.usda)")] = False

    @property
    def bytes_a_cell(self) -> int:
        """The memory of a watertight mesh and of its text."""
        return 4000

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """One USD file."""
        if self.binary:
            return {f"{scene.name}.usdc": _binary(scene)}
        return {f"{scene.name}.usda": _text(scene)}


def prim_name(name: str) -> str:
    """The name of a map as a USD prim name: letters, digits and _, no digit first."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{plain}" if plain[0].isdigit() else plain


def _text(scene: Scene) -> Iterator[bytes]:
    stage = _stage(scene)  # which keeps its layer alive
    yield stage.GetRootLayer().ExportToString().encode()


def _binary(scene: Scene) -> Iterator[bytes]:
    """The bytes of a binary layer, by way of a temporary file, the only target that pxr supports."""
    stage = _stage(scene)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "map.usdc"
        stage.GetRootLayer().Export(str(path))
        content = path.read_bytes()
    yield content


def _stage(scene: Scene) -> Any:
    """The stage with the map as default prim, an Xform of its name, and without a physics scene."""
    from pxr import Kind, Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().documentation = "made by rsegen; the middle of the map is at the origin, the ground at z = 0"
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, f"/{prim_name(scene.name)}")
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    found = solid(scene.field)
    if len(found.triangles):
        mesh = _mesh(root, scene, found)
        _bind_colours(root, scene, mesh, found)
        _add_physics(root, scene, mesh, found)
    return stage


def _mesh(root: Any, scene: Scene, found: Solid) -> Any:
    """The mesh prim: triangles with a colour and a normal each, in single precision, as in USD."""
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(root.GetPrim().GetStage(), root.GetPath().AppendChild("surface"))
    points = Vt.Vec3fArray.FromNumpy(found.vertices.astype(np.float32))
    mesh.CreatePointsAttr(points)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(found.triangles), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(found.triangles.astype(np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(_normals(found).astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.uniform)
    colours = np.array(
        [srgb_to_linear(scene.colour(kind)) for kind in range(int(found.materials.max()) + 1)], dtype=np.float32
    )
    shown = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform)
    shown.Set(Vt.Vec3fArray.FromNumpy(colours[found.materials]))
    return mesh


def _normals(found: Solid) -> Array:
    """The normal of each triangle, (m, 3), along an axis."""
    first, second, third = (found.vertices[found.triangles[:, corner]] for corner in range(3))
    return np.sign(np.round(np.cross(second - first, third - first), 15)) + 0.0


def _bind_colours(root: Any, scene: Scene, mesh: Any, found: Solid) -> None:
    """Bind a subset of the faces to each material."""
    from pxr import UsdGeom, UsdShade, Vt

    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    for kind in np.unique(found.materials).tolist():
        faces = np.flatnonzero(found.materials == kind).astype(np.int32)
        subset = binding.CreateMaterialBindSubset(material_name(kind), Vt.IntArray.FromNumpy(faces))
        material = _material(root, material_name(kind), srgb_to_linear(scene.colour(kind)))
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _material(root: Any, name: str, colour: Colour) -> Any:
    """The material of a matte surface of one colour."""
    from pxr import Gf, Sdf, UsdShade

    stage, path = _looks(root), root.GetPath().AppendChild("Looks").AppendChild(name)
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path.AppendChild("preview"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*colour))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def _looks(root: Any) -> Any:
    """The stage, after defining the scope of materials in it."""
    from pxr import UsdGeom

    stage = root.GetPrim().GetStage()
    UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Looks"))
    return stage


def _add_physics(root: Any, scene: Scene, mesh: Any, found: Solid) -> None:
    """Add a triangle mesh collider without a rigid body, and the friction of each part."""
    from pxr import UsdPhysics, UsdShade

    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(UsdPhysics.Tokens.none)
    binding = UsdShade.MaterialBindingAPI(mesh.GetPrim())
    frictions = [scene.friction_of(kind) for kind in np.unique(found.materials).tolist()]
    whole = scene.friction if len(set(frictions)) > 1 else frictions[0]
    binding.Bind(_friction_material(root, "friction", whole), materialPurpose="physics")
    for subset, friction in zip(binding.GetMaterialBindSubsets(), frictions, strict=True):
        if friction != whole:
            material = _friction_material(root, f"friction_{subset.GetPrim().GetName()}", friction)
            UsdShade.MaterialBindingAPI(subset.GetPrim()).Bind(material, materialPurpose="physics")


def _friction_material(root: Any, name: str, friction: float) -> Any:
    """A physics material with a friction coefficient."""
    from pxr import UsdPhysics, UsdShade

    material = UsdShade.Material.Define(_looks(root), root.GetPath().AppendChild("Looks").AppendChild(name))
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(friction)
    physics.CreateDynamicFrictionAttr(friction)
    return material
