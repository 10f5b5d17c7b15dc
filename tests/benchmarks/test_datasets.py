"""The benchmark of data sets gives every row; how quick anything is, is no test's business."""

from __future__ import annotations

import pytest

from benchmarks import datasets
from benchmarks.figures import loaded


@pytest.mark.slow
@pytest.mark.long(reason="a run of a benchmark")
def test_a_run_gives_every_row(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(datasets, "RUNS", 1)
    assert datasets.main(["20", "40"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("| `rsegen dataset --workers 1 --metrics") == 4
    assert printed.count("| `rsegen generate --workers 1` |") == 2
    assert printed.count("| `rsegen dataset --workers 2 --metrics npy` | 40 |") == 1
    assert printed.count("| not measured |") == len(datasets.TARGETS)


def test_the_record_has_a_verdict_on_every_target() -> None:
    assert [target.met(loaded(datasets.FILE)) is None for target in datasets.TARGETS] == [False] * len(datasets.TARGETS)
