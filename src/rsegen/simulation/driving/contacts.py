"""What robots touched, looked at whenever they decided where to go."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rsegen.simulation.simulators.live_world import Contact

ContactSamples = Sequence[tuple[float, Sequence[Contact]]]
"""Second and what touched what then, look by look."""


class RobotContact(NamedTuple):
    """A part of a robot, LINK::COLLISION, that touches a model, a robot too; x, y, z: the middle of where, metres."""

    t: float
    robot: str
    part: str
    other: str
    x: float
    y: float
    z: float


def robot_contacts(samples: ContactSamples, robots: Iterable[str]) -> Iterator[RobotContact]:
    """Of each of these robots what touched others, in the order of time."""
    names = set(robots)
    for second, contacts in samples:
        for contact in contacts:
            for (robot, _, part), (other, _, _) in _both_ways(contact.names):
                if robot in names and other != robot:
                    yield RobotContact(round(second, 3), robot, part, other, *contact.at)


def contact_shares(samples: ContactSamples, robot: str) -> Mapping[str, float]:
    """Of how many of the looks each part of a robot touched anything, 0..1, the most first."""
    found = {(touch.t, touch.part) for touch in robot_contacts(samples, [robot])}
    often = Counter(part for _, part in sorted(found))
    return {part: round(times / len(samples), 3) for part, times in often.most_common()}


def csv(samples: ContactSamples, robots: Iterable[str]) -> Iterator[str]:
    """Every touch as text."""
    yield ",".join(RobotContact._fields) + "\n"
    for t, robot, part, other, *at in robot_contacts(samples, robots):
        yield ",".join([f"{t:g}", robot, part, other, *(f"{round(along, 4) + 0:.4f}" for along in at)]) + "\n"


def _both_ways(names: tuple[str, str]) -> Iterator[tuple[tuple[str, str, str], tuple[str, str, str]]]:
    one, other = names[0].partition("::"), names[1].partition("::")
    yield one, other
    yield other, one
