"""The benchmark of learning gives a row for each shape of each engine that is installed, and the page shows them."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import pytest

import rsegen
from benchmarks import engines, learning
from benchmarks.figures import keep, record_in
from rsegen import Random, Recipe

RECIPE = Recipe(seed=7, chunk_size=8, boundary="none", unit_cm=5, obstacles=[Random(levels=5)])


@pytest.mark.long(reason="needs Newton, with Warp 0.5 GB")
@pytest.mark.slow
def test_every_shape_of_every_engine_has_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    pytest.importorskip("newton", reason="Newton is not installed")
    for name, value in (("TURNS", 1), ("STEPS", 3), ("SETTLING", 3)):
        monkeypatch.setattr(engines, name, value)
    rows = list(engines.rows(RECIPE))
    boxes = len(rsegen.boxes(rsegen.build(RECIPE)).centres)
    assert [(row.engine.partition(" ")[0], row.shape) for row in rows] == [
        *(("MuJoCo", shape) for shape in ("boxes", "a box per block", "hfield", "mesh")),
        *(("Newton", shape) for shape in ("boxes", "mesh")),
    ]
    assert [row.geoms for row in rows[:3]] == [rows[4].geoms, 64, 1]
    assert boxes <= rows[0].geoms <= 64
    assert all(row.compile_seconds >= 0 and row.step_microseconds >= 0 for row in rows)
    assert [row.bytes is None for row in rows] == [False] * 4 + [True] * 2
    assert rows[0].bytes < rows[1].bytes  # type: ignore[operator]  # both are known
    lines = list(engines.table(map(asdict, rows)))
    assert len(lines) == 2 + len(rows)
    assert all(line.count("|") == 7 for line in lines)


def test_the_page_has_both_tables() -> None:
    work = learning.Row(work="a", seconds=1.0, count=2, unit="maps", beside="b", beside_seconds=2.0, ratio=0.5)
    engine = engines.EngineRow(
        engine="MuJoCo 4", shape="boxes", geoms=1234, compile_seconds=0.5, bytes=2_000_000, step_microseconds=1500.4
    )
    lines = list(learning.table({"machine": "one", "rows": [asdict(work)], "engines": [asdict(engine)]}))
    assert "| a | 1 | 2 maps | b | 2 | 0.5 |" in lines
    assert "| MuJoCo 4 | boxes | 1,234 | 0.5 | 2 | 1,500 |" in lines
    assert "on: one." in lines[-1]


@pytest.mark.parametrize("is_kept", [True, False])
def test_rows_that_are_measured_alone_are_kept_unless_they_are_to_be_printed_only(
    is_kept: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = {"seconds": 1.0, "count": 2, "unit": "maps", "beside": "b", "beside_seconds": 2.0, "ratio": 0.5}
    old, new = (learning.Row(work=work, **values) for work in ("`Ground.heights`, old", "`Ground.heights`, new"))  # type: ignore[arg-type]
    file = tmp_path / "learning.json"
    keep({"machine": "one", "rows": [asdict(old)], "engines": []}, file)
    monkeypatch.setattr(learning, "FILE", file)
    monkeypatch.setattr(learning, "PARTS", {"the ground": (lambda: iter([new]), "`Ground.heights`")})
    assert learning.main(["--only", "the ground", *([] if is_kept else ["--only-print"])]) == 0
    assert "`Ground.heights`, new" in capsys.readouterr().out
    assert [row["work"] for row in record_in(file)["rows"]] == [new.work if is_kept else old.work]
