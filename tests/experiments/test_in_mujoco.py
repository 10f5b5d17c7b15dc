"""An experiment in MuJoCo: the same trials as in a Gazebo, in a process whose cost is measured, and a table of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import rsegen
from rsegen.errors import ParameterError
from rsegen.experiments.plan import ExperimentPlan, TableRow, read_plan
from rsegen.experiments.report import published_figures, report_page
from rsegen.experiments.run import load_summary
from rsegen.experiments.trial import Outcome
from rsegen.experiments.trial_server import refuse_without_frames
from rsegen.simulators.embedded import EMBEDDED

PLAN = ExperimentPlan(
    name="both",
    rows=(TableRow(robot="crawler", robots=1, sizes=(0, 10), unit_cm=1.0),),
    paces=("real", "free", "beside"),
    seconds=1.0,
    repeats=1,
)


def test_trials_in_mujoco_have_the_figures_of_those_in_a_gazebo(tmp_path: Path) -> None:
    plan = replace(PLAN, rows=(replace(PLAN.rows[0], sizes=(10,)),))
    result = rsegen.experiment(plan, tmp_path / "costs", simulator="mujoco")
    assert {cell.pace for cell in result.results} == {"real", "free", "beside"}
    for cell, (outcome,) in result.results.items():
        assert outcome.attempts == 1
        assert outcome.load > 0
        assert outcome.memory > 20
        assert outcome.cpu is not None
        assert outcome.cpu > 0
        assert outcome.driven is not None
        assert outcome.driven > 0
        assert outcome.simulated is not None
        if cell.pace == "real":
            assert outcome.rtf is not None
            assert outcome.rtf > 0  # how near to 1 is for a quiet machine
        else:
            assert outcome.simulated > PLAN.seconds
            assert (outcome.share is not None) is (cell.pace == "beside")
    assert ", in MuJoCo" in result.table
    assert "CPU: server" in result.table
    assert "simulator | MuJoCo" in result.table
    summary = json.loads((tmp_path / "costs/summary.json").read_text())
    assert {row["simulator"] for row in summary["plan"]["rows"]} == {"mujoco"}
    assert load_summary(tmp_path / "costs/summary.json")[1] == result.results
    assert (tmp_path / "costs/tracks/row1-10-free-0.csv").read_text().count("\n") > 5


def test_mujoco_is_a_line_of_the_table_beside_a_gazebo() -> None:
    plan = replace(PLAN, paces=("free",)).in_simulators(["classic", "mujoco"])
    assert plan.tables == [[0, 1]]
    outcome = Outcome(load=1.0, memory=80.0, speed=20.0, simulated=10.0, driven=1.0, stuck=0.0, tipped=0.0)
    page = report_page(plan, {cell: [outcome] for cell in plan.cells}, {}, "rsegen experiment")
    lines = [line for line in page.splitlines() if line.startswith(("| Gazebo Classic |", "| MuJoCo |"))]
    assert len(lines) == 4
    assert {line.count("|") for line in lines} == {page.splitlines()[-6].count("|")}


def test_a_plan_may_name_mujoco_and_the_paper_has_no_figures_of_it() -> None:
    plan = read_plan("p", {"rows": [{"robot": "burger", "simulator": "mujoco", "sizes": [0, 10]}]})
    assert plan.rows[0].simulator == "mujoco"
    assert plan.in_simulators(["classic"]) == plan
    paper = TableRow(
        maps="peak", unit_cm=1.0, levels=5, recipe={"boundary": "divided", "frame_height_cm": 1.0}, sizes=(10,)
    )
    assert published_figures(replace(paper, simulator="classic"))
    assert not published_figures(replace(paper, simulator="mujoco"))


@pytest.mark.parametrize("pace", ["camera", "window"])
def test_frames_of_mujoco_are_not_counted(pace: str) -> None:
    plan = replace(PLAN, paces=(pace,))
    with pytest.raises(ParameterError, match=rf"frames of MuJoCo .* cannot be counted; leave {pace} out"):
        refuse_without_frames(plan, {"mujoco": EMBEDDED["mujoco"]})
