"""What a refused command keeps to: exit code 2, one line, quickly, and everything is as it was."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tests.support.complaints import (
    Refused,
    exit_code,
    snapshot,
    the_line,
)


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Refused:
    """Inside `tmp_path`: exit code 2, quickly; one line on stderr and none on stdout; and everything is as it was."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str | Path) -> str:
        capsys.readouterr()
        before, start = snapshot(tmp_path), time.process_time()
        assert exit_code(*arguments) == 2
        assert time.process_time() - start < 10
        assert snapshot(tmp_path) == before
        out, err = capsys.readouterr()
        assert out == ""
        return the_line(err)

    return run
