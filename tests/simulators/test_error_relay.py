"""Error lines that are passed on once, however often they come."""

from __future__ import annotations

import pytest

from rsegen.simulators.process import ErrorRelay, grouped_line


@pytest.mark.parametrize(
    ("one", "other", "is_one"),
    [
        ("[Err] [a.cc:9] entity [37]", "[Err] [a.cc:9] entity [38]", True),
        ("(2026-01-01 00:00:00.123) [error] at -1.5e-07", "(2026-01-02 10:00:00.4) [error] at 3", True),
        ("[Err] no rse_0001.obj", "[Err] no rse_0002.obj", False),
        ("[Err] no mesh", "[Err] no plug-in", False),
    ],
)
def test_lines_are_one_if_they_differ_in_numbers_that_stand_alone(one: str, other: str, *, is_one: bool) -> None:
    passed: list[str] = []
    relay = ErrorRelay(passed.append)
    for line in (one, other, one):
        relay.add(line)
    assert passed == ([one] if is_one else [one, other])
    passed.clear()
    relay.finish()
    assert passed == ([f"{one} (3 times)"] if is_one else [f"{one} (2 times)"])
    assert relay.first == one
    assert relay.lines == ((f"{one} (3 times)",) if is_one else (f"{one} (2 times)", other))


def test_lines_are_counted() -> None:
    lines = [f"[Err] no entity [{number}]" for number in range(5)]
    assert grouped_line([*lines, "[Err] no mesh"]) == ("[Err] no entity [0] (5 times)", "[Err] no mesh")
    assert grouped_line([]) == ()


def test_a_line_that_came_once_is_not_said_again() -> None:
    passed: list[str] = []
    relay = ErrorRelay(passed.append)
    relay.add("[Err] no mesh")
    relay.finish()
    assert passed == ["[Err] no mesh"] == list(relay.lines)
