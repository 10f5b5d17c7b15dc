"""One map in one other format, as a file or a folder: what `rsegen.export` and `Scene.export` do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsegen.errors import ParameterError, UnknownName
from rsegen.exporters.formats import FORMATS, Format, exported, format_named, refuse_unready
from rsegen.exporters.scene import Scene, compose
from rsegen.io.resources import refuse_too_large
from rsegen.io.writer import write, write_file
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Exported:
    """A map that was written in another format: the file or folder, the format's name, and every file."""

    path: Path
    format: str
    files: tuple[Path, ...]


def export(
    map: Recipe | Scene,  # noqa: A002  # the field's word
    path: str | Path,
    format: str | None = None,  # noqa: A002  # the command line's word
    *,
    index: int = 0,
    force: bool = False,
    **options: Any,
) -> Exported:
    """Write one map in another format: `rsegen.export(recipe, "map.glb")`.

    map: a scene, or a recipe, of which map `index` is written. path: a file if it has a suffix, else a folder, in which
    the files are as in one of `export_maps`. format: a name in `rsegen.FORMATS`; by default the suffix of `path` names
    it. options: those of the format, as in `rsegen.export(recipe, "folder", "mjcf", shape="hfield")`. `force` replaces
    what rsegen made before. A UserError says what is wrong before anything is written.
    """
    path = Path(path)
    chosen = _format(path, format, options)
    refuse_unready([chosen])
    recipe = map.recipe if isinstance(map, Scene) else map
    refuse_too_large(recipe, formats=[chosen])
    scene = map if isinstance(map, Scene) else compose(map, index)
    if not path.suffix:
        names = write(exported(scene, [chosen]), path, force=force)
        return Exported(path=path, format=chosen.name, files=tuple(path / name for name in names))
    write_file(_only_file(chosen, scene, path), path, force=force)
    return Exported(path=path, format=chosen.name, files=(path,))


def _format(path: Path, name: str | None, options: Mapping[str, Any]) -> Format:
    """The format of a name, or of the suffix of a path, with its options."""
    if name is None and not path.suffix:
        raise ParameterError("format", f"{path} has no suffix; give a format (known: {', '.join(FORMATS)})")
    cls = format_named(path.suffix.lower().removeprefix(".") if name is None else name, "format")
    for option in options:
        if option not in parameters(cls):
            raise UnknownName.among("format", f"option of {cls.name}", option, parameters(cls))
    return cls(**options)


def _only_file(chosen: Format, scene: Scene, path: Path) -> Iterable[bytes]:
    """The content of the one file of a format, or a ParameterError for a format of several."""
    files = chosen.files(scene)
    if len(files) != 1:
        problem = f"{path} is one file, but {chosen.name} writes {len(files)} of them"
        raise ParameterError("path", f"{problem}; give a folder, without a suffix")
    (content,) = files.values()
    return content
