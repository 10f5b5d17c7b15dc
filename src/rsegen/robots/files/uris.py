"""Find the files that a robot's file names: relative paths, file://, model:// and package://.

A package is looked for in the folders above the file and next to these, so that a clone of a repository is found as it
is, then in the folders that Gazebo's and ROS's environments list, then by the <name> in package.xml, as a clone may
have another name than the package in it: of the package that holds the file, and of those around it. Cost: a look into
at most _MOST_FOLDERS folders. What breaks it: a workspace with more folders than that.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain, islice
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

from rsegen.errors import FileError
from rsegen.input_files import regular_content
from rsegen.robots.files.meshes import INLINE

_PATHS = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "ROS_PACKAGE_PATH")
"""Variables that list the folders of models and of packages."""

_PREFIXES = "AMENT_PREFIX_PATH"
"""The variable of ROS 2 that lists the folders in whose `share` installed packages are."""

_HIGHEST = 6
"""Folders above a file that are searched: a package holds models/NAME/model.sdf, or less deep."""


_MANIFEST = "package.xml"
_LARGEST_MANIFEST = 2**16
"""Bytes of package.xml that are read; it has some hundreds, and the name of its package comes first."""

_AROUND = 2
"""Folders above a package in which others are looked for: its repository, and the workspace of repositories."""

_DEEPER = 2
"""Folders between a workspace and a package in a repository next to that of the file: repository/common/package."""

_MOST_FOLDERS = 1000
"""Folders that are looked into for packages; a workspace has some hundreds, a home folder any number."""


def resolve_uris(model: Element, file: Path) -> None:
    """Make the URIs of a model absolute paths where their files are found.

    model://NAME/... and package://NAME/... are looked for in the folders above the file, next to these, and in the
    folders of models that the simulators know; FileError if the mesh of a collision shape is not found.
    """
    for uri in model.iter("uri"):
        text = (uri.text or "").strip()
        path = None if text.startswith(INLINE) else found_uri(text, file)
        if path:
            uri.text = str(path)
    for mesh in model.iterfind(".//collision/geometry/mesh/uri"):
        text = (mesh.text or "").strip()
        if not text.startswith(INLINE) and not (text.startswith("/") and os.path.exists(text)):
            raise FileError(f"{file}: the mesh {text} of a collision shape is not found; {_advice(text, file)}")


def _advice(uri: str, file: Path) -> str:
    """Return how a URI that is not found can be found: by the file, or by its package."""
    scheme, separator, path = uri.partition("://")
    if separator and scheme in ("model", "package"):
        name, _, inner = path.lstrip("/").partition("/")
        folder = found_package(name, file)
        if folder is None:
            return "put its package next to that of the file, or its folder into GAZEBO_MODEL_PATH"
        return f"there is no {inner} in {folder}"
    if scheme in ("http", "https"):
        return "rsegen fetches nothing itself; download it, and write its path there"
    return "there is no such file"


def found_package(name: str, file: Path) -> Path | None:
    """Return the folder of a package that a file names, None if it is not found.

    One with a package.xml comes first: in a package there often is a folder of its name, with its Python.
    """
    folders = (folder for folder in _of_package(name, file) if os.path.isdir(folder))
    first = next(folders, None)
    if first is None or os.path.isfile(first / _MANIFEST):
        return first
    return next((folder for folder in folders if os.path.isfile(folder / _MANIFEST)), first)


def installed(path: Path) -> Path:
    """Return a path in a package, or the one that is installed there: CMake leaves out the folder above many folders.

    So PACKAGE/description/urdf of a clone is PACKAGE/urdf where it is installed, and this is what files say.
    """
    package = None if os.path.exists(path) else next((f for f in path.parents if os.path.isfile(f / _MANIFEST)), None)
    if package is None:
        return path
    inner, folders = path.relative_to(package), []
    with suppress(OSError), os.scandir(package) as entries:
        folders = sorted(entry.path for entry in islice(entries, _MOST_FOLDERS) if entry.is_dir())
    return next((place for folder in folders if os.path.exists(place := Path(folder, inner))), path)


class Manifest(NamedTuple):
    """Content of the package.xml of a folder: the name of the package, and of those that it depends on."""

    name: str
    needs: frozenset[str]


def manifest_of(package: Path) -> Manifest:
    """Return what the package.xml of a folder says, an empty name if it says none."""
    text = (regular_content(package / _MANIFEST, _LARGEST_MANIFEST) or b"").decode("utf-8", "replace")
    name = re.search(r"<name>\s*([^<\s]+)\s*</name>", text)
    return Manifest(name[1] if name else "", frozenset(re.findall(r"<(?:\w+_)?depend\b[^>]*>\s*([^<\s]+)\s*<", text)))


def belong_together(package: Path, other: Path) -> bool:
    """Return whether two packages belong to one robot.

    They are in one clone of a repository, one depends on the other, or their names begin alike, as those of
    rover_description and rover_control do.
    """
    ours, theirs = manifest_of(package), manifest_of(other)
    if package == other or theirs.name in ours.needs or ours.name in theirs.needs:
        return True
    first, second = (name.rpartition("_")[0] or name for name in (ours.name or package.name, theirs.name or other.name))
    if first == second or first.startswith(f"{second}_") or second.startswith(f"{first}_"):
        return True
    repositories = [
        next((f for f in p.parents if os.path.exists(f / ".git")), None) for p in (package / "_", other / "_")
    ]
    return repositories[0] is not None and repositories[0] == repositories[1]


def packages_around(file: Path) -> Iterator[Path]:
    """Yield the folders of the packages around a file, its own first: each has a package.xml.

    Those are its own package, those next to it, and those in the repositories next to it, up to two folders down.
    """
    own = next((folder for folder in file.absolute().parents if os.path.isfile(folder / _MANIFEST)), None)
    if own is None:
        return
    yield own
    # Breadth first, three levels deep, and a limited number of folders: what is around may be a whole home directory.
    seen, waiting, left = {own}, [(own, 0), *((folder, 0) for folder in list(own.parents)[:_AROUND])], _MOST_FOLDERS
    while waiting:
        folder, depth = waiting.pop(0)
        inside: list[Path] = []
        with suppress(OSError), os.scandir(folder) as entries:
            names = sorted(entry.name for entry in islice(entries, _MOST_FOLDERS) if entry.is_dir())
            inside = [folder / name for name in names if not name.startswith(".")][:left]
        for inner in inside:
            left -= 1
            if inner in seen:
                continue
            seen.add(inner)
            if os.path.isfile(inner / _MANIFEST):
                yield inner
            elif depth < _DEEPER:
                waiting.append((inner, depth + 1))


def found_uri(uri: str, file: Path) -> Path | None:
    """Return the path of the file that a URI names, None if no such file is found."""
    scheme, separator, path = uri.partition("://")
    candidates: Iterable[Path] = ()
    if separator and scheme in ("model", "package"):
        candidates = _of_package(path.lstrip("/"), file)
    elif uri and separator and scheme == "file":
        candidates = [file.absolute().parent / path]
    elif uri and not separator:  # next to the file, or in a model, as PX4's include each other
        candidates = chain([file.absolute().parent / uri], _of_package(uri, file))
    return next(filter(os.path.exists, candidates), None)  # False for a name that is too long


def _of_package(path: str, file: Path) -> Iterator[Path]:
    """Yield the places at which NAME/... may be, in the order of the module's docstring."""
    name, _, inner = path.partition("/")
    for folder in list(file.absolute().parents)[:_HIGHEST]:
        if folder.name == name:
            yield folder / inner
        yield folder / path
    for variable in _PATHS:
        yield from (Path(folder, path) for folder in _listed(variable))
    yield from (Path(prefix, "share", path) for prefix in _listed(_PREFIXES))
    for folder in packages_around(file):
        if manifest_of(folder).name == name:
            yield installed(folder / inner)


def _listed(variable: str) -> list[str]:
    return [folder for folder in os.environ.get(variable, "").split(os.pathsep) if folder]
