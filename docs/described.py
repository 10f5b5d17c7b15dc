"""The API page shows public names as `help` does: with plain types, and with the parameters that they declare.

mkdocstrings reads sources and does not run them; this extension of griffe, which reads for it, takes the signatures and
docstrings of the public names from `rsegen` as it runs.
"""

from __future__ import annotations

from inspect import getdoc, signature
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
    for argument in signature(public).parameters.values():
        if argument.name in function.parameters and isinstance(argument.annotation, str):
            function.parameters[argument.name].annotation = str(argument.annotation)
