"""The parameter that takes formats of other programs, and their rows in helps."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.errors import ParameterError, refuse_unknown, shown
from rsegen.params.command import Shell
from rsegen.params.registry import offered_names
from rsegen.params.sorts import Json, Parameter, key_values, parameters

if TYPE_CHECKING:
    from rsegen.formats.base import Format


@dataclass(frozen=True)
class FormatList(Parameter):
    """Formats of other programs: in Python as objects, in a shell as in `stl,'mjcf shape=hfield'`.

    flag: by which errors name them
    """

    flag: str = "--formats"
    help: str = ""
    repeats: bool = True

    def check(self, where: str, value: object) -> tuple[Format, ...]:
        from rsegen.formats.base import Format

        if isinstance(value, str | Format) or not isinstance(value, Sequence):
            raise ParameterError(where, f"{shown(value)} is not a list of formats, as in [rsegen.FORMATS['stl']()]")
        for index, entry in enumerate(value):
            if not isinstance(entry, Format):
                raise ParameterError(f"{where}[{index}]", f"{shown(entry)} is no format, as rsegen.FORMATS['stl']() is")
        return tuple(value)

    def parse(self, texts: Any) -> tuple[Format, ...]:
        from rsegen.formats.base import FORMATS

        # All texts of the flag, which may be repeated.
        # An empty part, as between two commas, is a format without a name, which is refused.
        parts = [part or [""] for text in texts for part in _parts(self.flag, text)]
        named = [(FORMATS.named(name, self.flag), words) for name, *words in parts]
        return tuple(_with_options(self.flag, cls, words) for cls, words in named)

    def format(self, value: Any) -> str:
        return ",".join(form.name for form in value)

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": {"type": "string"}}

    def describe(self) -> str:
        return "separated by commas, with options as in stl,'mjcf shape=hfield'"


def _parts(where: str, text: str) -> list[list[str]]:
    """Return the words between commas of a text such as `stl,mjcf shape=hfield`; one without = begins a part, too."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars=",")
    lexer.whitespace_split, lexer.commenters = True, ""
    parts: list[list[str]] = [[]]
    try:
        for word in lexer:
            if word.strip(",") == "":  # one comma or several, of which shlex makes one word
                parts += [[] for _ in word]
            elif parts[-1] and "=" not in word:
                parts.append([word])
            else:
                parts[-1].append(word)
    except ValueError:
        raise ParameterError(f"{where} {shown(text)}", "a quotation mark is not closed") from None
    return parts


def _with_options(where: str, cls: type[Format], words: Sequence[str]) -> Format:
    """Return a format with the options that are given after its name."""
    known = parameters(cls)
    try:
        options = key_values(words, known)
        refuse_unknown(f"option of {cls.name}", options, known)
        return cls(**options)
    except ParameterError as error:
        raise error.of(f"{where} {shown(' '.join([cls.name, *words]))}") from None


Formats = Annotated[
    "Sequence[Format]",
    FormatList(help="add files for other programs to every map; may be repeated"),
    Shell(metavar="'FORMAT KEY=VALUE ...'"),
]


def names_in_help() -> str:
    """Return the names of all formats, as a help lists them."""
    names = ", ".join(offered_names("rsegen.formats", "rsegen.formats"))
    return f"{names}; rsegen export --list explains them and their options"


HELP_TEXT = ("formats for --formats", names_in_help)
"""Names of formats in the help of commands that write worlds, under their title."""


def listed() -> Iterator[str]:
    """Yield the lines on every format and its options."""
    from rsegen.formats import MAT
    from rsegen.formats.base import FORMATS
    from rsegen.params.registry import summary_of_class

    for name, cls in FORMATS.items():
        extra = f"rsegen[{cls.extra.name if cls.extra else MAT.name}]"
        needs = f" Needs {extra}." if cls.extra else f" {cls.mat_file} needs {extra}." if cls.mat_file else ""
        source = FORMATS.source(name)
        yield f"{name}\n    {summary_of_class(cls)}{needs}" + (f" From {source}." if source else "")
        for option, parameter in parameters(cls).items():
            yield f"    {f'{option}=':<15} {parameter.help}: {parameter.describe()}"
        yield ""
