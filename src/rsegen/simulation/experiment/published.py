"""The figures that the paper published: real-time factor, CPU load in percent and memory in GB, over three runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class PublishedFigures(NamedTuple):
    """A row of the paper's tables."""

    rtf: str
    cpu: str
    memory: str


COMPUTER = "Ryzen 7 2700X, GeForce 1660, 16 GB"

FIGURES: Mapping[str, Mapping[int, PublishedFigures]] = {
    "crawler": {
        0: PublishedFigures("0.27-0.30", "26 %", "7.6 GB"),
        10: PublishedFigures("0.26-0.29", "26 %", "7.6 GB"),
        20: PublishedFigures("0.25-0.28", "26 %", "7.6 GB"),
        40: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
        60: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
        80: PublishedFigures("0.24-0.28", "26 %", "7.7 GB"),
    },
    "burger": {
        0: PublishedFigures("0.98-1", "8 %", "0.8 GB"),
        10: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
        20: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
        40: PublishedFigures("0.96-1", "8 %", "0.8 GB"),
        60: PublishedFigures("0.95-1", "8 %", "0.8 GB"),
        80: PublishedFigures("0.92-1", "8 %", "0.8 GB"),
    },
}
"""By robot (its tracked one had an arm, five cameras and a lidar) and by the side of the map in blocks."""
