"""A map in the formats of other programs: every file of this folder with a `@register` is one, found by being there."""

from rsegen.exporters.formats.base import FORMATS, Format, Step, added, exported, format_named, options, refuse_unready
from rsegen.params.extras import Extra

__all__ = [
    "FORMATS",
    "Extra",
    "Format",
    "Step",
    "added",
    "exported",
    "format_named",
    "options",
    "refuse_unready",
    "summary",
]
