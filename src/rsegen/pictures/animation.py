"""An animated WebP that is made frame by frame, of what changes from one to the next: any browser plays it.

Pillow's own takes all frames at once, a megabyte each. Here each frame is a still picture of the rectangle in which
pixels have changed, as Pillow encodes it, in the frame of an animation (ANMF). A frame that is like the one before it
makes that one last longer. Source: WebP Container Specification, https://developers.google.com/speed/webp/docs/riff_container
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field

import numpy as np

from rsegen.pictures.camera import Pixels

_QUALITY = 85
"""Quality of lossy WebP: edges of blocks are sharp, and colours differ by a few of 255."""

_LONGEST = (1 << 24) - 1
"""Milliseconds that a frame lasts at most: they have three bytes."""

_KEPT = b"\x02"
"""The flags of a frame: it replaces what was there (no blending), and stays (no disposal)."""


@dataclass(kw_only=True, slots=True, eq=False)
class Animation:
    """An animation, of which each frame lasts some milliseconds; all frames have one size."""

    milliseconds: int
    _frames: list[bytes] = field(default_factory=list)
    _last: Pixels | None = None
    _open: tuple[bytes, bytes] = (b"", b"")
    _lasts: int = 0

    def add(self, pixels: Pixels) -> None:
        """Add a frame, (height, width, 3)."""
        left, top, changed = 0, 0, pixels
        if self._last is not None:
            differs = (pixels != self._last).any(axis=2)
            rows, columns = (np.flatnonzero(differs.any(axis=axis)) for axis in (1, 0))
            if not len(rows) and self._lasts + self.milliseconds <= _LONGEST:
                self._lasts += self.milliseconds
                return
            # Its corner is at even pixels, as the format counts them in twos. Without a change it is one pixel: the
            # frame before has lasted as long as it can.
            top, left = (int(changes[0]) // 2 * 2 if len(changes) else 0 for changes in (rows, columns))
            bottom, right = (int(changes[-1]) + 1 if len(changes) else 1 for changes in (rows, columns))
            changed = pixels[top:bottom, left:right]
        self._close()
        high, wide = changed.shape[:2]
        place = b"".join(_three(value) for value in (left // 2, top // 2, wide - 1, high - 1))
        self._open, self._lasts, self._last = (place, _still(changed)), self.milliseconds, pixels

    def file(self) -> bytes:
        """Return the file; there has to be a frame."""
        assert self._last is not None  # noqa: S101  # as promised
        self._close()
        high, wide = self._last.shape[:2]
        animated, black, forever = b"\x02\0\0\0", b"\0\0\0\xff", b"\0\0"
        head = _chunk(b"VP8X", animated + _three(wide - 1) + _three(high - 1)) + _chunk(b"ANIM", black + forever)
        return _chunk(b"RIFF", b"WEBP" + head + b"".join(self._frames))

    def _close(self) -> None:
        """Keep the last frame, now that it is known for how long it lasts."""
        place, still = self._open
        if still:
            self._frames.append(_chunk(b"ANMF", place + _three(self._lasts) + _KEPT + still))
        self._open = (b"", b"")


def _still(pixels: Pixels) -> bytes:
    """Return a picture as the chunk of its pixels in a WebP file."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "webp", quality=_QUALITY, method=2)
    return stream.getvalue()[12:]  # without RIFF, its length, and WEBP


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + len(content).to_bytes(4, "little") + content + b"\0" * (len(content) % 2)


def _three(value: int) -> bytes:
    return value.to_bytes(3, "little")
