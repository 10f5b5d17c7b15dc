"""The figures that the paper published: real-time factor, CPU load and memory in GB, over three runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rsegen.simulation.experiment.plan import TableRow


class PublishedFigures(NamedTuple):
    """A row of the paper's table 2, as printed."""

    rtf: str
    cpu: str
    memory: str

    @property
    def rtf_limits(self) -> tuple[float, float]:
        """The least and the most real-time factor."""
        least, _, most = self.rtf.partition("-")
        return float(least), float(most)


class PublishedRow(NamedTuple):
    """What the paper's maps and robots were."""

    robot: str
    robots: int
    unit_cm: float
    levels: int


COMPUTER = "Ryzen 7 2700X, GeForce 1660, 16 GB"

_CRAWLER = {
    0: PublishedFigures("0.27-0.30", "26 %", "7.6 GB"),
    10: PublishedFigures("0.26-0.29", "26 %", "7.6 GB"),
    20: PublishedFigures("0.25-0.28", "26 %", "7.6 GB"),
    40: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
    60: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
    80: PublishedFigures("0.24-0.28", "26 %", "7.7 GB"),
}
_BURGERS = {
    0: PublishedFigures("0.98-1", "8 %", "0.8 GB"),
    10: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
    20: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
    40: PublishedFigures("0.96-1", "8 %", "0.8 GB"),
    60: PublishedFigures("0.95-1", "8 %", "0.8 GB"),
    80: PublishedFigures("0.92-1", "8 %", "0.8 GB"),
}

FIGURES: Mapping[PublishedRow, Mapping[int, PublishedFigures]] = {
    PublishedRow("crawler", 1, 10, 5): {size: _CRAWLER[size] for size in (0, 10, 20)},
    PublishedRow("crawler", 1, 10, 10): {size: _CRAWLER[size] for size in (0, 40, 60, 80)},
    PublishedRow("burger", 3, 1, 5): _BURGERS,
}
"""By robots and maps, and by the side of the map in blocks. Its tracked robot had an arm, five cameras and a lidar."""


def published_figures(row: TableRow) -> Mapping[int, PublishedFigures]:
    """The paper's figures for the robots and maps of a row, by size; it used Gazebo Classic, and plain random maps."""
    if row.recipe or row.simulator == "sim":
        return {}
    return FIGURES.get(PublishedRow(row.robot, row.robots, row.unit_cm, row.max_height), {})
