"""Reads text and XML files that may come from anybody: up to a size, and without entities, which can grow."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.errors import FileError, shown
from rsegen.io.input_files import read_start

if TYPE_CHECKING:
    import xml.etree.ElementTree as ET

_DEEPEST = 200
"""Levels of elements in each other; an SDF file has some ten."""


def text_of(path: Path, mib: int, too_large: str) -> str:
    """The text of a file of at most `mib` MiB; FileError if it cannot be read, is larger, or is not UTF-8."""
    try:
        content = read_start(path, mib * 2**20 + 1)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    except ValueError as error:  # a name with a null character
        raise FileError(f"{shown(str(path))}: {error}") from None
    if len(content) > mib * 2**20:
        raise FileError(f"{path}: larger than {mib} MiB, too large for {too_large}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: not a text in UTF-8") from None


def elements(text: str, where: str) -> ET.Element:
    """The root of an XML text; a document type and entities are refused, as bombs are made of them."""
    import xml.etree.ElementTree as ET

    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise FileError(f"{where}: has a document type or entities, which no SDF needs")
    try:
        root = ET.fromstring(text)  # noqa: S314  # without a document type it can only be plain elements
    except (ET.ParseError, LookupError, ValueError) as error:  # the last two for an encoding that is none
        raise FileError(f"{where}: not XML ({error})") from None
    if _is_deeper(root, _DEEPEST):
        raise FileError(f"{where}: nested too deeply, in more than {_DEEPEST} levels")
    return root


def _is_deeper(root: ET.Element, most: int) -> bool:
    """Whether an element has more than `most` levels of others in it, which ElementTree could not write again."""
    level = [root]
    for _ in range(most):
        level = [child for element in level for child in element]
        if not level:
            return False
    return True
