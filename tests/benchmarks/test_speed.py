"""The benchmarks run and give every row that they promise; how quick anything is, is no test's business."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.faces import exposed
from benchmarks.figures import Results, Row, Run, loaded, saved
from benchmarks.grids import GRIDS, TOP
from benchmarks.report import MARKS, page, with_table
from benchmarks.targets import TARGETS
from benchmarks.ways import WAYS, commands

ROOT = Path(__file__).parents[2]


def results(cpu: float) -> Results:
    """A million blocks written in so many seconds."""
    run = Run(cpu=cpu, wall=cpu, rss=10**8, bytes=10**8, faces=10**6)
    rows = (Row(name=name, title=name, size=1000, runs=1, middle=run) for name in ("loop", "merged"))
    return Results(machine="a machine", plan="none", writers=tuple(rows))


@pytest.mark.slow
@pytest.mark.long(reason="a run of a benchmark")
def test_a_quick_run_gives_every_row(tmp_path: Path) -> None:
    plan = ["--quick", "--sizes", "10", "--runs", "1", "--output", str(tmp_path)]
    subprocess.run([sys.executable, "-m", "benchmarks.speed", *plan], cwd=ROOT, check=True, capture_output=True)
    found = loaded(tmp_path / "speed.json")
    assert [row.name for row in found.writers] == [way.name for way in WAYS]
    lacking = {row.name: row.missing for row in found.writers if row.missing}
    assert lacking in ({}, {"isaaclab": "not installed here"})
    small = [command.name for command in commands(2) if command.size <= 10]
    assert [row.name for row in found.commands] == [*small, "matrices"]
    assert all(row.middle for row in found.commands)
    assert [each.grid for each in found.faces] == list(GRIDS)
    assert (tmp_path / "speed.md").read_text("utf-8") == page(found)


def test_results_come_back_from_their_json(tmp_path: Path) -> None:
    (tmp_path / "speed.json").write_text(saved(results(1)))
    assert loaded(tmp_path / "speed.json") == results(1)


@pytest.mark.parametrize(("cpu", "verdict"), [(1.5, True), (1.6, False)])
def test_verdicts_are_computed(cpu: float, verdict: bool) -> None:
    assert TARGETS[0].met(results(cpu)) is verdict
    assert TARGETS[0].ratio(results(cpu)) == cpu / 1.5
    assert TARGETS[0].met(replace(results(cpu), writers=())) is None


def test_only_the_marked_part_of_a_text_is_made_anew() -> None:
    made = with_table(f"before\n{MARKS[0]}\nold\n{MARKS[1]}\nafter\n", results(1))
    assert made.startswith(f"before\n{MARKS[0]}\n|")
    assert made.endswith(f"|\n{MARKS[1]}\nafter\n")
    assert with_table(made, results(1)) == made
    with pytest.raises(ValueError, match="no line"):
        with_table("no marks", results(1))


@pytest.mark.parametrize("grid", GRIDS)
def test_grids_are_blocks_of_one_to_five_levels_and_stay(grid: str) -> None:
    levels = GRIDS[grid](12, 3)
    assert levels.shape == (12, 12)
    assert levels.min() >= 1
    assert levels.max() <= TOP
    assert np.array_equal(levels, GRIDS[grid](12, 3))


def test_exposed_faces_of_two_blocks() -> None:
    assert exposed(np.array([[1, 2]], dtype=np.int16)) == 2 + 7
