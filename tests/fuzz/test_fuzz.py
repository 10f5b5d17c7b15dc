"""Hostile input, many cases of it; and every case that ever failed. make fuzz runs as many as are wanted."""

from __future__ import annotations

import json
import os
import random
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from docs.records import today
from rsegen import StepField
from tests.fuzz import fields, pages
from tests.fuzz.case import Case, Content, Special, read_case
from tests.fuzz.families import FAMILIES, case_of
from tests.page.client import Reply
from tests.support.patience import run

FOLDER = Path(__file__).parent
FEW = 80
"""Cases of any family, of which the dear ones are rare."""
pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="limits of memory, and what a file is, as Linux has them"
)


def fuzz(*arguments: object) -> tuple[int, str]:
    """Exit code and output."""
    command = [sys.executable, "-m", "tests.fuzz", *arguments]
    found = run(command, cpu_seconds=900, capture_output=True, text=True, cwd=FOLDER.parents[1])
    return found.returncode, found.stdout + found.stderr


@pytest.mark.slow
def test_no_hostile_input_breaks_a_command() -> None:
    """In CI the same cases every time; else others, whose seed is in the output."""
    code, said = fuzz("--cases", FEW, "--processes", 1, *(["--seed", 1] if os.environ.get("CI") == "true" else []))
    print(said)  # noqa: T201  # the seed
    assert code == 0, said
    assert said.splitlines()[-1].startswith(f"0 of {FEW} cases fail, seed ")


@pytest.mark.slow
@pytest.mark.parametrize("family", ["page", "field"])
@pytest.mark.long(reason="by its command; make test has the same in its own process")
def test_no_conversation_breaks_the_page_and_no_field_is_found_wrong(family: str, tmp_path: Path) -> None:
    record, first_day = tmp_path / "fuzz.json", today()
    code, said = fuzz("--cases", 1, "--family", family, "--record", record)
    print(said)  # noqa: T201  # the seed
    assert code == 0, said
    assert said.splitlines()[-1].startswith("0 of 1 cases fail, seed ")
    (result,) = json.loads(record.read_text("utf-8"))
    assert (result["family"], result["cases"], result["fail"]) == (family, 1, 0)
    assert result["date"] in {first_day, today()}  # midnight may pass


@pytest.mark.slow
def test_fields_are_found_refused_and_found_in_spite_of_what_spoiled_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the cases of the family would show nothing: each of the ways in which they should end happens."""
    monkeypatch.chdir(tmp_path)
    ended = Counter(fields.scan_of(number) for number in range(1, 9))
    assert ended["found"] >= 5
    assert ended["found in spite of much"] >= 1
    assert ended["refused for much"] >= 1
    assert ended["found halved"] + ended["missed"] <= 1, "nearly all that were spoiled a little are found"


@pytest.mark.slow
def test_a_field_that_is_found_wrong_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = fields._field

    def another(rng: random.Random) -> StepField:
        field = made(rng)
        monkeypatch.setattr(fields, "_refuse_other", lambda scan, _, told: refuse(scan, wrong(field), told))
        return field

    def wrong(field: StepField) -> StepField:
        levels = field.levels.copy()
        levels[tuple(np.argwhere(~field.frame)[0])] += 1
        return replace(field, levels=levels)

    refuse = fields._refuse_other
    monkeypatch.setattr(fields, "_field", another)
    with pytest.raises(fields.Wrong, match="are not those of"):
        any(fields.scan_of(number) == "found" for number in range(9))


@pytest.mark.slow
def test_a_conversation_asks_much_and_most_of_it_is_answered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    case_of(1, 0, "page").lay_out(tmp_path)
    answered: Counter[int] = Counter()
    judge = pages._judge

    def count(shown: str, reply: Reply) -> None:
        answered[reply.status] += 1
        judge(shown, reply)

    monkeypatch.setattr(pages, "_judge", count)
    assert pages.talk(3) >= pages.CALLS
    assert answered[200] > pages.CALLS / 2
    assert answered[400] > pages.CALLS / 10


def test_a_server_that_fails_is_noticed() -> None:
    failed = Reply(status=500, headers={}, content=b'{"error": {"where": "", "text": "internal error"}}')
    two_lines = Reply(status=400, headers={}, content=b'{"error": {"where": "", "text": "a\nb"}}')
    for reply in (failed, two_lines, Reply(status=400, headers={}, content=b"[]")):
        with pytest.raises(pages.Wrong):
            pages._judge("/api/state", reply)


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
