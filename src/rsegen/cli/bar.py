"""A progress bar that counts maps or tiles, one after the other; and whether anyone would see one."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def watched() -> bool:
    """Whether there is a terminal for a progress bar."""
    return bool(sys.stderr and sys.stderr.isatty())


@contextmanager
def counting(count: int, unit: str = "map") -> Iterator[Callable[..., None] | None]:
    """A function to call with each map, or other thing, that is done; None without a terminal, or for a single one."""
    if count == 1 or not watched():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=count, unit=unit, miniters=1) as bar:

        def done(*_: object) -> None:
            bar.update()

        yield done
