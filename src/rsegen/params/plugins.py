"""Plug-ins that are not installed: modules and files loaded by `--plugin` or `load_plugin`; and their sources.

Each registry looks through the loaded modules for objects of its own sort. Worker processes load the same plug-ins
before they unpickle their work (`with_plugins`).
"""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable
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
    def install_hint(self) -> str:
        """Remedy for a missing plug-in, to be appended to its name."""
        if self.version:
            return f"of {self} is not installed; {sys.executable} -m pip install '{self.name}=={self.version}'"
        return f"of {self} is not loaded; load it by rsegen.load_plugin({str(self)!r})"


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


def failure(error: BaseException, file: str = "") -> str:
    """Describe an error in somebody's module: the line of the file, the error's name and its first line."""
    run = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == file]
    line, message = run[-1] if run else None, str(error)  # the last line of the file that was run before the error
    if isinstance(error, SyntaxError):
        line, message = error.lineno, error.msg
    first = (message.splitlines() or [""])[0]
    return f"{f'line {line}: ' if line else ''}{type(error).__name__}: {first}".removesuffix(": ")


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
