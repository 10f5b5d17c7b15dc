"""Promised costs of rsegen, and whether they are kept: every verdict is computed from the figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from benchmarks.figures import Results, Row, Run
from benchmarks.ways import LARGEST, MATRICES

MANY = 1000

Reading = Callable[[Results], float | None]


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """A figure that is to be at most, or else at least, `limit`."""

    text: str
    figure: Reading
    limit: float
    unit: str
    at_most: bool = True

    def ratio(self, results: Results) -> float | None:
        """Ratio of what was measured to what was promised; None if nothing was."""
        found = self.figure(results)
        return None if found is None else found / self.limit

    def met(self, results: Results) -> bool | None:
        """None where it was not measured."""
        ratio = self.ratio(results)
        if ratio is None:
            return None
        return ratio <= 1 if self.at_most else ratio >= 1


def read(name: str, size: int, reading: Callable[[Run], float]) -> Reading:
    """One figure of one work."""

    def figure(results: Results) -> float | None:
        run = results.middle(name, size)
        return None if run is None else reading(run)

    return figure


def over(above: Reading, below: Reading, factor: float = 1) -> Reading:
    """The ratio of two figures."""

    def figure(results: Results) -> float | None:
        top, bottom = above(results), below(results)
        return None if top is None or not bottom else top / bottom * factor

    return figure


def difference(above: Reading, below: Reading) -> Reading:
    """The difference of two figures."""

    def figure(results: Results) -> float | None:
        top, bottom = above(results), below(results)
        return None if top is None or bottom is None else top - bottom

    return figure


def rate(name: str) -> Reading:
    """Maps a second of CPU, where there are enough of them for Python's start not to matter."""

    def figure(results: Results) -> float | None:
        return next((_rate(row) for row in results.commands if row.name == name and row.count >= MANY), None)

    return figure


def _rate(row: Row) -> float | None:
    return row.count / row.middle.cpu if row.middle else None


def _cpu(run: Run) -> float:
    return run.cpu


def _rss(run: Run) -> float:
    return run.rss / 1e6


def _starts() -> Iterator[Target]:
    """Times for which a person waits: Python's start and the imports, and those of numpy on the same machine."""
    numpy, world = read("numpy", 0, _cpu), read("single", 10, _cpu)
    yield Target(text="`rsegen --help`, CPU", figure=read("help", 0, _cpu), limit=0.1, unit="s")
    yield Target(text="the same / `import numpy`'s", figure=over(read("help", 0, _cpu), numpy), limit=0.5, unit="x")
    beyond = difference(world, numpy)
    yield Target(text="a 10 x 10 world, CPU beyond `import numpy`'s", figure=beyond, limit=0.25, unit="s")
    yield Target(text="the same world / `import numpy`'s", figure=over(world, numpy), limit=2.25, unit="x")


def _targets() -> Iterator[Target]:
    million, largest = read("merged", 1000, _cpu), read("merged", LARGEST, _cpu)
    loop, isaaclab = read("loop", 1000, _cpu), read("isaaclab", 1000, _cpu)
    growth = (1000 / LARGEST) ** 2
    written = over(read("merged", LARGEST, lambda run: run.bytes), read("merged", 1000, lambda run: run.bytes), growth)
    yield Target(text="1000 x 1000 to OBJ, CPU", figure=million, limit=1.5, unit="s")
    yield Target(text="the same, peak memory", figure=read("merged", 1000, _rss), limit=300, unit="MB")
    yield Target(text="the loop's CPU / rsegen's", figure=over(loop, million), limit=8, unit="x", at_most=False)
    yield Target(text="IsaacLab's CPU / rsegen's", figure=over(isaaclab, million), limit=50, unit="x", at_most=False)
    yield Target(
        text="80 x 80 to OBJ, CPU", figure=over(read("merged", 80, _cpu), lambda _: 0.001), limit=20, unit="ms"
    )
    yield Target(text="4000 x 4000, peak memory", figure=read("merged", LARGEST, _rss), limit=500, unit="MB")
    yield Target(text="CPU per block, 4000 / 1000", figure=over(largest, million, growth), limit=1.25, unit="x")
    yield Target(text="bytes per block, 4000 / 1000", figure=written, limit=1.25, unit="x")
    yield from _starts()
    yield Target(text="10 x 10 worlds per second and core", figure=rate("maps"), limit=300, unit="/s", at_most=False)
    yield Target(
        text="10 x 10 matrices per second and core", figure=rate(MATRICES.name), limit=20_000, unit="/s", at_most=False
    )


TARGETS = tuple(_targets())
