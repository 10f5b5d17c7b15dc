"""What a plug-in has to be to enter a registry, and what is wrong with one that is not."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any

from rsegen.params.plugins import Plugin, failure
from rsegen.params.sorts import parameters


def _same(found: Any) -> Any:
    return found


def _nothing(found: Any) -> str:
    return ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Contract:
    """What a plug-in has to be: a class below `base` or, unless `is_class`, an object of it.

    names: under which it is kept; kept: what is kept of it; check: what else is wrong with it, or an empty text.
    """

    base: type
    names: Callable[[Any], tuple[str, ...]]
    kept: Callable[[Any], Any] = _same
    check: Callable[[Any], str] = _nothing
    is_class: bool = True

    def is_held(self, value: Any, plugin: Plugin) -> bool:
        """Whether a plug-in's module made this value to be kept: a whole class of its own, or an object."""
        if not self.is_class:
            return isinstance(value, self.base)
        own = isinstance(value, type) and issubclass(value, self.base) and value.__module__ == plugin.module.__name__
        return own and not inspect.isabstract(value)

    def problem(self, found: Any) -> str:
        """What is wrong with what a plug-in offers; an empty text where nothing is."""
        base = f"{self.base.__module__}.{self.base.__qualname__}"
        if not self.is_class:
            return self._unsound(found) if isinstance(found, self.base) else f"is not a {base}"
        if not (isinstance(found, type) and issubclass(found, self.base)):
            return f"is not a subclass of {base}"
        if missing := sorted(getattr(found, "__abstractmethods__", ())):
            return f"does not define {', '.join(missing)}"
        if not has_summary(found):
            return "has no docstring; its first line is shown in lists"
        return self._unsound(found)

    def _unsound(self, found: Any) -> str:
        try:
            names = self.names(found)
            if not names or not all(isinstance(name, str) and name for name in names):
                return f"has the name {', '.join(map(repr, names))}; give a text"
            self.kept(found)
            return self.check(found)
        except Exception as error:  # it is somebody else's class, and may do anything
            return failure(error)


def clash(cls: type, reserved: Collection[str], others: Iterable[type] = ()) -> str:
    """What is wrong with the names of a class's parameters: reserved, unexplained, or of another meaning elsewhere."""
    for name, parameter in parameters(cls).items():
        if name in reserved:
            return f"the parameter {name!r} has a reserved name; give it another one"
        if not parameter.help:
            return f"the parameter {name!r} has no help"
        for known in (parameters(other).get(name) for other in others if other is not cls):
            if known and (type(known) is not type(parameter) or known.describe() != parameter.describe()):
                return f"the parameter {name!r} is there already, with other values ({known.describe()})"
    return ""


def has_summary(cls: type) -> bool:
    """Whether a class has a docstring of its own; dataclasses make one up from the signature."""
    doc = (cls.__doc__ or "").strip()
    return bool(doc) and not doc.startswith(f"{cls.__name__}(")
