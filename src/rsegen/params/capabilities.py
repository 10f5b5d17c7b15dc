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

import re
import sys
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from rsegen.errors import PluginError, PluginWarning, UnknownName
from rsegen.params.extras import Extra
from rsegen.params.plugins import Source, entry_points, failure, plugins

_Imported = TypeVar("_Imported")

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
    """Return the declarations of the core and of every capability folder that exists, by name."""
    root = Path(__file__).parents[1]
    folders = sorted(path.parent.name for path in root.glob("*/__init__.py"))
    by_name: dict[str, Capability] = {"core": import_module("rsegen.cli").CAPABILITY}
    for folder in folders:
        if folder not in CORE:
            by_name[folder] = import_module(f"rsegen.{folder}").CAPABILITY
    return MappingProxyType(by_name)


@cache
def capabilities() -> Mapping[str, Capability]:
    """Return all capabilities by name, also of other packages."""
    by_name = dict(own_capabilities())
    for offer in entry_points("rsegen.capabilities"):
        try:
            offered = offer.load()
            if problem := _problem(offer.name, offered, by_name):
                raise PluginError(f"{offer}: {problem}")
            by_name[offer.name] = offered
        except PluginError as error:
            left_out(str(error))
    return MappingProxyType(by_name)


def left_out(problem: str) -> None:
    """Warn of a plug-in that cannot be used, by a text that names it, and is not."""
    warnings.warn(f"{problem}; it is left out", PluginWarning, stacklevel=2)


_SEVERAL = {"needs": str, "commands": Command, "extras": Extra, "sidecars": str, "calls": str}
"""Types of the elements of the fields that are tuples."""


def _problem(name: str, offered: object, known: Mapping[str, Capability]) -> str:
    """Return why what a package offers cannot be added to known capabilities; an empty text if it can."""
    if not isinstance(offered, Capability):
        return f"{offered!r} is not a rsegen.params.capabilities.Capability"
    for field, declared in offered._asdict().items():
        sort, default = _SEVERAL.get(field), Capability._field_defaults.get(field, "")
        if sort and not (isinstance(declared, tuple) and all(isinstance(element, sort) for element in declared)):
            return f"its field {field!r} is not a tuple of {sort.__name__}"
        if not isinstance(declared, Mapping if isinstance(default, Mapping) else type(default)):
            return f"its field {field!r} is a {type(declared).__name__}"
    if name in known:
        return f"the capability {name!r} exists already; rename the entry point"
    if missing := next((need for need in offered.needs if need not in known), ""):
        return f"it needs {missing!r}, which is not here"
    return _problem_of_names(offered, known)


def _problem_of_names(offered: Capability, known: Mapping[str, Capability]) -> str:
    """Return why commands and public names cannot be added to known capabilities; an empty text if they can."""
    taken = {command.name for capability in known.values() for command in capability.commands} | _BUILT_IN
    for command in offered.commands:
        if not all(isinstance(text, str) for text in command[:6]) or not _COMMAND.fullmatch(command.name):
            return f"{command} is not a command; its name has small letters, digits, - and _, and the rest is text"
        if command.name in taken:
            return f"the command {command.name!r} is taken"
        taken.add(command.name)
    public = {name for capability in known.values() for name, _ in _public(capability)}
    return next((f"the public name {name!r} is taken" for name, _ in _public(offered) if name in public), "")


_BUILT_IN = {"help", "version"}
"""Words that the command line takes for `--help` and `--version`."""

_COMMAND = re.compile(r"[a-z][a-z0-9_-]*")
"""The names of commands."""


@cache
def commands() -> Mapping[str, Command]:
    """Return every command by its name, in the order of `rsegen --help`."""
    every = [command for capability in capabilities().values() for command in capability.commands]
    groups = [*GROUPS, *(command.group for command in every if command.group not in GROUPS)]
    return MappingProxyType({command.name: command for group in groups for command in every if command.group == group})


