"""Find the files that a robot's file names: relative paths, file://, model:// and package://.

A package is looked for in the folders above the file and next to these, so that a clone of a repository is found as it
is, then in the folders that Gazebo's and ROS's environments list. What breaks it: a package whose folder has another
name than it.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

from rsegen.errors import FileError

_PATHS = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "ROS_PACKAGE_PATH")
"""Variables that list the folders of models and of packages."""

_PREFIXES = "AMENT_PREFIX_PATH"
"""The variable of ROS 2 that lists the folders in whose `share` installed packages are."""

_HIGHEST = 6
"""Folders above a file that are searched: a package holds models/NAME/model.sdf, or less deep."""


def resolve_uris(model: Element, file: Path) -> None:
    """Make the URIs of a model absolute paths where their files are found.

    model://NAME/... and package://NAME/... are looked for in the folders above the file, next to these, and in the
    folders of models that the simulators know; FileError if the mesh of a collision shape is not found.
    """
    for uri in model.iter("uri"):
        path = _resolved((uri.text or "").strip(), file)
        if path:
            uri.text = str(path)
    for mesh in model.iterfind(".//collision/geometry/mesh/uri"):
        text = (mesh.text or "").strip()
        if not text.startswith("/"):
            advice = "put its package next to that of the file, or its folder into GAZEBO_MODEL_PATH"
            raise FileError(f"{file}: the mesh {text} of a collision shape is not found; {advice}")


def found_package(name: str, file: Path) -> Path | None:
    """Return the folder of a package that a file names, None if it is not found."""
    return next((path for path in _of_package(name, file) if _exists(path)), None)


def _resolved(uri: str, file: Path) -> Path | None:
    """Return the path of an existing file that a URI names, None if there is none."""
    scheme, separator, rest = uri.partition("://")
    if not uri or "\0" in uri:
        return None
    if not separator:
        candidates: Iterator[Path] = iter([file.absolute().parent / uri])
    elif scheme == "file":
        candidates = iter([Path("/", rest) if rest.startswith("/") else file.absolute().parent / rest])
    elif scheme in ("model", "package"):
        candidates = _of_package(rest, file)
    else:
        return None
    return next((path for path in candidates if _exists(path)), None)


def _of_package(rest: str, file: Path) -> Iterator[Path]:
    """Yield the paths at which NAME/... may be."""
    name, _, inner = rest.partition("/")
    for folder in list(file.absolute().parents)[:_HIGHEST]:
        if folder.name == name:
            yield folder / inner
        yield folder / rest
    for variable in _PATHS:
        yield from (Path(folder, rest) for folder in _listed(variable))
    yield from (Path(prefix, "share", rest) for prefix in _listed(_PREFIXES))


def _listed(variable: str) -> list[str]:
    return [folder for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # a name that is too long
        return False
