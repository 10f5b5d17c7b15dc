"""Parses YAML that may come from anybody: the work is bounded by the length of the text."""

from __future__ import annotations

from pathlib import Path

from rsegen.errors import FileError
from rsegen.io.parser_errors import parser_message


def parse_yaml(text: str, path: Path) -> object:
    """The content of a YAML text; a FileError for all that rsegen's own files do not have."""
    from rsegen.io.yaml_loader import Loader

    try:
        return Loader(text, path).get_single_data()
    except FileError:
        raise
    except Exception as error:  # PyYAML fails in many ways at values that are not what their tags say
        mark = getattr(error, "problem_mark", None)
        at = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise FileError(f"{path}{at}: not YAML: {parser_message(error)}") from None
