"""Registries of obstacles, formats, robots, ... by name, rsegen's own and of plug-ins, each imported on demand.

A name is looked for in rsegen's own files first, then in the plug-in files that were loaded (`load_plugin`), then in
the entry points of installed packages (`entry_points`). Only a list of all of them imports them all.

A `Contract` says what an object of a plug-in must be to enter a registry; anything else is refused with the reason, or
left out of lists with a warning.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from threading import RLock
from types import MappingProxyType
from typing import Any, TypeVar

from rsegen.errors import PluginError, UnknownName
from rsegen.params.capabilities import left_out, offered_modules
from rsegen.params.plugins import EntryPoint, Plugin, Source, entry_points, failure, plugins
from rsegen.params.sorts import parameters


@dataclass(frozen=True, kw_only=True, slots=True)
class Contract:
    """Requirements of a registry: a plug-in is a class below `base` or, unless `is_class`, an object of it.

    names: under which it is stored; stored_object: the object to store; check: any other problem, or an empty text.
    """

    base: type
    names: Callable[[Any], tuple[str, ...]]
    stored_object: Callable[[Any], Any] = lambda plugin: plugin
    check: Callable[[Any], str] = lambda plugin: ""
    is_class: bool = True

    def is_held(self, value: Any, plugin: Plugin) -> bool:
        """Return whether a plug-in's module defines this value to be kept: a whole class of its own, or an object."""
        if not self.is_class:
            return isinstance(value, self.base)
        own = isinstance(value, type) and issubclass(value, self.base) and value.__module__ == plugin.module.__name__
        return own and not inspect.isabstract(value)

    def problem(self, offered: Any) -> str:
        """Return the problem of an object that a plug-in offers; an empty text if it has none."""
        base = f"{self.base.__module__}.{self.base.__qualname__}"
        if not self.is_class:
            return self._unsound(offered) if isinstance(offered, self.base) else f"is not a {base}"
        if not (isinstance(offered, type) and issubclass(offered, self.base)):
            return f"is not a subclass of {base}"
        if missing := sorted(getattr(offered, "__abstractmethods__", ())):
            return f"does not define {', '.join(missing)}"
        doc = (offered.__doc__ or "").strip()
        if not doc or doc.startswith(f"{offered.__name__}("):  # dataclasses make one up from the signature
            return "has no docstring; its first line is shown in lists"
        return _otherwise_called(offered) or self._unsound(offered)

    def _unsound(self, offered: Any) -> str:
        try:
            names = self.names(offered)
            if not names or not all(isinstance(name, str) and name for name in names):
                return f"has the name {', '.join(map(repr, names))}; expected a text"
            self.stored_object(offered)
            return self.check(offered)
        except PluginError as error:
            return str(error)
        except Exception as error:  # it is somebody else's class, and may do anything
            return failure(error)


def _otherwise_called(cls: type) -> str:
    """Return which method of a class takes other arguments than it is called with; an empty text if none does."""
    for part in cls.__mro__[1:]:
        for name, method in vars(part).items():
            own = inspect.getattr_static(cls, name)
            if not (getattr(method, "__isabstractmethod__", False) and inspect.isfunction(own)):
                continue
            asked = inspect.signature(method)
            by_name = [key for key, parameter in asked.parameters.items() if parameter.kind is parameter.KEYWORD_ONLY]
            in_order = [key for key in asked.parameters if key not in by_name]
            try:
                inspect.signature(own).bind(*in_order, **dict.fromkeys(by_name))
            except TypeError:
                arguments = ", ".join([*in_order, *(["*"] if by_name else []), *by_name])
                return f"defines {name}{inspect.signature(own)}; expected {name}({arguments})"
    return ""


def name_conflict(cls: type, reserved: Collection[str], base: type = object, others: Iterable[type] = ()) -> str:
    """Return what is wrong with the parameters that a class declares; an empty text if nothing is.

    A name may be reserved, without help, or have another meaning in one of the `others`. Parameters that only `base`
    or an ancestor of it declares are not looked at.
    """
    declared = {name for part in cls.__mro__ if not issubclass(base, part) for name in inspect.get_annotations(part)}
    for name, parameter in parameters(cls).items():
        if name not in declared:
            continue
        if name in reserved:
            return f"the parameter {name!r} has a reserved name; rename it"
        if not parameter.help:
            return f"the parameter {name!r} has no help"
        for known in (parameters(other).get(name) for other in others if other is not cls):
            if known and (type(known) is not type(parameter) or known.describe() != parameter.describe()):
                return f"the parameter {name!r} exists already, with other values ({known.describe()})"
    return ""


