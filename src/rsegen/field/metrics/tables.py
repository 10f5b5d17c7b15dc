"""Metrics as nested dicts for JSON and as flat rows for tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from rsegen.field.stepfield import NANOMETRE_DIGITS


def nested(value: Any) -> Any:
    """Metrics as JSON values: dataclasses as objects, numbers rounded to nine decimals, without large arrays."""
    if is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        return {name: nested(part) for name, part in parts.items() if not isinstance(part, np.ndarray)}
    if isinstance(value, tuple):
        return [nested(part) for part in value]
    return round(value, NANOMETRE_DIGITS) if isinstance(value, float) else value


def flattened(entries: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """The scalar values of nested metrics by dotted name, as in `steps.mean`; without counts and lists."""
    for name, value in entries.items():
        if isinstance(value, dict) and not name.endswith("counts"):
            yield from flattened(value, f"{prefix}{name}.")
        elif not isinstance(value, (dict, list)):
            yield f"{prefix}{name}", value
