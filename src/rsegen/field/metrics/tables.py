"""Metrics as programs read them: nested for JSON, flat for a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from rsegen.field.stepfield import NANOMETRE_DIGITS


def nested(value: Any) -> Any:
    """What JSON can say of metrics: dataclasses as objects, numbers to nine digits; arrays are left out, for size."""
    if is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        return {name: nested(part) for name, part in parts.items() if not isinstance(part, np.ndarray)}
    if isinstance(value, tuple):
        return [nested(part) for part in value]
    return round(value, NANOMETRE_DIGITS) if isinstance(value, float) else value


def flattened(entries: Mapping[str, Any], where: str = "") -> Iterator[tuple[str, Any]]:
    """The single values of an entry, each by its place as in `steps.mean`; what is counted or listed is left out."""
    for name, value in entries.items():
        if isinstance(value, dict) and not name.endswith("counts"):
            yield from flattened(value, f"{where}{name}.")
        elif not isinstance(value, (dict, list)):
            yield f"{where}{name}", value