Thing = TypeVar("Thing")
Offered = TypeVar("Offered")


class Registry(Mapping[str, Thing]):
    """Everything of a sort by its name, sorted by names, or by the key that `order` gives for each thing.

    package: its modules add rsegen's own things when they are imported, if it has any besides what capabilities offer;
    group: of entry points of other packages;
    contract: the requirements for plug-ins.
    elsewhere: what is not here, though people look for it here, and where it is, in words.
    A thing may have `also`, a tuple of other words for it, which an unknown name is compared with.
    """

    def __init__(
        self,
        sort: str,
        order: Callable[[Thing], Any] | None = None,
        *,
        contract: Contract,
        package: str = "",
        group: str = "",
        elsewhere: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        # Things and sources by name; the rest is how far the search for plug-ins has come.
        self._sort = sort
        self._order = order
        self._package = package
        self._group = group
        self.contract = contract
        self._elsewhere = elsewhere
        self._things: dict[str, Thing] = {}
        self._sources: dict[str, Source] = {}
        self._own_imported = not (package or group)
        self._modules_seen = 0
        self._lock = RLock()

    def __repr__(self) -> str:
        return f"<{self._sort}: {', '.join(self)}>"

    def __getitem__(self, name: str) -> Thing:
        if name not in self._things or self._modules_seen < len(plugins()):
            self._find(name)
        return self._things[name]

    def __iter__(self) -> Iterator[str]:
        self._find_all()
        order = self._order
        return iter(sorted(self._things, key=lambda name: (order(self._things[name]) if order else 0, name)))

    def __len__(self) -> int:
        self._find_all()
        return len(self._things)

    def add(self, name: str, thing: Thing) -> None:
        """Make a thing known; two of one name are a mistake in the program, a TypeError."""
        if name in self._things and self._things[name] is not thing:
            raise TypeError(f"two {self._sort}s are named {name!r}: {self._things[name]} and {thing}")
        self._things[name] = thing

    def register(self, offered: Offered) -> Offered:
        """Make one of rsegen's own known under its names, as a plug-in's by the contract; a decorator of its class."""
        for name in self.contract.names(offered):
            self.add(name, self.contract.stored_object(offered))
        return offered

    def named(self, name: str, where: str) -> Thing:
        """Look up a user-supplied name; raise UnknownName for `where`, which lists the valid names."""
        if not isinstance(name, str) or name not in self:
            raise UnknownName.among(
                where, self._sort, name, self, self._also_called(name), self._elsewhere.get(str(name), "")
            )
        return self[name]

    def _also_called(self, name: object) -> list[str]:
        """Return the names of the things that say they are `also` called so."""
        word = name.lower().replace("-", "_") if isinstance(name, str) else ""
        return [known for known, thing in self.items() if word in getattr(thing, "also", ())]

    def source(self, name: str) -> Source | None:
        """Return the package or file that a thing comes from; None for rsegen's own."""
        if name in self and name not in self._sources and not is_own(self[name]):
            with self._lock:  # its module may have added it by itself
                self._find_in_modules()
                self._find_offered(name)
        return self._sources.get(name)

    def own(self) -> tuple[Thing, ...]:
        """Return rsegen's own things, without things of plug-ins."""
        with self._lock:
            self._import_all_own()
            return tuple(thing for name, thing in self._things.items() if name not in self._sources)

    def _find(self, name: str) -> None:
        # From the cheapest place to the dearest: the one file, all files, the entry point of a package.
        with self._lock:
            if self._modules_seen < len(plugins()):  # one of them may have a name of rsegen's own
                self._import_all_own()
                self._find_in_modules()
            # The file with the name of the thing, if any, as for many things.
            file = offered_modules(self._group).get(name) or (f"{self._package}.{name}" if self._package else "")
            if file and isinstance(name, str) and name.isidentifier() and not self._own_imported and find_spec(file):
                import_module(file)
            for find in (self._import_all_own, lambda: self._find_offered(name)):
                if name not in self._things:
                    find()

    def _find_all(self) -> None:
        with self._lock:
            self._import_all_own()
            self._find_in_modules()
            for offer in [*self._offers]:
                self._take_or_warn(offer)

    def _take_or_warn(self, offer: EntryPoint) -> None:
        try:
            self._take(offer)
        except PluginError as error:
            left_out(str(error))

    def _import_all_own(self) -> None:
        if self._own_imported:
            return
        for name in _registering_files(self._package) if self._package else ():
            import_module(f"{self._package}.{name}")
        for name in offered_modules(self._group).values():
            import_module(name)
        self._own_imported = True

    def _find_in_modules(self) -> None:
        """Enter what the plug-ins define that were loaded since the last time."""
        # Objects that are known by their identity are skipped: modules import each other's, and rsegen's own.
        fresh = plugins()[self._modules_seen :]
        self._modules_seen += len(fresh)
        for plugin in fresh:
            known = set(map(id, self._things.values()))
            for name, value in [*vars(plugin.module).items()]:
                if self.contract.is_held(value, plugin) and (isinstance(value, type) or id(value) not in known):
                    self._enter(value, plugin.source, f"plug-in {plugin.source} ({name})")

    @cached_property
    def _offers(self) -> list[EntryPoint]:
        """The entry points that have not been imported yet, or could not be."""
        return [offer for offer in entry_points() if offer.group == self._group]

    def _find_offered(self, name: str) -> None:
        if offer := next((offer for offer in self._offers if offer.name == name), None):
            self._take(offer)

    def _take(self, offer: EntryPoint) -> None:
        """Import and enter what a package offers; PluginError if that is not possible."""
        self._offers.remove(offer)  # its module may ask for others
        try:
            self._enter(offer.load(), offer.source, str(offer), offer.name)
        except PluginError:
            self._offers.append(offer)
            raise

    def _enter(self, offered: Any, source: Source, where: str, wanted: str | None = None) -> None:
        """Keep an object of a plug-in under its names; PluginError if it does not meet the contract."""
        contract = self.contract
        if problem := contract.problem(offered) or self._misnamed(offered, contract.names(offered), wanted):
            raise PluginError(f"{where}: {problem}")
        for name in contract.names(offered):
            self._things.setdefault(name, contract.stored_object(offered))
            self._sources[name] = source

    def _misnamed(self, offered: Any, names: Iterable[str], wanted: str | None) -> str:
        """Return the problem of the names of a plug-in's object; an empty text if they have none."""
        if wanted is not None and wanted not in names:
            return f"is named {', '.join(names)}; its entry point must have the same name"
        for name in names:
            known = self._things.get(name, offered)
            if known is not offered and type(known) is not offered:  # a class may be stored as an object of it
                return f"the name {name!r} is taken by {self._sources.get(name, 'rsegen')}"
        return ""


def is_own(plugin: object) -> bool:
    """Return whether a class, a function or a value is rsegen's own and of no plug-in."""
    return str(getattr(plugin, "__module__", "")).startswith("rsegen.")


def offered_names(package: str, group: str) -> list[str]:
    """Return the names of all that a registry has, without an import: helps are printed at once.

    A file of rsegen is called like what it registers, as is the entry point of a plug-in.
    """
    offered = (offer.name for offer in entry_points() if offer.group == group)
    return sorted({*_registering_files(package), *offered_modules(group), *offered})


def _registering_files(package: str) -> list[str]:
    """Return the names of the modules of a package that register something; the others of its folder do not matter."""
    registers = re.compile(r"^@register$|= register\($", re.MULTILINE)
    files = Path(__file__).parents[2].joinpath(*package.split(".")).glob("*.py")
    return sorted(path.stem for path in files if registers.search(path.read_text("utf-8")))


def summary_of_class(cls: type) -> str:
    """Return what a class is in a line: the first one of its docstring."""
    return (cls.__doc__ or "").strip().splitlines()[0]
