"""Extras: optional libraries of capabilities, what each is for, and the command that installs them."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple, TypeVar

_Content = TypeVar("_Content")


class Extra(NamedTuple):
    """Libraries that a part of rsegen needs: pip installs rsegen[name], which brings the module, and perhaps more.

    use: what is not possible without it, in words.
    """

    name: str
    module: str
    use: str = ""
    more: tuple[str, ...] = ()

    @property
    def is_missing(self) -> bool:
        """Return whether a library of it is not installed for this Python."""
        return bool(self.missing_modules)

    @property
    def missing_modules(self) -> tuple[str, ...]:
        """Modules of it that are not installed for this Python."""
        return tuple(module for module in (self.module, *self.more) if find_spec(module) is None)


CLUSTER = Extra("cluster", "distributed", "--scheduler: many maps made on a Dask cluster")
"""The extra of the core; those of capabilities stand in their declarations."""


def requirements(package: str = "rsegen") -> dict[str, list[str]]:
    """Return what a package needs, as pip takes it, by its extras; what it always needs by an empty name.

    Empty if it was not installed, as rsegen if it runs from its folder.
    """
    from importlib.metadata import PackageNotFoundError, requires

    try:
        lines = requires(package) or []
    except PackageNotFoundError:
        return {}
    needed: dict[str, list[str]] = {}
    for line in lines:
        requirement, _, marker = line.partition(";")
        extra = re.search(r"extra == ['\"]([\w-]+)", marker)
        if not re.match(r"rsegen\b", requirement):  # `all` names the other extras
            needed.setdefault(extra[1] if extra else "", []).append(requirement.strip())
    return needed


def pip_install(extras: Iterable[str]) -> str:
    """Return the command that installs the libraries of extras for the Python that runs this.

    It names the libraries, not `rsegen[mesh]`: for that pip would look for rsegen in an index. rsegen may come from a
    folder or an archive, and a package of its name in an index may be somebody else's. The extras of plug-ins are those
    of their packages; of one that none has, no command is known.
    """
    from rsegen.params.plugins import entry_points

    extras, own = list(extras), requirements()
    needed = dict(own)
    for package in dict.fromkeys(offer.source.name for offer in entry_points()):
        needed |= {extra: lines for extra, lines in requirements(package).items() if extra not in needed}
    libraries = [requirement for extra in extras for requirement in needed.get(extra, [])]
    if not libraries and own:
        return "the manual of the plug-in that needs it says how to install it"
    libraries = libraries or [f"{Path(__file__).parents[3]}[{','.join(extras)}]"]  # not installed: where it runs from
    return f"{shlex.quote(sys.executable or 'python3')} -m pip install {shlex.join(dict.fromkeys(libraries))}"


def read_with(extra: Extra, path: Path, read: Callable[[], _Content]) -> _Content:
    """Return the result of `read`, which needs a library of an extra; UserError that says how to install it.

    A FileError for all that the library raises.
    """
    from rsegen.errors import UserError
    from rsegen.input_files import read_by_library  # not for declarations, which are all read for `--help`

    try:
        return read_by_library(path, read)
    except ImportError as error:
        raise UserError(f"{path}: needs {error.name}, which is not installed; {pip_install([extra.name])}") from None