def command_functions(name: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the function that adds the flags of a command, and the one that runs it; imports its module.

    PluginError if it is the command of another package that has none, or fails to add its flags.
    """
    module, written = commands()[name].module, name.replace("-", "_")
    owner = next(known for known, capability in capabilities().items() if commands()[name] in capability.commands)
    add, run = _of_package(owner, lambda: (_imported(f"{module}:add_{written}"), _imported(f"{module}:run_{written}")))
    return lambda parser: _of_package(owner, lambda: add(parser)), run


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
def known_words() -> Mapping[str, Callable[[], Any]]:
    """Return functions that return the known words of parameters, which take these or something else, such as a file.

    By the names of the parameters. A module is imported when its words are asked for.
    """
    return {
        name: partial(_words_at, owner, place)
        for owner, known in capabilities().items()
        for name, place in known.words.items()
    }


@cache
def _words_at(capability: str, place: str) -> Any:
    """Return the known words that a capability declares at a place; none if another package's cannot be used."""
    return next(_declared(capability, place), {})


def used_sources() -> tuple[Source, ...]:
    """Return the packages and files of others of which this process has imported code: what they give may be wrong.

    The declaration of a capability is imported at every start, and does not count.
    """
    used = [plugin.source for plugin in plugins()]
    for offer in entry_points():
        places = [offer.value]
        if offer.group == "rsegen.capabilities":
            places = _places(capabilities()[offer.name]) if offer.name in capabilities() else []
        used += [offer.source] if any(place.partition(":")[0].strip() in sys.modules for place in places) else []
    return tuple(dict.fromkeys(used))


def _places(capability: Capability) -> list[str]:
    """Return where the code of a capability is, as `module` or `module:name`."""
    one = (getattr(capability, name) for name in ("targets", "reads", "crossers", "predictor", "certainty", "doctor"))
    several = (*capability.public, *capability.sidecars, *capability.calls, *capability.words.values())
    return [*(command.module for command in capability.commands), *several, *one]


@cache
def all_extras() -> Mapping[str, Extra]:
    """Return every extra by its name; what several capabilities use it for is joined."""
    joined: dict[str, Extra] = {}
    for extra in (extra for capability in capabilities().values() for extra in capability.extras):
        known = joined.get(extra.name)
        joined[extra.name] = extra._replace(use=f"{known.use}; {extra.use}") if known else extra
    return MappingProxyType(dict(sorted(joined.items())))


def hooks(name: str, problem: Callable[[Any], str] = lambda hook: "") -> Iterator[Any]:
    """Yield what the capabilities declare under a field, such as `targets`, each imported when it is reached.

    What another package declares and does not have is left out with a warning, and so is what has a problem.
    """
    for known, capability in capabilities().items():
        names = getattr(capability, name)
        for place in (names,) if isinstance(names, str) else names:
            if place:
                yield from _declared(known, place, problem)


def _declared(capability: str, place: str, problem: Callable[[Any], str] = lambda hook: "") -> Iterator[Any]:
    """Yield what a capability declares at a place; nothing, with a warning, if it is another package's and fails."""
    try:
        hook = _of_package(capability, partial(_imported, place, problem))
    except PluginError as error:
        left_out(str(error))
        return
    yield hook


def _imported(place: str, problem: Callable[[Any], str] = lambda hook: "") -> Any:
    """Return what stands at a place, as `module` or `module:name`; PluginError if it has a problem."""
    module, _, attribute = place.partition(":")
    hook = getattr(import_module(module), attribute) if attribute else import_module(module)
    if text := problem(hook):
        raise PluginError(f"{place} {text}")
    return hook


def _of_package(capability: str, imported: Callable[[], _Imported]) -> _Imported:
    """Return what is imported for a capability; if another package's fails, a PluginError that names the package."""
    if capability in own_capabilities():  # rsegen's own: a mistake is to be seen with its traceback
        return imported()
    offer = next(offer for offer in entry_points("rsegen.capabilities") if offer.name == capability)
    try:
        return imported()
    except (Exception, SystemExit) as error:
        problem = str(error) if isinstance(error, PluginError) else failure(error)
        raise PluginError(f"{offer}: {problem}") from None
