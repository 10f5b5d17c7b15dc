"""What the commands share that write maps in other formats: the flags, and the formats that they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping

from rsegen.cli.flags import flag, given
from rsegen.errors import ParameterError
from rsegen.exporters.formats import FORMATS, Format, format_named, summary
from rsegen.params.sorts import Flag, Parameter, parameters


def add_option_flags(command: argparse.ArgumentParser) -> None:
    """Every option of every format."""
    group = command.add_argument_group("options of formats")
    for name, owners in _options().items():
        helps: dict[str, list[str]] = {}
        for owner, option in owners.items():
            helps.setdefault(option.help, []).append(owner)
        text = "; ".join(f"{', '.join(names)}: {meaning}" for meaning, names in helps.items())
        (option, *_) = owners.values()
        if isinstance(option, Flag):
            group.add_argument(flag(name), dest=name, action="store_const", const="yes", help=_plain(text))
        else:
            values = f"{text} ({option.describe()})"
            group.add_argument(flag(name), dest=name, metavar=name.rpartition("_")[2].upper(), help=_plain(values))


def formats_of(where: str, text: str | None, arguments: argparse.Namespace) -> tuple[Format, ...]:
    """The formats of a text such as `stl,glb`, with the options that were given; one that none has is an error."""
    chosen = [format_named(name.strip(), where) for name in text.split(",")] if text is not None else []
    for name, owners in _options().items():
        if getattr(arguments, name) is not None and not any(cls.name in owners for cls in chosen):
            raise ParameterError(flag(name), f"is an option of {', '.join(owners)}, which {where} does not name")
    return tuple(cls(**given(cls, arguments)) for cls in chosen)


def listed() -> Iterator[str]:
    """What every format is, and its options."""
    for name, cls in FORMATS.items():
        needs = f" Needs pip install 'rsegen[{cls.extra.name}]'." if cls.extra else ""
        source = FORMATS.source(name)
        yield f"{name}\n    {summary(cls)}{needs}" + (f" From {source}." if source else "")
        for option, parameter in parameters(cls).items():
            yield f"    {flag(option):<15} {parameter.help}: {parameter.describe()}"
        yield ""


def _options() -> Mapping[str, Mapping[str, Parameter]]:
    """The options of all formats by name, and under that by the format that has it."""
    found: dict[str, dict[str, Parameter]] = {}
    for owner, cls in FORMATS.items():
        for name, option in parameters(cls).items():
            found.setdefault(name, {})[owner] = option
    return found


def _plain(text: str) -> str:
    return text.replace("%", "%%")
