"""The parts of rsegen: the core, and capabilities, each a folder that can be taken away.

A capability declares itself in the `__init__.py` of its folder, in names alone, so that nothing heavy is imported:

    CAPABILITY = Capability(
        summary="a field found in a point cloud",
        needs=("heights", "pictures"),
        commands=(Command("scan", "make worlds", "write the world of a real field", "rsegen.scanning.commands"),),
        public={"rsegen.scanning.scans": ("scan", "ScannedMap")},
    )

From these declarations alone come the list of commands with its help and completion, `rsegen.__all__`, the menu of the
page, `rsegen doctor`, and tables of the manual. A folder that is deleted takes all of its own with it. A package of
somebody else declares itself by the same means, through an entry point of the group `rsegen.capabilities`.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rsegen.errors import PluginError, PluginWarning, UnknownName
from rsegen.params.extras import Extra
from rsegen.params.plugins import EntryPoint, entry_points

CORE = ("params", "field", "geometry", "obstacles", "recipe", "scene", "gazebo", "writing", "cli")
"""Folders of the core, each of which may import those to its left. All other folders are capabilities."""

GROUPS = (
    "make worlds",
    "measure",
    "drive a robot",
    "simulators",
    "build it in wood",
    "for other programs",
    "for learning",
    "information",
)
"""Headings of `rsegen --help` and of the page's menu, in their order, by the purpose of commands; a capability of
another package may have its own."""


class Command(NamedTuple):
    """A command of the command line: its name, its heading and line in `rsegen --help`, and where it is.

    module: has `add_NAME`, which adds its flags to a parser, and `run_NAME`; function: the public function that it is;
    title: a few words for the page's menu, by default its name; also: other words for which people look for it
    """

    name: str
    group: str
    help: str
    module: str
    function: str = ""
    title: str = ""
    also: tuple[str, ...] = ()


class Capability(NamedTuple):
    """Declaration of a folder. Everything is named by text, as `module` or `module:name`, and imported when it is used.

    needs: the folders of other capabilities that it imports, besides the core
    commands: of the command line, in the order of the help
    public: the public names of rsegen, by their modules
    offers: what it adds to registries of others: their group, as of entry points -> name -> module
    extras: optional libraries
    sidecars: optional files next to each world (`writing/sidecars.py`), which become flags of `generate`
    targets: a function from a text such as DIR#17, which is no file, to the recipe that it names, or None
    reads: a function from the path of a file and its first bytes to what reads it, as `rsegen scan`, or an empty text
    crossers: a function that finds the robot of a kind or file, which crosses fields (`field/crossing.py`)
    predictor: a function that tells how surely a robot gets across a scene (`field/crossing.py`)
    certainty: a function from a recipe and a probability to the recipe whose robot crosses so surely
    doctor: a function that looks at this machine, and gives a `Finding`
    words: the known words of parameters, for forms and completion, by the parameter's name
    calls: modules with functions that the page may call
    notebook: a function to call in notebooks
    manual: its page in docs/
    """

    summary: str
    needs: tuple[str, ...] = ()
    commands: tuple[Command, ...] = ()
    public: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    offers: Mapping[str, Mapping[str, str]] = MappingProxyType({})
    extras: tuple[Extra, ...] = ()
    sidecars: tuple[str, ...] = ()
    targets: str = ""
    reads: str = ""
    crossers: str = ""
    predictor: str = ""
    certainty: str = ""
    doctor: str = ""
    words: Mapping[str, str] = MappingProxyType({})
    calls: tuple[str, ...] = ()
    notebook: str = ""
    manual: str = ""


class Finding(NamedTuple):
    """Findings of a capability on this machine, for `rsegen doctor`.

    title: above its lines; content: for --json, under `name`; missing: each thing with what to do
    """

    name: str
    title: str
    content: list[dict[str, Any]]
    lines: list[str]
    missing: list[tuple[str, str]]


@cache
def own_capabilities() -> Mapping[str, Capability]:
    """Return the core's declaration, and those of the folders that are here, by name."""
    root = Path(__file__).parents[1]
    folders = sorted(path.parent.name for path in root.glob("*/__init__.py"))
    by_name: dict[str, Capability] = {"core": import_module("rsegen.cli").CAPABILITY}
    for folder in folders:
        if folder not in CORE:
            by_name[folder] = import_module(f"rsegen.{folder}").CAPABILITY
    return MappingProxyType(by_name)


