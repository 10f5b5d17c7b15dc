"""The flags of formats for other programs, as in --to stl,'mjcf shape=hfield', and the formats that they stand for."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator, Sequence

from rsegen.cli.key_values import key_values
from rsegen.cli.parser import HelpRow, Parser
from rsegen.errors import ParameterError, refuse_unknown, shown
from rsegen.exporters.formats import FORMATS, Format, format_named
from rsegen.params.extras import MAT
from rsegen.params.registry import summary
from rsegen.params.sorts import Parameter, parameters


def add_format_flags(command: Parser, group: argparse._ArgumentGroup, name: str, text: str) -> None:
    """The flag that names formats, with their options below in the help."""
    dest = name.lstrip("-")
    required = dest == "to"
    metavar = "'FORMAT KEY=VALUE ...'"
    group.add_argument(name, action="append", default=None, required=required, metavar=metavar, help=text)
    command.add_rows(f"formats for {name}, and their options (rsegen export --list explains them)", _rows)


def formats_of(where: str, texts: Sequence[str] | None) -> tuple[Format, ...]:
    """The formats that a flag names, with their options."""
    chosen = [one for text in texts or () for one in _named(where, text)]
    formats = tuple(_with_options(where, cls, words) for cls, words in chosen)
    for each in formats:
        if each.left_out:
            print(f"rsegen: {each.left_out}", file=sys.stderr)
    return formats


def listed() -> Iterator[str]:
    """What every format is, and its options."""
    for name, cls in FORMATS.items():
        extra = f"rsegen[{cls.extra.name if cls.extra else MAT.name}]"
        needs = f" Needs {extra}." if cls.extra else f" {cls.mat_file} needs {extra}." if cls.mat_file else ""
        source = FORMATS.source(name)
        yield f"{name}\n    {summary(cls)}{needs}" + (f" From {source}." if source else "")
        for option, parameter in parameters(cls).items():
            yield f"    {f'{option}=':<15} {parameter.help}: {parameter.describe()}"
        yield ""


def _named(where: str, text: str) -> Iterator[tuple[type[Format], list[str]]]:
    """Each format of a text such as `stl,mjcf shape=hfield`, with the words that follow it."""
    for part in _parts(where, text):
        name, *words = part or [""]
        yield format_named(name, where), words


def _parts(where: str, text: str) -> list[list[str]]:
    """The words between commas; a word without = begins a part, too."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=",")
    lexer.whitespace_split, lexer.commenters = True, ""
    parts: list[list[str]] = [[]]
    try:
        for word in lexer:
            if word.strip(",") == "":
                parts += [[] for _ in word]
            elif parts[-1] and "=" not in word:
                parts.append([word])
            else:
                parts[-1].append(word)
    except ValueError:
        raise ParameterError(f"{where} {shown(text)}", "a quotation mark is not closed") from None
    return parts


def _with_options(where: str, cls: type[Format], words: Sequence[str]) -> Format:
    """A format with the options that are given after its name."""
    known = parameters(cls)
    try:
        own = key_values(words, known)
        refuse_unknown(f"option of {cls.name}", own, known)
        return cls(**own)
    except ParameterError as error:
        raise error.of(f"{where} {shown(' '.join([cls.name, *words]))}") from None


def _rows() -> Iterator[HelpRow]:
    for name, cls in FORMATS.items():
        yield HelpRow(name, " ".join(f"{option}={_values(one)}" for option, one in parameters(cls).items()))


def _values(option: Parameter) -> str:
    return option.describe().replace(", ", "|").replace(" or ", "|").replace(" ", "")
