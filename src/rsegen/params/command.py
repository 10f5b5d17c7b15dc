"""A command is a function: its annotated signature is the only declaration of its parameters.

    @command
    def drive(
        target: Target,
        *,
        duration: Annotated[float, Float(0.1, 86400, unit="s", help="simulation time")] = 30.0,
    ) -> DriveResult: ...

From there follow the checks of a call in Python (`command`), the flags and what they give (`add_flags`, `given`), the
JSON Schema of a form (`schema`) and the rows of the manual (`rows`). A parameter without a sort, such as `target` or a
callback, is the business of whoever calls: it has no flag. Modules of commands need no numpy: the functions import
in their bodies what does the work, so `rsegen drive -h` prints its help at once.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache, wraps
from inspect import Parameter as Argument
from inspect import Signature, signature, unwrap
from types import MappingProxyType
from typing import Any, NamedTuple, ParamSpec, TypeVar

from rsegen.errors import ParameterError, did_you_mean
from rsegen.params.sorts import Choice, Flag, Json, Parameter, Reference, hints, sort_of, with_lengths

P = ParamSpec("P")
R = TypeVar("R")

HelpText = tuple[str, Callable[[], str]]
"""A title in a help, and a function that returns the text under it when the help is shown."""


@dataclass(frozen=True, slots=True)
class Shell:
    """The form of a parameter on the command line, if not `--its-name VALUE` with the help of its sort.

    flags: in place of --its-name; metavar: the value in the help; default: in words, where the signature says None;
    required: whether a shell must give what Python may leave out; known: returns the words that a shell completes
    """

    flags: tuple[str, ...] = ()
    metavar: str = ""
    help: str = ""
    default: str = ""
    required: bool = False
    known: Callable[[], Iterable[str]] | None = None


class Declared(NamedTuple):
    """A parameter of a command as its signature declares it; `default` is `Argument.empty` if it must be given."""

    name: str
    sort: Parameter
    default: object
    shell: Shell = Shell()

    @property
    def flags(self) -> tuple[str, ...]:
        """The flags that stand for it: `--no-sync` for a switch that is on by default."""
        negation = "no-" if self.is_switch and self.default is True else ""
        return self.shell.flags or (f"--{negation}{self.name.strip('_').replace('_', '-')}",)

    @property
    def is_switch(self) -> bool:
        """Return whether it is a flag without a value: a yes or no with a default."""
        return isinstance(self.sort, Flag) and isinstance(self.default, bool)

    @property
    def words(self) -> Sequence[str]:
        """The few words that it takes; empty for any other sort."""
        return ("yes", "no") if isinstance(self.sort, Flag) else getattr(self.sort, "values", ())

    @property
    def known_names(self) -> Callable[[], Iterable[str]] | None:
        """The function that returns the known names of a reference; None if it has none, as any other sort."""
        return getattr(self.sort, "known", None)

    @property
    def metavar(self) -> str:
        """The value in the help: the few words that it takes, or a word for it."""
        if isinstance(self.sort, Choice | Flag):
            return self.shell.metavar or f"{{{','.join(self.words)}}}"
        return self.shell.metavar or self.name.strip("_").rpartition("_")[2].upper()

    @property
    def help(self) -> str:
        """The meaning, then the values and the default, each where it is not plain already."""
        text = self.shell.help or self.sort.help or self.sort.describe()
        if self.is_switch:
            return text
        is_listed = isinstance(self.sort, Choice | Flag) and not self.shell.metavar
        is_plain = is_listed or isinstance(self.sort, Reference)  # whose help says what it may be
        default = self.shell.default or _shown_default(self.default)
        values = "" if is_plain else self.sort.describe()
        notes = ["required" if self.shell.required else "", values, f"default: {default}" if default else ""]
        details = "; ".join(filter(None, notes))
        return f"{text} ({details})" if details else text


@cache
def declared(owner: Any) -> Mapping[str, Declared]:
    """Return the declared parameters of a command, or of a dataclass of options, in their order."""
    owner = unwrap(owner)
    annotations = hints(owner)
    if is_dataclass(owner):
        defaults = {
            field.name: Argument.empty if field.default is MISSING else field.default for field in fields(owner)
        }
    else:
        defaults = {name: argument.default for name, argument in signature(owner).parameters.items()}
    marked = [name for name in defaults if getattr(annotations.get(name), "__metadata__", ())]
    return MappingProxyType({name: declare(name, annotations[name], defaults[name]) for name in marked})


def declare(name: str, annotation: Any, default: object) -> Declared:
    """Return the declared parameter of an annotated type; PluginError if that has no sort."""
    shells = [mark for mark in annotation.__metadata__ if isinstance(mark, Shell)]
    return Declared(name, sort_of(name, annotation), default, _joined(shells))


def _joined(shells: Sequence[Shell]) -> Shell:
    """Join nested annotations, the outermost last: each says what the inner ones leave open or have otherwise."""
    settings: dict[str, Any] = {}
    for shell in shells:
        settings |= {
            field.name: value for field in fields(shell) if (value := getattr(shell, field.name)) != field.default
        }
    return Shell(**settings)


def default(owner: Callable[..., Any], name: str) -> Any:
    """Return the default of a parameter: there is no other place for it."""
    return declared(owner)[name].default


def command(function: Callable[P, R]) -> Callable[P, R]:
    """Check every declared parameter of each call and hand its canonical form on; None stays if it is the default."""
    shape = signature(function)  # once, as it takes longer than most checks

    @wraps(function)
    def checked(*args: P.args, **named: P.kwargs) -> R:
        try:
            call = shape.bind(*args, **named)
        except TypeError as error:
            raise TypeError(
                _unfit(function.__name__, shape, args, named) or f"{function.__name__}(): {error}"
            ) from None
        # Arguments that were not passed are not in the call: their defaults are not checked, as they may be None.
        for name, value in call.arguments.items():
            parameter = declared(function).get(name)
            if parameter and not (value is None and parameter.default is None):
                call.arguments[name] = parameter.sort.check(name.strip("_"), value)
        return function(*call.args, **call.kwargs)

    return checked


def _unfit(name: str, shape: Signature, args: Sequence[Any], named: Mapping[str, Any]) -> str:
    """Return which arguments of a call its command does not take; an empty text if some are missing."""
    keywords = [key for key, parameter in shape.parameters.items() if parameter.kind is Argument.KEYWORD_ONLY]
    places = len(shape.parameters) - len(keywords)
    if len(args) > places:
        listed = ", ".join([*keywords[:3], *(["..."] if len(keywords) > 3 else [])])
        taken = f"{places} positional argument{'s'[: places != 1]}"
        return f"{name}() takes {taken}, not {len(args)}; name the others: {listed}"
    unknown = next((key for key in named if key not in shape.parameters), "")
    return f"{name}() has no parameter {unknown!r}{did_you_mean(unknown, shape.parameters)}" if unknown else ""


class Reported:
    """Result that is shown by `print`, and in a notebook, as the report that its command prints."""

    __slots__ = ()

    def report(self) -> Iterable[str]:
        """Yield the lines that the command prints."""
        raise NotImplementedError

    def __str__(self) -> str:
        return "\n".join(self.report())

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:  # noqa: FBT001  # IPython's way to ask
        printer.text(str(self))


def add_flags(
    group: Any, owner: Callable[..., Any], *, only: Collection[str] = (), without: Collection[str] = ()
) -> None:
    """Add a flag for each declared parameter to a parser of argparse, or to a group of one.

    Its action keeps the `Declared` as `declared`, of which forms, and `Parser.describe_flags` the help, are made.

    only: the names of those to add, by default all; without: those to leave out
    """
    for parameter in declared(owner).values():
        if parameter.name in without or (only and parameter.name not in only):
            continue
        options: dict[str, Any] = {"action": "append"} if hasattr(parameter.sort, "repeats") else {}
        if parameter.is_switch:
            options = {"action": "store_const", "const": not parameter.default}
        add_flag(group, parameter, required=parameter.shell.required, **options)


def add_flag(group: Any, parameter: Declared, text: str | None = None, **options: Any) -> Any:
    """Add a flag for a declared parameter, with options of argparse; return its action.

    text: its help, if it is not the parameter's
    """
    action = group.add_argument(*parameter.flags, dest=parameter.name, help=text and text.replace("%", "%%"), **options)
    action.declared = parameter
    return action


def given(owner: Callable[..., Any], arguments: Any, units: str | None = None) -> dict[str, Any]:
    """Return what the flags of a parsed command line say, as keyword arguments that are not yet checked.

    units: as in `with_lengths`, for what may be written as `3.5in`
    """
    values: dict[str, Any] = {}
    for name, parameter in declared(owner).items():
        value: Any = getattr(arguments, name, None)
        if isinstance(value, str):
            value = parameter.sort.parse(with_lengths(value, parameter.sort, name, units=units))
        elif isinstance(value, list):  # the texts of a flag that may be repeated
            value = parameter.sort.parse(value)  # type: ignore[arg-type]  # such a sort takes them all
        if value is not None:
            values[name] = value
    return values


@contextmanager
def flags_in_errors(*owners: Callable[..., Any]) -> Iterator[None]:
    """Name the flag in errors of parameters that are raised inside: `robots: 0 is ...` becomes `--robots: 0 is ...`."""
    flags = {
        name.strip("_"): "/".join(parameter.flags) for owner in owners for name, parameter in declared(owner).items()
    }
    try:
        yield
    except ParameterError as error:
        name, bracket, index = error.where.partition("[")
        if name not in flags:
            raise
        raise type(error)(f"{flags[name]}{bracket}{index}", error.problem) from None


def command_schema(owner: Callable[..., Any]) -> dict[str, Json]:
    """Return the JSON Schema (2020-12) of the parameters of a command, of which a form can be made."""
    properties: dict[str, Json] = {}
    needed = []
    for name, parameter in declared(owner).items():
        has_default = parameter.default is not None and parameter.default is not Argument.empty
        default = {"default": parameter.default} if has_default else {}
        properties[name] = {"description": parameter.sort.help} | parameter.sort.schema() | default
        needed += [name] if parameter.default is Argument.empty or parameter.shell.required else []
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": owner.__name__,
        "description": (owner.__doc__ or "").partition("\n")[0],
        "type": "object",
        "properties": properties,
        "required": needed,
        "additionalProperties": False,
    }


def rows(owner: Callable[..., Any]) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield the row of each parameter in the manual: name in Python, flag, values, default, meaning."""
    for parameter in declared(owner).values():
        value = "" if parameter.is_switch else f" {parameter.metavar}"
        yield (
            parameter.name,
            f"{parameter.flags[-1]}{value}",
            parameter.sort.describe(),
            _default_of_row(parameter),
            parameter.sort.help,
        )


def _default_of_row(parameter: Declared) -> str:
    """Return the default in Python, and the default of a shell if it differs."""
    in_python, in_shell = _shown_default(parameter.default), parameter.shell.default
    if parameter.default is Argument.empty or (parameter.shell.required and not in_python):
        return "required"
    return f"{in_python}; in a shell {in_shell}" if in_python and in_shell else in_python or in_shell


def _shown_default(value: object) -> str:
    """Return a default as a person types it; an empty text for an empty or missing default."""
    if value is None or value is Argument.empty or value in ("", ()):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
