"""The dates of what was measured."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from docs import records


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
