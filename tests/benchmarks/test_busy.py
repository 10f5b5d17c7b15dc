"""The page about busy machines."""

from __future__ import annotations

from benchmarks.busy import page


def test_misses_are_counted_and_each_says_why() -> None:
    tried = [(0, "spawn", 1.0, ""), (0, "spawn", 3.0, ""), (50, "spawn", 40.0, "no answer"), (50, "spawn", 60.0, "")]
    names = ("load", "command", "seconds", "error")
    text = page({"machine": "a computer", "tries": [dict(zip(names, one, strict=True)) for one in tried]})
    assert "| misses; seconds | quiet | 50 programs |" in text
    assert "| `spawn` | 0; 2.0 | 1; 50.0 |" in text
    assert text.endswith("`spawn` beside 50 programs: no answer\n")
