"""What robots were in contact with, sampled each time that routes decide."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rsegen.simulation.simulators.live_world import Contact

ContactSamples = Sequence[tuple[float, Sequence[Contact]]]
"""Simulated seconds, and all contacts at that time, sample by sample."""


class RobotContact(NamedTuple):
    """Contact of a part of a robot, LINK::COLLISION, with another model or robot; x, y, z: its mean point, metres."""

    t: float
    robot: str
    part: str
    other: str
    x: float
    y: float
    z: float


def robot_contacts(samples: ContactSamples, robots: Iterable[str]) -> Iterator[RobotContact]:
    """The contacts of these robots with other models, in the order of time."""
    names = set(robots)
    for second, contacts in samples:
        for contact in contacts:
            for (robot, _, part), (other, _, _) in _both_ways(contact.collisions):
                if robot in names and other != robot:
                    yield RobotContact(round(second, 3), robot, part, other, *contact.position)


def contact_shares(samples: ContactSamples, robot: str) -> Mapping[str, float]:
    """For each part of a robot, the share of samples in which it had contact, 0..1, the largest first."""
    found = {(contact.t, contact.part) for contact in robot_contacts(samples, [robot])}
    counts = Counter(part for _, part in sorted(found))
    return {part: round(count / len(samples), 3) for part, count in counts.most_common()}


def contacts_csv(samples: ContactSamples, robots: Iterable[str]) -> Iterator[str]:
    """The lines of contacts.csv: a header, then a line per contact."""
    yield ",".join(RobotContact._fields) + "\n"
    for t, robot, part, other, *point in robot_contacts(samples, robots):
        yield ",".join([f"{t:g}", robot, part, other, *(f"{round(along, 4) + 0:.4f}" for along in point)]) + "\n"


def _both_ways(names: tuple[str, str]) -> Iterator[tuple[tuple[str, str, str], tuple[str, str, str]]]:
    one, other = names[0].partition("::"), names[1].partition("::")
    yield one, other
    yield other, one
