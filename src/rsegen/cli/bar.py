"""A progress bar that counts maps, one after the other; and whether anyone would see one."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def watched() -> bool:
    """Whether there is a terminal for a progress bar."""
    return bool(sys.stderr and sys.stderr.isatty())


@contextmanager
def counting(maps: int) -> Iterator[Callable[[object], None] | None]:
    """A function to call with each map that is done; None without a terminal, or for a single map."""
    if maps == 1 or not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=maps, unit="map", miniters=1) as bar:

        def done(_: object) -> None:
            bar.update()

        yield done
