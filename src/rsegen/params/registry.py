"""Things of one sort that are a file each, and are found by being there: obstacles, formats, robots, simulators."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any, TypeVar

from rsegen.errors import UnknownName

Thing = TypeVar("Thing")


class Registry(Mapping[str, Thing]):
    """Every thing of a sort by its name: in the order of their names, or in that of what `order` gives for each."""

    def __init__(self, sort: str, order: Callable[[Thing], Any] | None = None) -> None:
        self._sort = sort
        self._order = order
        self._things: dict[str, Thing] = {}

    def __getitem__(self, name: str) -> Thing:
        return self._things[name]

    def __iter__(self) -> Iterator[str]:
        order = self._order
        return iter(sorted(self._things, key=lambda name: (order(self._things[name]) if order else 0, name)))

    def __len__(self) -> int:
        return len(self._things)

    def add(self, name: str, thing: Thing) -> None:
        """Make a thing known; two of one name are a mistake in the program, a TypeError."""
        if name in self._things:
            raise TypeError(f"two {self._sort}s are named {name!r}: {self._things[name]} and {thing}")
        self._things[name] = thing

    def gather(self, package: str, path: Iterable[str]) -> None:
        """Import every module of a package, which makes known what is in it."""
        for module in pkgutil.iter_modules(path):
            import_module(f"{package}.{module.name}")

    def named(self, name: str, where: str) -> Thing:
        """The thing of a name that a person gave as `where`, or an UnknownName that lists the known ones."""
        if not isinstance(name, str) or name not in self._things:
            raise UnknownName.among(where, self._sort, name, self)
        return self._things[name]
