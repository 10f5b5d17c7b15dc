"""Compile a file of MJCF by MuJoCo itself: a file from anybody, and perhaps without all of its meshes.

So classes of defaults, included files, units and orders of angles, folders of meshes, and masses of shapes are as in
MuJoCo. What a robot does not need is left out first: textures, and visual meshes that are not there. Cost: MuJoCo's,
most of it for the hulls of meshes. What breaks it: what MuJoCo's own reader refuses, whose message has the line.
"""

from __future__ import annotations

import os
import re
from math import isnan
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError, shown
from rsegen.field.stepfield import Array
from rsegen.geometry.mesh_files import Triangles, binary_faces
from rsegen.geometry.poses import pose_matrix
from rsegen.input_files import open_regular, refuse_pointer, silent_libraries, text_of, xml_root
from rsegen.robots.files.meshes import MANY_FACES, SUFFIXES, inline_uri, refuse_large

_MAX_MIB = 4
"""The largest included file that is read, MiB."""

_MOST_FILES, _MOST_COPIES = 100, 10_000
"""Files that are included at most, and copies that <replicate> makes of its content; robots have some ten of both."""

_MUJOCO_READS = ".xml"
"""Ending of the files that MuJoCo reads; any other one is read for it, and given under a name with this ending."""

_SIDES_DIFFER = 1e-9
"""Share by which the scales of a mesh along its axes may differ and count as equal."""


_REFUSED = re.compile(r"XML Error: (?:Schema violation: )?(.*?)\s*Element '(.*)', line (\d+)\s*", re.DOTALL)
_UNKNOWN = re.compile(r"unrecognized (?:element|attribute: '(.*)')")
"""MuJoCo's message about an element, whose line is 0 if it is in an included file; and what it says of unknown ones."""


class Compiled(NamedTuple):
    """A compiled model (MjModel), its name, and what else is needed of its meshes.

    meshes: the URI of each mesh, and its pose in the frame of the compiled one, (4, 4); missing: files of meshes that
    are only seen, and not there
    """

    model: Any
    name: str
    meshes: list[tuple[str, Array]]
    missing: tuple[str, ...]


def compiled(root: Element, where: str) -> Compiled:
    """Return the model of a file whose XML is `root`; FileError for what MuJoCo does not read."""
    folder = Path(where).absolute().parent
    _refuse_traps(root, where, folder)
    try:
        import mujoco
        from mujoco import MjSpec  # noqa: F401  # of a MuJoCo that is not whole there may be an empty package
    except (ImportError, OSError):
        how = "pip install 'mujoco-core>=4'"
        raise FileError(f"{where}: MJCF is read by MuJoCo, which is not installed; {how}") from None
    try:
        with silent_libraries():
            spec = _spec(os.fspath(Path(where).absolute()))
            missing = _take_out_unneeded(spec, folder, where)
            for mesh in filter(lambda mesh: mesh.file, spec.meshes):
                _refuse_mesh(folder / (spec.meshdir or "") / mesh.file, mesh.content_type)
            spec.memory = -1  # what a file asks for may not be there
            model = _compiled_without_hulls(spec)
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise FileError(f"{where}: {_refusal(str(error))}") from None
    name = spec.modelname if spec.modelname not in ("", "MuJoCo Model") else Path(where).stem
    names = [model.mesh(mesh).name for mesh in range(model.nmesh)]
    meshes = [_uri_and_pose(model, mesh, spec.mesh(name), folder) for mesh, name in enumerate(names)]
    return Compiled(model, name, meshes, missing)


def _refusal(message: str) -> str:
    """Return where and why MuJoCo refuses a file, and what helps if the file is for another version of MuJoCo."""
    import mujoco

    reader, refused = f"MuJoCo {mujoco.mj_versionString()}", _REFUSED.fullmatch(message)
    if not refused:
        problem = ", ".join(line.strip() for line in message.splitlines() if line.strip())
        return f"{reader} does not read it: {problem}"
    problem, element, line = refused.groups()
    place = f"line {line}: <{element}>" if line != "0" else f"<{element}> in a file that it includes"
    if unknown := _UNKNOWN.fullmatch(problem):
        part = f"its attribute {shown(unknown[1])}" if unknown[1] else "this element in this place"
        advice = "delete it if the file is for an older version; update MuJoCo if it is for a newer one"
        return f"{place}: {reader} does not know {part}; {advice}"
    return f"{place}: {reader} does not read it: {problem}"


def _refuse_mesh(path: Path, content_type: str) -> None:
    """Raise a FileError for a mesh that MuJoCo does not read, or for which it takes long."""
    refuse_pointer(path)
    if not (content_type or path.suffix).lower().endswith("stl"):
        refuse_large(path, os.path.getsize(path), "simplify it")
        return
    with open_regular(path) as file:
        faces = binary_faces(file)
    if faces is None:
        raise FileError(f"{path}: of STL files MuJoCo reads binary ones alone; write it as such a file, or as OBJ")
    if faces > MANY_FACES:
        raise FileError(
            f"{path}: {faces:,} faces; of an STL file MuJoCo reads up to {MANY_FACES:,}; simplify it, or "
            "write it as OBJ"
        )


