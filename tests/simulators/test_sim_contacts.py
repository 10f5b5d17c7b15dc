"""Contacts in Gazebo Sim, of messages that are known by heart."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import pytest

from rsegen.errors import NoMessage
from rsegen.robots.base import ROBOTS, Robot
from rsegen.simulators.gazebo_sim import CONTACTS, ContactSample, GazeboSim
from rsegen.simulators.wire import SIM

WHEEL, HULL, BLOCK = "a::left::tread", "b::base::hull", "map::link::collision"
POINTS = [{"x": 1.0, "y": 2.0, "z": 3.0}, {"x": 3.0}]


def contact(one: str, other: str, points: list[dict[str, float]]) -> bytes:
    return SIM.encode("Contact", {"collision1": {"name": one}, "collision2": {"name": other}, "position": points})


def message(nanoseconds: int, *contacts: bytes) -> dict[str, Any]:
    stamp = {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}
    return {"header": {"stamp": stamp}, "contact": list(contacts)}


def sampled(time: int | None, *messages: dict[str, Any]) -> list[tuple[tuple[str, str], tuple[float, float, float]]]:
    sample = ContactSample()
    sample.add(message(5, contact(WHEEL, HULL, POINTS)))
    sample.begin(time)
    for each in messages:
        sample.add(each)
    return [(each.collisions, each.position) for each in sample.end()]


def test_a_sample_has_the_contacts_of_its_time_with_the_mean_of_their_points() -> None:
    later = message(2_000_000_001, contact(WHEEL, HULL, POINTS))
    assert sampled(2_000_000_000, later) == []
    at_its_time = message(2_000_000_000, contact(WHEEL, BLOCK, POINTS))
    assert sampled(2_000_000_000, at_its_time, later) == [((WHEEL, BLOCK), (2.0, 1.0, 1.5))]


def test_a_contact_reported_by_both_robots_counts_once() -> None:
    both = [message(1, contact(WHEEL, HULL, POINTS)), message(1, contact(HULL, WHEEL, POINTS))]
    assert sampled(1, *both) == sampled(None, *both) == [((WHEEL, HULL), (2.0, 1.0, 1.5))]


def test_messages_that_are_none_are_left_out() -> None:
    with pytest.raises(NoMessage):
        SIM.decode("Contacts", b"\x10\xff\xff\xff\xff\x0f")  # a number, of which bytes would be that many
    assert sampled(1, message(1, b"\x12\xff"), message(1, contact(WHEEL, HULL, [])), {}) == []


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=list(ROBOTS))
def test_sensors_name_every_collision_once_and_change_nothing_else(robot: Robot) -> None:
    plain = robot.model("a", "fortress")
    root = ElementTree.fromstring(GazeboSim().with_contact_sensors(plain))
    for link in root.iter("link"):
        sensors = [sensor for sensor in link.findall("sensor") if sensor.findtext("contact/topic") == CONTACTS]
        named = [name.text for sensor in sensors for name in sensor.findall("contact/collision")]
        assert named == [collision.get("name") for collision in link.findall("collision")]
        for sensor in sensors:
            link.remove(sensor)
    assert ElementTree.canonicalize(ElementTree.tostring(root)) == ElementTree.canonicalize(plain.strip())