@cache
def capabilities() -> Mapping[str, Capability]:
    """Return all capabilities by name, those of other packages too."""
    by_name = dict(own_capabilities())
    for offer in entry_points("rsegen.capabilities"):
        if capability := _loaded(offer, by_name):
            by_name.setdefault(offer.name, capability)
    return MappingProxyType(by_name)


def _loaded(offer: EntryPoint, known: Mapping[str, Capability]) -> Capability | None:
    """Return the capability of another package; None, with a warning, if it cannot be added to those that are known."""
    try:
        return _checked(offer.load(), known)
    except PluginError as error:
        warnings.warn(f"{offer}: {error}; it is left out", PluginWarning, stacklevel=1)
        return None


def _checked(offered: object, known: Mapping[str, Capability]) -> Capability:
    """Return what a package offers if it is a capability that can be added; else raise a PluginError."""
    if not isinstance(offered, Capability):
        raise PluginError(f"{offered!r} is not a rsegen.params.capabilities.Capability")
    taken = {command.name for capability in known.values() for command in capability.commands}
    for command in offered.commands:
        if command.name in taken:
            raise PluginError(f"the command {command.name!r} is taken")
    for need in offered.needs:
        if need not in known:
            raise PluginError(f"it needs {need!r}, which is not here")
    return offered


@cache
def commands() -> Mapping[str, Command]:
    """Return every command by its name, in the order of `rsegen --help`."""
    every = [command for capability in capabilities().values() for command in capability.commands]
    groups = [*GROUPS, *(command.group for command in every if command.group not in GROUPS)]
    return MappingProxyType({command.name: command for group in groups for command in every if command.group == group})


def unknown_command(name: str, known: Collection[str] | None = None) -> UnknownName:
    """Return the error for a command that is not among the known ones, by default all."""
    names = commands() if known is None else known
    meant = [command for command in names if name.lower().replace("-", "_") in commands()[command].also]
    return UnknownName.among("", "command", name, names, meant)


@cache
def public_names() -> Mapping[str, str]:
    """Return the module of every public name of rsegen."""
    return MappingProxyType({name: module for known in capabilities().values() for name, module in _public(known)})


def home_of(name: str) -> str:
    """Return the module of a public name; empty for another one. Other packages are asked for those they alone have."""
    own = (module for known in own_capabilities().values() for public, module in _public(known) if public == name)
    return next(own, "") or public_names().get(name, "")


def _public(capability: Capability) -> Iterator[tuple[str, str]]:
    return ((name, module) for module, names in capability.public.items() for name in names)


def offered_modules(group: str) -> Mapping[str, str]:
    """Return the modules of what rsegen's capabilities add to a registry, by name; other packages have entry points."""
    return {
        name: module
        for capability in own_capabilities().values()
        for name, module in capability.offers.get(group, {}).items()
    }


@cache
def all_extras() -> Mapping[str, Extra]:
    """Return every extra by its name; what several capabilities use it for is joined."""
    joined: dict[str, Extra] = {}
    for extra in (extra for capability in capabilities().values() for extra in capability.extras):
        known = joined.get(extra.name)
        joined[extra.name] = extra._replace(use=f"{known.use}; {extra.use}") if known else extra
    return MappingProxyType(dict(sorted(joined.items())))


def hooks(name: str) -> Iterator[Any]:
    """Yield what the capabilities declare under a field, such as `targets`, each imported when it is reached."""
    for capability in capabilities().values():
        names = getattr(capability, name)
        for place in (names,) if isinstance(names, str) else names:
            if place:
                module, _, attribute = place.partition(":")
                yield getattr(import_module(module), attribute) if attribute else import_module(module)
