"""Hostile input, many cases of it; and every case that ever failed. make fuzz runs as many as are wanted."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tests.fuzz.case import Case, Content, Special, read_case
from tests.fuzz.families import FAMILIES, case_of
from tests.support.patience import run

FOLDER = Path(__file__).parent
FEW, MANY = 80, 300
"""Cases of `make test`, and further ones of `make test-all`."""
pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="limits of memory, and what a file is, as Linux has them"
)


def fuzz(*arguments: object) -> tuple[int, str]:
    """Exit code and output."""
    command = [sys.executable, "-m", "tests.fuzz", *arguments]
    found = run(command, cpu_seconds=900, capture_output=True, text=True, cwd=FOLDER.parents[1])
    return found.returncode, found.stdout + found.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cases", "seed"),
    [(FEW, 1), pytest.param(MANY, 2, marks=pytest.mark.long(reason="a quarter of a minute"))],
)
def test_no_hostile_input_breaks_a_command(cases: int, seed: int) -> None:
    """In CI the same cases every time; else others, whose seed is in the output."""
    code, said = fuzz("--cases", cases, *(["--seed", seed] if os.environ.get("CI") == "true" else []))
    print(said)  # noqa: T201  # the seed
    assert code == 0, said
    assert said.splitlines()[-1].startswith(f"0 of {cases:,} cases fail, seed ")


@pytest.mark.slow
def test_no_case_that_failed_once_fails_again() -> None:
    code, said = fuzz("--replay", *sorted((FOLDER / "corpus").glob("*.json")))
    assert code == 0, said
    assert said == ""


@pytest.mark.parametrize("family", FAMILIES)
def test_a_case_is_made_of_its_seed_and_number_alone(family: str) -> None:
    for number in range(5):
        assert case_of(3, number, family) == case_of(3, number, family)


def test_a_case_is_a_line_and_back() -> None:
    files: dict[str, Content] = {
        "a": b"text\n",
        "b": b"\xff\0",
        "c": Special(kind="link", target="/dev/zero"),
        "d/e": "é\u202e".encode(),
    }
    case = Case(family="x", argv=("info", "a\x1b\udcff"), files=files, outputs=("out",), forked=True)
    assert "\n" not in case.line()
    assert read_case(case.line()) == case
