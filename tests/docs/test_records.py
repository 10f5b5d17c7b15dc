"""The dates of what was measured."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs import records

DOCS = Path(records.__file__).parent


def test_every_record_has_a_source_and_a_machine() -> None:
    assert {path.stem for path in records.records()} == set(records.SOURCES)
    for row in list(records.table(records.dates("2000-01-01")))[2:]:
        assert all(cell.strip() for cell in row.split("|")[1:-1]), row


def test_a_record_keeps_its_date_until_it_is_measured_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(records, "RESULTS", tmp_path)
    monkeypatch.setattr(records, "DATES", tmp_path / "dates.json")
    for name in ("speed", "scan"):
        (tmp_path / f"{name}.json").write_text("{}")
    records.DATES.write_text(json.dumps(records.dates("2026-01-01")))
    (tmp_path / "scan.json").write_text("{} ")
    assert {name: entry["date"] for name, entry in records.dates("2026-02-02").items()} == {
        "speed": "2026-01-01",
        "scan": "2026-02-02",
    }


def test_every_record_carries_the_state_of_all_code_that_makes_it() -> None:
    for name, entry in records.dates("2000-01-01").items():
        assert entry["code"].keys() == set(records.SOURCES[name].code), name
        assert all(re.fullmatch("[0-9a-f]{8}", state) for state in entry["code"].values())
        assert all((records.ROOT / part).exists() for part in entry["code"])


def test_the_pages_say_which_figures_are_older_than_the_code_that_makes_them() -> None:
    """Failure means that figures have become older, or were measured again: `python -m docs.generate` says so there."""
    dated = records.dates("2000-01-01")
    aged = records.older(dated)
    lines = (DOCS / "records.md").read_text("utf-8").splitlines()
    rows = {row.split("|")[1].strip(): row for row in lines if row.startswith("|")}
    measured = (DOCS / "measured.md").read_text("utf-8")
    for name, source in records.SOURCES.items():
        assert (records.OLDER in rows[source.page]) == (name in aged), name
        assert records.state(dated, name) in rows[source.page], name
    assert all(line in measured.splitlines() for line in records.in_short(dated, "speed"))


@pytest.fixture
def workshop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with one record, `scan`, of a folder and a file of code."""
    source = records.Source("[scans](scan.md)", "python -m benchmarks.scan", ("bench.py", "src/scanning"))
    monkeypatch.setattr(records, "ROOT", tmp_path)
    monkeypatch.setattr(records, "RESULTS", tmp_path)
    monkeypatch.setattr(records, "DATES", tmp_path / "dates.json")
    monkeypatch.setattr(records, "SOURCES", {"scan": source})
    (tmp_path / "src/scanning").mkdir(parents=True)
    (tmp_path / "bench.py").write_text('"""Scan."""\n\nREPEATS = 3\n"""How often."""\n')
    (tmp_path / "src/scanning/finding.py").write_text(
        'def found(a: int) -> str:\n    """Return a text."""\n    return "#" * a\n'
    )
    (tmp_path / "src/scanning/plan.yaml").write_text("a: 1\n")
    (tmp_path / "scan.json").write_text("{}")
    measured(tmp_path)
    return tmp_path


def measured(folder: Path) -> None:
    records.checksum_of.cache_clear()
    (folder / "dates.json").write_text(json.dumps(records.dates("2026-01-01")))


def older_now() -> dict[str, list[str]]:
    records.checksum_of.cache_clear()
    return records.older(records.dates("2026-02-02"))


@pytest.mark.parametrize(
    ("name", "content", "part"),
    [
        ("bench.py", '"""Scan."""\n\nREPEATS = 4\n"""How often."""\n', "bench.py"),
        ("src/scanning/finding.py", 'def found(a: int) -> str:\n    return "##" * a\n', "src/scanning"),
        ("src/scanning/finding.py", 'def found(a: int) -> str:\n    return "" * a\n', "src/scanning"),
        ("src/scanning/plan.yaml", "a: 2\n", "src/scanning"),
        ("src/scanning/new.py", "A = 1\n", "src/scanning"),
        ("src/scanning/finding.py", None, "src/scanning"),
        ("bench.py", None, "bench.py"),
    ],
)
def test_a_record_is_older_when_its_code_changes(workshop: Path, name: str, content: str | None, part: str) -> None:
    assert older_now() == {}
    if content is None:
        (workshop / name).unlink()
    else:
        (workshop / name).write_text(content)
    assert older_now() == {"scan": [part]}
    _, line, *_ = records.in_short(records.dates("2026-02-02"), "scan")
    assert line.startswith("Measured on 2026-01-01 with the code `")
    assert line.endswith("`, which has changed since.")
    (workshop / "scan.json").write_text('{"again": 1}')  # measured again
    measured(workshop)
    assert older_now() == {}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("bench.py", "# A remark.\nREPEATS = 3  # thrice\n"),
        ("src/scanning/finding.py", 'def found(a: int) -> str:\n\n    """Another\n    text."""\n    return "#" * a\n'),
        ("src/scanning/__pycache__/finding.pyc", "x"),
        ("src/other.py", "A = 1\n"),
    ],
)
def test_comments_docstrings_and_other_code_make_no_record_older(workshop: Path, name: str, content: str) -> None:
    (workshop / name).parent.mkdir(exist_ok=True)
    (workshop / name).write_text(content)
    assert older_now() == {}


def test_a_record_that_came_without_a_state_gets_that_of_today_and_keeps_its_date(workshop: Path) -> None:
    dated = json.loads((workshop / "dates.json").read_text())
    del dated["scan"]["code"]
    (workshop / "dates.json").write_text(json.dumps(dated))
    entry = records.dates("2026-02-02")["scan"]
    assert (entry["date"], entry["code"]) == ("2026-01-01", records.code_of("scan"))
    assert len(entry["code"]) == 2
