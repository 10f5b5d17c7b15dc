"""A map in the formats of other programs: every file of this folder with a `@register` is one, found by being there."""

from rsegen.exporters.formats.base import FORMATS, Format, Step, added, exported, recorded_options, refuse_unready

__all__ = ["FORMATS", "Format", "Step", "added", "exported", "recorded_options", "refuse_unready"]
