"""Corners of faces in OBJ files that are counted backwards, which trimesh takes for those from the end of the file.

In `f -3 -2 -1` the corners are the last three points before this line, wherever others follow (Wavefront, Advanced
Visualizer, appendix B1). Such files become equal ones that count forwards. Cost: linear in the lines, if there are any
such corners.
"""

from __future__ import annotations

import re
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import IO

_BACKWARDS = re.compile(rb"^[ \t]*[flp][ \t][^\r\n#]*?(?<=[ \t/])-\d", re.MULTILINE)
"""A line with a corner that is counted backwards."""

_POINTS = (b"v", b"vt", b"vn")
"""Words of lines with points, texture coordinates and normals, which the numbers of a corner count in this order."""


def counted_forwards(path: Path, file: BufferedReader) -> IO[bytes]:
    """Return a file of a mesh, mostly as it is, with corners counted from the first point, as trimesh takes them."""
    if path.suffix.lower() != ".obj":
        return file
    content = file.read()
    if not _BACKWARDS.search(content):
        return BytesIO(content)
    counts, lines = dict.fromkeys(_POINTS, 0), []
    for line in content.splitlines():
        word, *corners = line.split() or [b""]
        if word in counts:
            counts[word] += 1
        is_face = word in (b"f", b"l", b"p")
        lines.append(
            b" ".join([word, *(_forwards(corner, [*counts.values()]) for corner in corners)]) if is_face else line
        )
    return BytesIO(b"\n".join(lines))


def _forwards(corner: bytes, counts: list[int]) -> bytes:
    """Return a corner such as -1//-1 counted forwards, given the counts of points, texture coordinates and normals."""
    numbers = corner.split(b"/")
    pairs = zip(numbers, counts, strict=False)
    return b"/".join(b"%d" % (count + 1 + int(number)) if number[:1] == b"-" else number for number, count in pairs)
