"""Linear colours, which glTF and USD use."""

from __future__ import annotations

from rsegen.exporters.scene import Colour


def srgb_to_linear(colour: Colour) -> Colour:
    """The linear colour of an sRGB colour (IEC 61966-2-1)."""
    red, green, blue = (
        round(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4, 6) for part in colour
    )
    return red, green, blue
