"""Plug-ins: what installed packages offer, and modules and files loaded by `--plugin` or `load_plugin`.

A package offers objects by entry points, which are found without importing anything but `importlib.metadata`; that, as
it takes half as long to import as numpy, is imported only if a package has such entry points:

    [project.entry-points."rsegen.obstacles"]
    ramp = "rsegen_ramps:Ramp"

Through the loaded modules each registry looks for objects of its own sort. Worker processes load the same plug-ins
before they unpickle their work (`with_plugins`).
"""

from __future__ import annotations

import os
import pickle
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import walk_tb
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from rsegen.errors import PluginError

PREFIX = "rsegen_plugin_"
"""Prefix of the name of a module that was loaded from a file, before the file's own name."""


class Source(NamedTuple):
    """The package or file of a plug-in, as recipe.json records it: `rsegen-ramps 1.2`, or `ramps.py`."""

    name: str
    version: str = ""

    def __str__(self) -> str:
        return f"{self.name} {self.version}".rstrip()

    @classmethod
    def parse(cls, text: str) -> Source:
        """Return the source that a recipe records."""
        name, _, version = text.strip().rpartition(" ")
        return cls(name=name, version=version) if name and not text.endswith(".py") else cls(name=text)

    @property
    def identity(self) -> str:
        """The text of what must not change while a long result is made: of a file that is loaded its checksum too."""
        from rsegen.input_files import checksum_of  # what `--help` loads does without it

        files = [plugin.module.__file__ for plugin in plugins() if plugin.source == self]
        checksum = checksum_of(Path(files[0])) if files and files[0] else None
        return f"{self} {checksum.sha256}" if checksum else str(self)

    @property
    def install_hint(self) -> str:
        """Remedy for a missing plug-in, to be appended to its name."""
        if self.version:
            return f"of {self} is not installed; {sys.executable} -m pip install '{self.name}=={self.version}'"
        return f"of {self} is not loaded; load it by rsegen.load_plugin({str(self)!r})"


class EntryPoint(NamedTuple):
    """A line of a package's metadata: the name under which it offers an object to rsegen, and the object's place."""

    group: str
    name: str
    value: str
    source: Source

    def __str__(self) -> str:
        return f"plug-in {self.name!r} of {self.source} ({self.value})"

    def load(self) -> Any:
        """Return the object that it offers; PluginError for whatever its module raises."""
        module, _, place = self.value.partition(":")
        try:
            offered: Any = import_module(module.strip())
            for part in filter(None, place.strip().split(".")):
                offered = getattr(offered, part)
        except (Exception, SystemExit) as error:
            raise PluginError(f"{self}: {failure(error)}") from None
        return offered


@cache
def entry_points(group: str = "rsegen.") -> tuple[EntryPoint, ...]:
    """Return the entry points of all installed packages for groups that begin so, sorted by their names.

    Of two folders of metadata of one package the first on the path counts. Their files are read here, as every start
    of a command would wait for importlib.metadata: with 160 packages it takes 30 ms of CPU time, 22 for its import and
    8 for `entry_points(group=...)`, and this 5 ms.
    """
    seen, offers = set[str](), list[EntryPoint]()
    for place in dict.fromkeys(sys.path):
        for folder in _metadata(place or "."):
            package = re.sub(r"[-_.]+", "-", folder.stem.partition("-")[0]).lower()
            offers += _offers_of(folder, group) if package not in seen else ()
            seen.add(package)
    return tuple(sorted(offers, key=lambda offer: (offer.group, offer.name, str(offer.source))))


def _metadata(place: str) -> list[Path]:
    """Return the folders of metadata of the packages at a place on the path."""
    try:
        names = sorted(os.listdir(place))
    except OSError:  # most paths hold no packages, and some are not there
        return []
    return [Path(place, name) for name in names if name.endswith((".dist-info", ".egg-info"))]


def _offers_of(folder: Path, group: str) -> Iterator[EntryPoint]:
    """Yield what a package offers; `importlib.metadata` is imported only if its file names such a group."""
    try:
        if f"[{group}".encode() not in (folder / "entry_points.txt").read_bytes():
            return
    except OSError:
        return
    from importlib.metadata import Distribution

    package = Distribution.at(folder)
    source = Source(name=package.metadata["Name"] or folder.name.partition("-")[0], version=package.version or "0")
    for entry in package.entry_points:
        if entry.group.startswith(group):
            yield EntryPoint(group=entry.group, name=entry.name, value=entry.value, source=source)


