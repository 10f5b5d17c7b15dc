"""Formats in a text, as in `stl,'mjcf shape=hfield'`: what flags and files give."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence

from rsegen.errors import ParameterError, refuse_unknown, shown
from rsegen.exporters.formats.base import FORMATS, Format
from rsegen.params.sorts import key_values, parameters


def formats_in(where: str, text: str) -> Iterator[Format]:
    """Yield the formats that a text names, with their options; errors name the flag `where`."""
    parts = [part or [""] for part in _parts(where, text)]
    for cls, words in [(FORMATS.named(name, where), words) for name, *words in parts]:
        yield _with_options(where, cls, words)


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
