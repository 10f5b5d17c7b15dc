"""Requests to a server of the page: conversations whose every call may be damaged."""

from __future__ import annotations

import random

from tests.fuzz.case import Case
from tests.fuzz.pages import FILES, FOLDER


def case(rng: random.Random) -> Case:
    """A conversation, which is made anew of the number in a file."""
    files = {f"{FOLDER}/{name}": text.encode() for name, text in FILES.items()}
    files["number"] = str(rng.randrange(2**32)).encode()
    return Case(family="page", argv=("@page", "number"), files=files, outputs=(FOLDER, "kept"))
