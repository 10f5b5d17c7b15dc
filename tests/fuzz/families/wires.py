"""Messages to a client of a running Gazebo: servers of either wire, whose every message may be damaged."""

from __future__ import annotations

import random

from tests.fuzz.case import Case


def case(rng: random.Random) -> Case:
    """A conversation, which is made anew of the number in a file."""
    wire = rng.choice(("@classic", "@sim"))
    return Case(family="wire", argv=(wire, "number"), files={"number": str(rng.randrange(2**32)).encode()})
