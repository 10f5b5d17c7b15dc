"""Every arrangement of blocks on a small grid, by dynamic programming over its cells."""

from __future__ import annotations

Counts = tuple[int, ...]


def possible_counts(shape: tuple[int, int], levels: int, limit: int) -> set[Counts]:
    """The counts of blocks of level 0 .. levels - 1 that some field has whose neighbours differ by `limit` at most."""
    n_x, n_y = shape
    fronts: dict[Counts, set[Counts]] = {(): {(0,) * levels}}  # the last n_y levels, and the counts that lead to them
    for cell in range(n_x * n_y):
        following: dict[Counts, set[Counts]] = {}
        for front, counts in fronts.items():
            for level in range(levels):
                beside = (front[-1:] if cell % n_y else ()) + (front[:1] if len(front) == n_y else ())
                if any(abs(other - level) > limit for other in beside):
                    continue
                new = following.setdefault((*front, level)[-n_y:], set())
                new.update((*each[:level], each[level] + 1, *each[level + 1 :]) for each in counts)
        fronts = following
    return set().union(*fronts.values())