class Plugin(NamedTuple):
    """A module that was loaded as a plug-in."""

    module: ModuleType
    source: Source


_LOADED: dict[str, Plugin] = {}
"""Loaded plug-ins by a text that finds the module in another process too: the whole path of its file, or its name."""


def load_plugin(module: str | Path) -> ModuleType:
    """Load a plug-in: its obstacles, formats, robots, ... are then known, to workers too.

    Parameters
    ----------
    module : str or Path
        A Python file, or a module by its name.

    Returns
    -------
    module
        The module.

    Raises
    ------
    PluginError
        If it cannot be loaded.
    """
    from rsegen.params.sorts import FilePath  # what `--help` loads does without it

    FilePath("a Python file, or the name of a module").check("module", module)
    text = str(module)
    is_file = isinstance(module, Path) or text.endswith(".py") or os.sep in text
    origin = str(Path(text).resolve()) if is_file else text
    if origin not in _LOADED:
        loaded = _from_file(Path(origin), text) if is_file else _from_name(text)
        _LOADED[origin] = Plugin(module=loaded, source=Source(name=Path(origin).name if is_file else text))
    return _LOADED[origin].module


def plugins() -> tuple[Plugin, ...]:
    """Return the plug-ins that have been loaded, in order."""
    return tuple(_LOADED.values())


def source_of_file(file: str) -> Source | None:
    """Return the plug-in that a file of Python code belongs to, which may be a module of its package; None if none."""
    for plugin in plugins():
        if plugin.module.__file__ == file:
            return plugin.source
    for offer in entry_points():
        top = offer.value.partition(":")[0].partition(".")[0].strip()
        path = getattr(sys.modules.get(top), "__file__", None) or ""
        if file == path or (Path(path).stem == "__init__" and Path(path).parent in Path(file).parents):
            return offer.source
    return None


def failure(error: BaseException, file: str = "") -> str:
    """Describe an error in somebody's module: the line of the file, the error's name and its first line."""
    run = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == file]
    line, message = run[-1] if run else None, str(error)  # the last line of the file that was run before the error
    if isinstance(error, SyntaxError):
        line, message = error.lineno, error.msg
    first = (message.splitlines() or [""])[0]
    return f"{f'line {line}: ' if line else ''}{type(error).__name__}: {first}".removesuffix(": ")


def failure_of_plugin(error: BaseException) -> str:
    """Return what went wrong in the code of a plug-in, which others wrote; an empty text if it was elsewhere."""
    # The innermost frame of a plug-in counts: below it is what it called, perhaps rsegen again.
    for frame, _ in reversed([*walk_tb(error.__traceback__)]):
        file = frame.f_code.co_filename
        if source := source_of_file(file):
            place = f"{os.path.basename(file)}, " if source.version else ""  # a file is its own name
            return f"plug-in {source}: {place}{failure(error, file)}"
    return ""


def _from_name(name: str) -> ModuleType:
    try:
        return import_module(name)
    except (Exception, SystemExit) as error:
        raise PluginError(f"plug-in {name}: {failure(error)}; use a module's name or a file.py") from None


def _from_file(path: Path, text: str) -> ModuleType:
    name = PREFIX + path.stem
    if not path.is_file():
        raise PluginError(f"plug-in {text}: there is no such file")
    if name in sys.modules:
        raise PluginError(f"plug-in {text}: another plug-in file {path.name} is loaded; rename one of them")
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise PluginError(f"plug-in {text}: not a Python file; use a module's name or a file.py")
    sys.modules[name] = module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise PluginError(f"plug-in {text}: {failure(error, str(path))}") from None
    return module


Work = TypeVar("Work", bound=Callable[..., Any])


def with_plugins(work: Work) -> Work:
    """Return work that loads the plug-ins of this process first if it runs in another one."""
    return _CallableWithPlugins(work) if _LOADED else work  # type: ignore[return-value]  # it is called alike


class _CallableWithPlugins:
    """A callable whose pickle holds the names of plug-ins, and after them the callable that may need these."""

    __slots__ = ("work",)

    def __init__(self, work: Callable[..., Any]) -> None:
        self.work = work

    def __call__(self, *arguments: Any) -> Any:
        return self.work(*arguments)

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpacked, (tuple(_LOADED), pickle.dumps(self.work))


def _unpacked(origins: tuple[str, ...], content: bytes) -> _CallableWithPlugins:
    for origin in origins:
        load_plugin(origin)
    return _CallableWithPlugins(pickle.loads(content))  # noqa: S301  # from this user's own process
