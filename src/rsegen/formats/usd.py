"""The format `usd`: the map as a mesh with a material per colour, and a static triangle mesh collider.

Engines such as Newton read one friction per mesh, so a map of several has a mesh prim for each part of its surface.
Textured looks are UsdPreviewSurface materials that read an image at the primvar `st`, bound to subsets of faces.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.formats import USD
from rsegen.formats.base import Format, Step, register
from rsegen.formats.parts import groups, srgb_to_linear
from rsegen.formats.solid import Solid, solid
from rsegen.gazebo.obj import material_name, texture_files, texture_name
from rsegen.params.extras import Extra
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Flag
from rsegen.scene.scene import Scene


def _bind(root: Any, scene: Scene, mesh: Any, surface: Solid) -> None:
    """Give each subset of the faces of a mesh prim its material, and with textures the prim its coordinates."""
    from pxr import Sdf, UsdGeom, UsdShade, Vt

    textured = scene.recipe.is_textured
    if textured:
        values, index = np.unique(surface.coordinates.reshape(-1, 2), axis=0, return_inverse=True)
        kind = Sdf.ValueTypeNames.TexCoord2fArray
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, UsdGeom.Tokens.faceVarying)
        st.Set(Vt.Vec2fArray.FromNumpy(values.astype(np.float32)))
        st.SetIndices(Vt.IntArray.FromNumpy(index.ravel().astype(np.int32)))
    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    for material, part, chosen in groups(surface.materials, surface.sides if textured else None):
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(chosen).astype(np.int32))
        subset = binding.CreateMaterialBindSubset(material_name(material, part), faces)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(_material(root, scene, material, part))
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _material(root: Any, scene: Scene, material: int, part: str) -> Any:
    """Return a material without gloss: the tint of a surface, times the image of its texture if it is textured."""
    from pxr import Gf, Sdf, UsdShade

    types, (stage, path) = Sdf.ValueTypeNames, _stage_and_path(root, material_name(material, part))
    result, tint = UsdShade.Material.Define(stage, path), srgb_to_linear(scene.tint(material))
    # Three shaders in a row: texture coordinates -> image -> surface.
    if part:
        reader = _shader(stage, path.AppendChild("st"), "UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set("st")
        image = _shader(stage, path.AppendChild("image"), "UsdUVTexture")
        image.CreateInput("file", types.Asset).Set(f"./{texture_name(scene, part)}")
        image.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
        for wrap in ("wrapS", "wrapT"):
            image.CreateInput(wrap, types.Token).Set("repeat")
        image.CreateInput("scale", types.Float4).Set(Gf.Vec4f(*tint, 1))
        image.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
    surface = _shader(stage, path.AppendChild("preview"), "UsdPreviewSurface")
    colour = surface.CreateInput("diffuseColor", types.Color3f)
    if part:
        colour.ConnectToSource(image.CreateOutput("rgb", types.Float3))
    else:
        colour.Set(Gf.Vec3f(*tint))
    surface.CreateInput("roughness", types.Float).Set(1.0)
    result.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    return result


def _shader(stage: Any, path: Any, kind: str) -> Any:
    from pxr import UsdShade

    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(kind)
    return shader


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Usd(Format):
    """A watertight mesh with colours, friction and a static collider (USD) for Isaac Sim and usdview, metres, z up."""

    name: ClassVar[str] = "usd"
    also: ClassVar[tuple[str, ...]] = ("usda", "isaac", "isaacsim", "omniverse")
    extra: ClassVar[Extra | None] = USD
    step: ClassVar[Step] = "mesh"

    binary: Annotated[
        bool,
        Flag(help="binary file (.usdc), which opens faster than text (.usda) and depends on the version of usd-core"),
    ] = True

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return a USD file, and the images of its textures if the recipe's look has any."""
        images = texture_files(scene) if scene.field.is_raised() else {}
        return {f"{scene.name}.usd{'c' if self.binary else 'a'}": _layer(scene, binary=self.binary), **images}


def prim_name(name: str) -> str:
    """Return the name of a map as a USD prim name: letters, digits and _, no digit first."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{plain}" if plain[0].isdigit() else plain


def _layer(scene: Scene, *, binary: bool) -> Iterator[bytes]:
    """Yield the bytes of a layer; of a binary one by way of a temporary file, the only target that pxr supports."""
    stage = _stage(scene)  # which keeps its layer alive
    if not binary:
        yield stage.GetRootLayer().ExportToString().encode()
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "map.usdc"
        stage.GetRootLayer().Export(str(path))
        content = path.read_bytes()
    yield content


def _stage(scene: Scene) -> Any:
    """Return the stage with the map as default prim, an Xform of its name, and without a physics scene."""
    from pxr import Kind, Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().documentation = "made by rsegen; the middle of the map is at the origin, the ground at z = 0"
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, f"/{prim_name(scene.name)}")
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    surface = solid(scene.field, textured=scene.recipe.is_textured)
    # Each friction coefficient with its part of the surface; most often there is only one.
    frictions = [
        (friction, surface if materials is None else surface.part(np.isin(surface.materials, materials)))
        for friction, materials in scene.by_friction(scene.field)
    ]
    for index, (friction, part) in enumerate(pair for pair in frictions if len(pair[1].triangles)):
        own = f"friction_{decimal(friction).replace('.', '_')}" if index else "friction"
        mesh = _mesh(root, scene, part, f"surface_{own}" if index else "surface")
        _bind(root, scene, mesh, part)
        _add_physics(root, mesh, friction, own)
    return stage


def _mesh(root: Any, scene: Scene, surface: Solid, name: str) -> Any:
    """Return a mesh prim: triangles with a colour and a normal each, in single precision, as in USD."""
    from pxr import UsdGeom, Vt

    # Everything that viewers need even if they know no materials: points, faces, normals, a colour per face.
    mesh = UsdGeom.Mesh.Define(root.GetPrim().GetStage(), root.GetPath().AppendChild(name))
    points = Vt.Vec3fArray.FromNumpy(surface.vertices.astype(np.float32))
    mesh.CreatePointsAttr(points)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(surface.triangles), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(surface.triangles.astype(np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    first, second, third = (surface.vertices[surface.triangles[:, corner]] for corner in range(3))
    normals = np.sign(np.round(np.cross(second - first, third - first), 15)) + 0.0  # along an axis
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.uniform)
    colours = np.array(
        [srgb_to_linear(scene.surface_colour(level)) for level in range(int(surface.materials.max()) + 1)],
        dtype=np.float32,
    )
    shown = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform)
    shown.Set(Vt.Vec3fArray.FromNumpy(colours[surface.materials]))
    return mesh


def _stage_and_path(root: Any, name: str) -> tuple[Any, Any]:
    """Return the stage, and the path of a material of a name in the scope of materials."""
    from pxr import UsdGeom

    stage, looks = root.GetPrim().GetStage(), root.GetPath().AppendChild("Looks")
    UsdGeom.Scope.Define(stage, looks)
    return stage, looks.AppendChild(name)


def _add_physics(root: Any, mesh: Any, friction: float, name: str) -> None:
    """Add a triangle mesh collider without a rigid body, and a physics material of its friction."""
    from pxr import UsdPhysics, UsdShade

    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(UsdPhysics.Tokens.none)
    binding = UsdShade.MaterialBindingAPI(mesh.GetPrim())
    material = UsdShade.Material.Define(*_stage_and_path(root, name))
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(friction)
    physics.CreateDynamicFrictionAttr(friction)
    binding.Bind(material, materialPurpose="physics")
