"""The share of rsegen that a command passes through."""

from __future__ import annotations

from pathlib import Path

from benchmarks.passes import HOUSE, passed
from rsegen.params.capabilities import CORE


def test_a_world_is_made_by_the_core_alone(tmp_path: Path) -> None:
    seen = passed(["generate", "peak", "-o", str(tmp_path / "worlds"), "--quiet"])
    assert "Peak.profile" in {code.co_qualname for code in seen}
    folders = {Path(code.co_filename).relative_to(HOUSE).parts[0] for code in seen}
    assert {"recipe", "writing"} <= folders <= {*CORE, "errors.py", "input_files.py", "__init__.py"}
