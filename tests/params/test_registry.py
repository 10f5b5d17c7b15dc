"""Things that are found by being there."""

from __future__ import annotations

import pytest

from rsegen.errors import UnknownName
from rsegen.params.registry import Registry


def fruits() -> Registry[int]:
    found: Registry[int] = Registry("fruit")
    for name, price in (("pear", 3), ("apple", 5), ("fig", 1)):
        found.add(name, price)
    return found


def test_things_are_there_by_their_names_in_order() -> None:
    assert dict(fruits()) == {"pear": 3, "apple": 5, "fig": 1}
    assert list(fruits()) == ["apple", "fig", "pear"]
    dearest: Registry[int] = Registry("fruit", order=lambda price: -price)
    for name, price in fruits().items():
        dearest.add(name, price)
    assert list(dearest) == ["apple", "pear", "fig"]


def test_two_of_one_name_are_a_mistake() -> None:
    with pytest.raises(TypeError, match="two fruits are named 'fig': 1 and 2"):
        fruits().add("fig", 2)


@pytest.mark.parametrize("name", ["figg", ["fig"], None])
def test_a_name_that_nothing_has_is_told_with_those_that_there_are(name: object) -> None:
    with pytest.raises(UnknownName, match=r"basket: unknown fruit .* \(known: apple, fig, pear\)"):
        fruits().named(name, "basket")  # type: ignore[arg-type]
    assert fruits().named("fig", "basket") == 1
