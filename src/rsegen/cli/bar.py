"""A progress bar that counts maps, one after the other."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def counting(maps: int) -> Iterator[Callable[[object], None] | None]:
    """What is told of each map that is done; None where there is no terminal."""
    if not (sys.stderr and sys.stderr.isatty()):
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=maps, unit="map", miniters=1) as bar:

        def done(_: object) -> None:
            bar.update()

        yield done
