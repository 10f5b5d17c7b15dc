"""Plain signatures and numpydoc sections of parameters for `help`, Jupyter and the manual, made from declarations.

    duration: Annotated[float, Float(0.1, 1e5, unit="s", help="simulation time")] = 30.0

    signature   duration: float = 30.0
    docstring   duration : float, default 30.0
                    Simulation time (0.1..100000 s).

`rsegen` describes a public name when it is first used; the command line, which prints helps of its own, never does. A
section "Parameters" that a docstring has itself stays: what it says of a parameter counts, and those that are declared
are put between, in the order of the signature.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from inspect import Parameter as Argument
from inspect import cleandoc, isfunction, signature, unwrap
from pathlib import Path
from textwrap import fill
from types import NoneType, UnionType
from typing import Any, ForwardRef, Literal, TypeVar, Union, get_args, get_origin

from rsegen.params.command import Declared, declared
from rsegen.params.sorts import Choice, Flag, Reference, hints

Public = TypeVar("Public")

_HEADING = re.compile(r"^([A-Z][a-z]+)\n---+\n", re.MULTILINE)
_FLAG = re.compile(r"--([a-z][a-z-]*)((?:=\S+)?)")
"""A flag in the help of a parameter, which in Python is a parameter."""

_WIDTH = 100


class _Type(str):
    """A type in words, which signatures show without quotation marks."""

    __slots__ = ()
    __repr__ = str.__str__


def described(public: Public) -> Public:
    """Give a public function or class its plain signature, and its docstring what its parameters declare; return it."""
    made_by = (public.__init__, public.__new__) if isinstance(public, type) else (public,)  # type: ignore[misc]
    function: Any = next(filter(isfunction, made_by), None)
    if function is None:
        return public
    owner: Any = public if is_dataclass(public) else unwrap(function)
    # A command is a wrapped function; what is neither that nor a dataclass declares nothing: it gets plain types alone.
    is_declared = is_dataclass(public) or owner is not function
    types = {name: _Type(text) for name, text in _types(owner, is_declared=is_declared).items()}
    shape = signature(function)
    arguments = [
        parameter.replace(annotation=types.get(parameter.name, parameter.annotation))
        for parameter in shape.parameters.values()
    ]
    result = _Type(shape.return_annotation) if isinstance(shape.return_annotation, str) else shape.return_annotation
    function.__signature__ = shape.replace(parameters=arguments, return_annotation=result)
    if is_declared and (known := declared(owner)):
        entries = {
            name: _entry(parameter, types[name], shape.parameters[name].default) for name, parameter in known.items()
        }
        public.__doc__ = _with_parameters(cleandoc(public.__doc__ or ""), entries, shape.parameters)
    return public


def _types(owner: Any, *, is_declared: bool) -> dict[str, str]:
    """Return the annotations of a function or dataclass as texts, of parameters that are declared without their sort.

    Only commands and dataclasses declare: annotations of others may have names that only type checkers import.
    """
    parts = reversed(owner.__mro__) if isinstance(owner, type) else [owner]
    texts = {name: text for part in parts for name, text in getattr(part, "__annotations__", {}).items()}
    known = hints(owner) if is_declared else {}
    # The annotations of a named tuple are texts inside of a ForwardRef.
    texts = {name: getattr(text, "__forward_arg__", text) for name, text in texts.items()}
    # Parameters that sidecars add to a command have their annotation as it is, and not as a text.
    is_known = {name: isinstance(text, str) or hasattr(text, "__metadata__") for name, text in texts.items()}
    return {name: _plain(text, known.get(name)) for name, text in texts.items() if is_known[name]}


def _plain(text: Any, hint: Any) -> str:
    if not hasattr(hint, "__metadata__"):
        return str(text)
    return hint.__origin__.__forward_arg__ if isinstance(hint.__origin__, ForwardRef) else _words(hint.__origin__)


def _words(type_: Any) -> str:
    """Return a type as it is written, the same in every version of Python, without the modules of its names."""
    origin, parts = get_origin(type_), get_args(type_)
    if origin in (Union, UnionType):
        return " | ".join(map(_words, parts))
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, parts))}]"
    if origin:
        return f"{origin.__name__}[{', '.join(map(_words, parts))}]"
    return {NoneType: "None", Ellipsis: "..."}.get(type_) or type_.__name__


def without_flags(text: str) -> str:
    """Return a help with parameters, in backticks, in place of flags: `--up=-y` is `up=-y` in Python."""
    return _FLAG.sub(lambda flag: f"`{flag[1].replace('-', '_')}{flag[2]}`", text)


def _entry(parameter: Declared, type_: str, default: object) -> str:
    """Return the numpydoc entry of a parameter: name, type and default, then its meaning with unit and range.

    default: in the signature, where that of a field may be made by a function
    """
    sort = parameter.sort
    is_listed = isinstance(sort, Choice) and default in sort.values
    if isinstance(sort, Choice) and is_listed:  # with the default first, as numpydoc asks
        type_ = f"{{{', '.join(map(repr, sorted(sort.values, key=lambda word: word != default)))}}}"
    if default is None or parameter.default is not default:
        type_ += ", optional"
    elif default is not Argument.empty:
        type_ += f", default {str(default)!r}" if isinstance(default, Path) else f", default {default!r}"
    meaning = without_flags(sort.help or sort.describe())
    # The help of a name or a path says what it may be.
    is_plain = is_listed or isinstance(sort, Flag | Reference) or meaning == sort.describe()
    text = meaning[:1].upper() + meaning[1:] + ("" if is_plain else f" ({sort.describe()})")
    if default is None and parameter.shell.default:
        text += f"; by default {parameter.shell.default}"
    body = fill(f"{text}.", _WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
    return f"{parameter.name} : {type_}\n{body}"


def _with_parameters(text: str, made: Mapping[str, str], names: Mapping[str, object]) -> str:
    """Return a docstring with entries in its section of parameters, which comes before all others."""
    # What the docstring itself says of a parameter counts more than its declaration.
    summary, *parts = _HEADING.split(text)
    sections = dict(zip(parts[::2], parts[1::2], strict=True))
    entries = {**made, **dict(_entries(sections.pop("Parameters", "")))}
    body = "\n".join(entries[name] for name in names if name in entries)
    sections = {"Parameters": f"{body}\n"} | sections
    tail = "\n".join(f"{title}\n{'-' * len(title)}\n{body.rstrip()}\n" for title, body in sections.items())
    return f"{summary.rstrip()}\n\n{tail}"


def _entries(section: str) -> Iterator[tuple[str, str]]:
    """Yield the entries of a section, by their name; of several names at once by the first."""
    for entry in re.split(r"\n(?=\S)", section.strip()):
        if entry:
            yield re.split(r"[\s,:]", entry.lstrip("*"))[0], entry
