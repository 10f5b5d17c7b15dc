"""Plans and results of experiments that a person changed: each wrong value is one line with its place."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
import yaml

from rsegen.errors import FileError, UserError
from rsegen.experiments.plan import load_plan
from rsegen.experiments.run import Entries, load_summary, read_entries
from rsegen.input_files import JOURNAL
from rsegen.writing.journal import read_journal
from tests.support.complaints import Refused

ROW = {"robot": "burger", "robots": 2, "sizes": [0, 10], "recipe": {"obstacles": [{"kind": "peak", "levels": 4}]}}
PLAN = {"name": "x", "rows": [ROW], "paces": ["real"], "seconds": 5, "repeats": 2, "seed": 3}
OUTCOME = {"load": 1.0, "memory": 2.0, "cpu": None, "speed": 1.0, "rtf_min": 1.0, "rtf": 1.0, "rtf_max": 1.0}
CELL = {"row": 0, "size": 10, "pace": "real"}
ENTRY = {"cell": CELL, "repeat": 0, "outcome": OUTCOME}
ODD: list[Any] = [
    None,
    True,
    -1,
    1.5,
    1e300,
    float("nan"),
    10**400,
    "",
    "x",
    "\x00",
    [],
    [None],
    [[1]],
    {},
    {"a": 1},
    [{}],
]


def changed(found: Any) -> Iterator[Any]:
    """Every value in it replaced by every odd one, and deleted."""
    yield from ODD
    if isinstance(found, (dict, list)):
        for key in found if isinstance(found, dict) else range(len(found)):
            for new in changed(found[key]):
                other = copy.copy(found)
                other[key] = new
                yield other
            without = copy.copy(found)
            del without[key]
            yield without


def refused_or_read(path: Path, text: str, read: Any) -> str:
    """The one line of a refusal; empty if it can be read."""
    path.write_text(text, "utf-8")
    said = ""
    try:
        read()
    except UserError as error:
        said = str(error)
    assert not said or said.startswith(str(path))
    assert "\n" not in said
    return said


def test_a_plan_with_any_odd_value_is_read_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    said = [refused_or_read(path, yaml.safe_dump(plan), lambda: load_plan(str(path))) for plan in changed(PLAN)]
    assert sum(map(bool, said)) > len(said) / 2


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ("rows: [{recipe: red}]", "rows[0].recipe: 'red' is not parameters of a recipe"),
        ("rows: [{recipe: [1]}]", "rows[0].recipe: [1] is not parameters of a recipe"),
        ("rows: [{recipe: {1: 2}}]", "rows[0].recipe: unknown key 1"),
        ("rows: [{recipe: {obstacles: 1}}]", "rows[0].recipe.obstacles: 1 is not a list"),
        ("rows: [red]", "rows[0]: 'red' is not a row"),
        ("rows: {}", "not a plan of an experiment"),
        ("rows: [{sizes: [[0]]}]", "rows[0].sizes[0]: [0] is not a whole number"),
        ("rows: []\nname: [1]", "name: invalid value [1]"),
        ("rows: []\nseconds: .inf", "seconds: inf is not a finite number"),
    ],
)
def test_a_plan(refused: Refused, plan: str, words: str) -> None:
    Path("plan.yaml").write_text(plan)
    line = refused("experiment", "plan.yaml", "-o", "out")
    assert "plan.yaml: " in line
    assert words in line


def entries_in(path: Path) -> Entries:
    """Return the outcomes in the journal of a folder, of a plan with one row."""
    return read_entries(read_journal(path.parent), path.parent, 1)


def lines(*entries: object) -> str:
    first = {"rsegen_journal": 1, "holds": "experiment", "of": {"rows": [1]}}
    return "".join(f"{json.dumps(entry)}\n" for entry in (first, *({"result": entry} for entry in entries)))


def test_outcomes_with_any_odd_value_are_read_or_refused(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    said = [refused_or_read(path, lines(entry), lambda: entries_in(path)) for entry in changed(ENTRY)]
    assert sum(map(bool, said)) > len(said) * 0.8
    assert refused_or_read(path, lines(ENTRY), lambda: entries_in(path)) == ""


DAMAGED = "is not a journal of rsegen, or is damaged"
LOGS: Mapping[str, tuple[str, str]] = {
    "no entry": (
        lines({}),
        "result 1: cell: an empty value is not a mapping with row, size, pace; delete its line, or use",
    ),
    "a row beyond": (lines({**ENTRY, "cell": {**CELL, "row": 1}}), "result 1: cell.row: 1 is not 0"),
    "a row in a list": (lines({**ENTRY, "cell": {**CELL, "row": []}}), "result 1: cell.row: [] is not a whole number"),
    "a cell more": (
        lines({**ENTRY, "cell": {**CELL, "n": 1}}),
        "result 1: cell: unknown key 'n' (known: pace, row, size)",
    ),
    "figure in words": (lines(ENTRY, {**ENTRY, "outcome": {**OUTCOME, "load": "x"}}), "result 2: outcome.load: 'x' is"),
    "no repeat": (lines({"cell": CELL, "outcome": OUTCOME}), "result 1: repeat: an empty value is not a whole number"),
    "no result": (lines(1), DAMAGED),
    "deep nesting": (f"{lines()}{'[' * 100_000}\n", DAMAGED),
    "no JSON": (f"{lines()}x\n", DAMAGED),
    "any bytes": ("\udcff\n", DAMAGED),
}


@pytest.mark.parametrize(("text", "words"), LOGS.values(), ids=LOGS)
def test_outcomes(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / JOURNAL
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(FileError) as refusal:
        entries_in(path)
    assert f"{path}: {words}" in str(refusal.value)
    assert path.read_bytes() == text.encode("utf-8", "surrogateescape")


def test_a_journal_that_is_a_pipe_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / JOURNAL)
    with pytest.raises(FileError, match="not a regular file"):
        entries_in(tmp_path / JOURNAL)


def test_a_summary_with_any_odd_value_is_read_or_refused(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump(PLAN))
    plan = json.loads(json.dumps(asdict(load_plan(str(tmp_path / "plan.yaml")))))
    summary = {
        "command": "rsegen experiment plan.yaml",
        "machine": {"cores": "2"},
        "plan": plan,
        "cells": [{**CELL, "outcomes": [OUTCOME]}],
    }
    path = tmp_path / "summary.json"
    said = [refused_or_read(path, json.dumps(one), lambda: load_summary(path)) for one in changed(summary)]
    assert sum(map(bool, said)) > len(said) / 2
    assert refused_or_read(path, json.dumps(summary), lambda: load_summary(path)) == ""
