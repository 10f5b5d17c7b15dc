"""The API page shows public names as `help` does: with plain types, and with the parameters that they declare.

mkdocstrings reads sources and does not run them; this extension of griffe, which reads for it, takes the signatures and
docstrings of the public names from `rsegen` as it runs.
"""

from __future__ import annotations

from inspect import Parameter, getdoc, signature
from typing import Any

import griffe

import rsegen


class Described(griffe.Extension):
    """Give what was read of public functions and classes the signatures and docstrings that they have when they run."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Describe the public names of rsegen."""
        for name in rsegen.__all__ if pkg.name == "rsegen" else ():
            public = getattr(rsegen, name)
            if callable(public):
                _describe(pkg[public.__module__.partition(".")[2]][public.__name__], public)


def _describe(read: Any, public: Any) -> None:
    read.docstring.value = getdoc(public)
    function = read if read.is_function else read.members.get("__init__")
    if function is None or not function.is_function:
        return
    arguments = signature(public).parameters
    for argument in arguments.values():
        if argument.name not in function.parameters:  # it is declared elsewhere, as the files next to each world are
            default = None if argument.default is Parameter.empty else repr(argument.default)
            keyword = griffe.ParameterKind.keyword_only
            function.parameters.add(griffe.Parameter(argument.name, kind=keyword, default=default))
        if isinstance(argument.annotation, str):
            function.parameters[argument.name].annotation = str(argument.annotation)
    for name in [read.name for read in function.parameters if read.name not in arguments and read.name != "self"]:
        del function.parameters[name]
