"""Touched parts of robots, of contacts that are known by heart."""

from __future__ import annotations

import csv as tables

import pytest

from rsegen.driving.recording import contact_shares, contacts_csv, robot_contacts
from rsegen.simulators.poses import Contact


def contact(one: str, other: str) -> Contact:
    return Contact(collisions=(one, other), position=(1.0, 2.0, 0.03))


HULL, WHEEL = "a::base::hull", "a::left::tread"
BLOCK, OTHER = "map::link::collision", "b::base::hull"
LOOKS = [
    (0.0, []),
    (0.5, [contact(WHEEL, BLOCK)]),
    (1.0, [contact(WHEEL, BLOCK), contact(BLOCK, HULL), contact(HULL, WHEEL)]),
    (1.5, [contact(OTHER, HULL), contact(WHEEL, BLOCK), contact(WHEEL, OTHER)]),
]


def test_each_part_touches_in_a_share_of_the_looks() -> None:
    assert contact_shares(LOOKS, "a") == {"left::tread": 0.75, "base::hull": 0.5}
    assert list(contact_shares(LOOKS, "a")) == ["left::tread", "base::hull"]
    assert contact_shares(LOOKS, "b") == {"base::hull": 0.25}


@pytest.mark.parametrize("samples", [[], [(0.0, []), (0.5, [])]])
def test_without_samples_no_shares_are_reported(samples: list[tuple[float, list[Contact]]]) -> None:
    assert contact_shares(samples, "a") == {}


def test_a_robot_touches_other_models_and_robots_and_not_itself() -> None:
    found = [(contact.t, contact.robot, contact.other) for contact in robot_contacts(LOOKS, ["a", "b"])]
    assert found == [
        (0.5, "a", "map"),
        (1.0, "a", "map"),
        (1.0, "a", "map"),
        (1.5, "b", "a"),
        (1.5, "a", "b"),
        (1.5, "a", "map"),
        (1.5, "a", "b"),
        (1.5, "b", "a"),
    ]


def test_a_table_is_read_back() -> None:
    rows = list(tables.DictReader(contacts_csv(LOOKS[:2], ["a"])))
    assert rows == [
        {"t": "0.5", "robot": "a", "part": "left::tread", "other": "map", "x": "1.0000", "y": "2.0000", "z": "0.0300"}
    ]