def _compiled_without_hulls(spec: Any) -> Any:
    """Return the compiled model: MuJoCo makes hulls of meshes that touch, which take most of its time, for nothing."""
    if spec.compiler.discardvisual:  # it would take out what does not touch
        return spec.compile()
    # So nothing touches while it compiles, and what touches is put back into the compiled model.
    touching = [(geom, geom.contype, geom.conaffinity) for geom in spec.geoms]
    for geom, _, _ in touching:
        geom.contype = geom.conaffinity = 0
    model = spec.compile()
    for geom, kind, affinity in touching:
        model.geom_contype[geom.id], model.geom_conaffinity[geom.id] = kind, affinity
    return model


def _spec(path: str) -> Any:
    """Return a file as MuJoCo reads it, which it does under a name that ends in .xml alone."""
    import mujoco

    if path.endswith(_MUJOCO_READS):
        return mujoco.MjSpec.from_file(path)
    with open_regular(path) as file:
        named = path + _MUJOCO_READS
        return mujoco.MjSpec.from_file(named, include={named: file.read()})


def _refuse_traps(root: Element, where: str, folder: Path) -> None:
    """Raise a FileError for included files that are not there, or more copies than memory may hold."""
    seen: set[Path] = set()
    waiting = [(root, where)]
    while waiting:
        element, file = waiting.pop()
        _refuse_copies(element, 1, file)
        for include in element.iter("include"):
            path = folder / (include.get("file") or "")
            if path not in seen:
                seen.add(path)
                if len(seen) > _MOST_FILES:
                    raise FileError(f"{where}: includes more than {_MOST_FILES} files")
                if not path.exists():
                    raise FileError(f"{file}: includes {path}, and there is no such file")
                waiting.append((xml_root(text_of(path, _MAX_MIB, "a part of a robot"), str(path)), str(path)))


def _refuse_copies(element: Element, copies: int, where: str) -> None:
    """Raise a FileError for <replicate>, one in another, that makes very many copies."""
    if element.tag == "replicate":
        text = element.get("count", "").strip()
        copies *= int(text) if text.isdecimal() and len(text) < 9 else _MOST_COPIES + 1
        if copies > _MOST_COPIES:
            raise FileError(
                f"{where}: <replicate> makes more than {_MOST_COPIES} copies, with a count of {shown(text)}"
            )
    for child in element:
        _refuse_copies(child, copies, where)


def _take_out_unneeded(spec: Any, folder: Path, where: str) -> tuple[str, ...]:
    """Take textures out, and shapes that are only seen and whose meshes are not there; return the files of these.

    FileError if a mesh is missing that touches, or of which a mass is computed.
    """
    # Textures and lights are for pictures that nobody makes of this model, and their files may be missing.
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for unneeded in [*spec.textures, *spec.lights]:
        spec.delete(unneeded)
    directory = folder / (spec.meshdir or "")
    missing = {
        mesh.name: Path(mesh.file).name
        for mesh in spec.meshes
        if mesh.file and not os.path.isfile(directory / mesh.file)
    }
    for geom in list(spec.geoms):
        if geom.meshname not in missing:
            continue
        # NaN: the file gives no mass, so the density counts.
        weightless = geom.parent.explicitinertial or geom.mass == 0 or (isnan(geom.mass) and geom.density == 0)
        if geom.contype or geom.conaffinity or not weightless:
            why = "of a collision shape" if geom.contype or geom.conaffinity else "that gives a body its mass"
            raise FileError(f"{where}: the mesh {missing[geom.meshname]} {why} is not found in {directory}")
        spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name in missing:
            spec.delete(mesh)
    return tuple(missing.values())


def _uri_and_pose(model: Any, mesh: int, source: Any, folder: Path) -> tuple[str, Array]:
    """Return the URI of a mesh, and its pose, scaled as it then is, in the frame of the compiled mesh, (4, 4).

    MuJoCo subtracts `refpos`, turns by the inverse of `refquat`, scales, and moves the result to its centre and axes. A
    mesh without a file that others read, or turned and scaled unequally, stands in the model.
    """
    # `turn` is the inverse of refquat. SDF scales first and then turns, which gives another mesh if scales are unequal.
    start = int(model.mesh_pathadr[mesh])
    file = folder / model.paths[start:].split(b"\0", 1)[0].decode("utf-8", "replace") if start >= 0 else folder
    turn, scale = turn_of(source.refquat).T, np.array(source.scale)
    is_even = np.allclose(turn, np.eye(3)) or np.ptp(scale) <= _SIDES_DIFFER * np.abs(scale).max()
    centred = pose_matrix(model.mesh_pos[mesh], turn_of(model.mesh_quat[mesh]))
    back = np.asarray(np.linalg.inv(centred), dtype=np.float64)
    if file.suffix.lower() in SUFFIXES and is_even:
        return str(file), back @ pose_matrix(-scale * (turn @ np.array(source.refpos)), turn)
    points, corners = (
        values[first : first + count]
        for values, first, count in (
            (model.mesh_vert.astype(np.float64), int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])),
            (model.mesh_face, int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])),
        )
    )
    return inline_uri(Triangles(points @ centred[:3, :3].T + centred[:3, 3], corners)), back


def turn_of(quaternion: Any) -> Array:
    """Return the rotation, (3, 3), of a quaternion w x y z, which need not be of length 1."""
    import mujoco

    unit, turn = np.array(quaternion, dtype=float), np.zeros(9)
    mujoco.mju_normalize4(unit)
    mujoco.mju_quat2Mat(turn, unit)
    return turn.reshape(3, 3)
