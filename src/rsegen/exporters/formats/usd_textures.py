"""Textures of a USD mesh: UsdPreviewSurface materials that read an image at the primvar `st`."""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.exporters.formats.solid import Solid
from rsegen.exporters.formats.srgb import srgb_to_linear
from rsegen.exporters.formats.textured import textured_groups
from rsegen.exporters.gazebo.obj import texture_name, textured_name
from rsegen.exporters.scene import Scene


def bind_textures(root: Any, scene: Scene, mesh: Any, found: Solid) -> None:
    """Give a mesh prim its texture coordinates, and each subset of its faces a material."""
    from pxr import Sdf, UsdGeom, UsdShade, Vt

    values, index = np.unique(found.coordinates.reshape(-1, 2), axis=0, return_inverse=True)
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(values.astype(np.float32)))
    st.SetIndices(Vt.IntArray.FromNumpy(index.ravel().astype(np.int32)))
    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    for material, part, chosen in textured_groups(found):
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(chosen).astype(np.int32))
        subset = binding.CreateMaterialBindSubset(textured_name(material, part), faces)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(_material(root, scene, material, part))
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _material(root: Any, scene: Scene, material: int, part: str) -> Any:
    """The material of a surface without gloss: an image times the tint of the material."""
    from pxr import Gf, Sdf, UsdGeom, UsdShade

    stage, types = root.GetPrim().GetStage(), Sdf.ValueTypeNames
    looks = root.GetPath().AppendChild("Looks")
    UsdGeom.Scope.Define(stage, looks)
    path = looks.AppendChild(textured_name(material, part))
    found = UsdShade.Material.Define(stage, path)
    reader = _shader(stage, path.AppendChild("st"), "UsdPrimvarReader_float2")
    reader.CreateInput("varname", types.String).Set("st")
    image = _shader(stage, path.AppendChild("image"), "UsdUVTexture")
    image.CreateInput("file", types.Asset).Set(f"./{texture_name(scene, part)}")
    image.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
    for wrap in ("wrapS", "wrapT"):
        image.CreateInput(wrap, types.Token).Set("repeat")
    image.CreateInput("scale", types.Float4).Set(Gf.Vec4f(*srgb_to_linear(scene.tint(material)), 1))
    image.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
    surface = _shader(stage, path.AppendChild("preview"), "UsdPreviewSurface")
    colour = surface.CreateInput("diffuseColor", types.Color3f)
    colour.ConnectToSource(image.CreateOutput("rgb", types.Float3))
    surface.CreateInput("roughness", types.Float).Set(1.0)
    found.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    return found


def _shader(stage: Any, path: Any, kind: str) -> Any:
    from pxr import UsdShade

    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(kind)
    return shader
