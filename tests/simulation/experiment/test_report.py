"""Tables, CSV and plot of outcomes that are known."""

from __future__ import annotations

import csv as reading
import io
from dataclasses import replace
from math import pi, sqrt

import pytest
from PIL import Image

from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.published import FIGURES
from rsegen.simulation.experiment.report import median_of, plot, report_page, trials_csv
from rsegen.simulation.experiment.results import Results
from rsegen.simulation.experiment.trial import Outcome

PLAN = ExperimentPlan(
    name="known", rows=(TableRow(sizes=(0, 10, 80)), TableRow(robot="jackal", sizes=(0, 20), recipe={"mesh": "blocks"}))
)
MACHINE = {"processor": "a quick one", "cores": "2"}


def outcome(speed: float, rtf: float | None = None) -> Outcome:
    cpu = None if rtf is None else 0.2
    return Outcome(load=1.0, memory=170.0, cpu=cpu, speed=speed, rtf_min=rtf, rtf=rtf, rtf_max=rtf)


@pytest.fixture
def results() -> Results:
    found: dict[Cell, list[Outcome]] = {}
    for cell in PLAN.cells:
        speeds = (4.0, 5.0, 30.0) if cell.size == 0 else (4.5, 4.0, 1.0)
        found[cell] = [outcome(speed, 0.99 if cell.pace == "real" else None) for speed in speeds]
    return found


def rows(text: str) -> dict[str, list[str]]:
    cells = ([cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line[:1] == "|")
    return {each[0]: each[1:] for each in cells}


def test_the_page_has_medians_and_the_paper_s_figures_beside_them(results: Results) -> None:
    text = report_page(PLAN, results, MACHINE)
    found = rows(text)
    assert found["processor"] == ["a quick one"]
    assert found["80 x 80"] == [
        "0.99, 0.99, 0.99", "20 % of a core", "170 MB", "1.0 s", "4.0", "0.80", *FIGURES["burger"][80],
    ]  # fmt: skip
    assert found["20 x 20"][5] == "0.80"
    assert "on the wall, in real time and at full speed." in text
    assert len(found["20 x 20"]) == 6
    assert "## 3 jackal, unit 1 cm, 5 levels, mesh blocks" in text


def test_a_row_without_an_empty_world_is_held_against_that_of_the_same_robots(results: Results) -> None:
    jackal = replace(PLAN.rows[1], sizes=(20,))
    for number, (robots, found) in enumerate([(3, "0.80"), (2, "-")], 2):
        plan = replace(PLAN, rows=(*PLAN.rows, *[replace(jackal, robots=robots)] * (number - 1)), paces=("free",))
        outcomes = {**results, Cell(row=number, size=20, pace="free"): [outcome(4.0)]}
        assert rows(report_page(plan, outcomes, MACHINE))["20 x 20"][5] == found
        assert "on the wall, at full speed." in report_page(plan, outcomes, MACHINE)


def test_rows_in_two_simulators_are_one_table(results: Results) -> None:
    both = PLAN.in_simulators(["sim", "classic"])
    outcomes = {cell: [outcome(1.0 + cell.row, 0.9)] for cell in both.cells}
    text = report_page(both, outcomes, MACHINE)
    assert text.count("## ") == 2
    table = [line for line in text.splitlines() if line.startswith("| Gazebo ") and "80 x 80" in line]
    assert [[cell.strip() for cell in line.split("|")[1:9]] for line in table] == [
        ["Gazebo Sim", "80 x 80", "0.90, 0.90, 0.90", "20 % of a core", "170 MB", "1.0 s", "1.0", "1.00"],
        ["Gazebo Classic", "80 x 80", "0.90, 0.90, 0.90", "20 % of a core", "170 MB", "1.0 s", "2.0", "1.00"],
    ]
    assert [line.count(FIGURES["burger"][80].cpu) for line in table] == [0, 1]
    assert next(reading.reader(trials_csv(both, outcomes).splitlines()[1:]))[0] == "sim"


def test_a_world_in_turns_with_an_empty_one_is_told_with_its_error(results: Results) -> None:
    def beside(*contact_shares: float) -> str:
        outcomes = [replace(outcome(4.0), share=share) for share in contact_shares]
        text = report_page(PLAN, {**results, Cell(row=0, size=80, pace="beside"): outcomes}, MACHINE)
        return rows(text)["80 x 80"][5]

    assert beside(0.9) == "0.90"
    assert beside(0.8, 0.9, 0.9, 1.0) == f"0.90 ± {sqrt(pi / 2 / 4 * 0.02 / 3):.2f}" == "0.90 ± 0.05"


def test_a_page_of_nothing_yet_has_no_rows_of_figures() -> None:
    assert "10 x 10" not in report_page(PLAN, {}, MACHINE)


def test_the_csv_has_every_trial(results: Results) -> None:
    lines = list(reading.DictReader(io.StringIO(trials_csv(PLAN, results))))
    assert len(lines) == 3 * len(PLAN.cells)
    assert {line["robot"] for line in lines} == {"burger", "jackal"}
    assert [line["speed"] for line in lines if line["size"] == "80" and line["pace"] == "free"] == ["4.5", "4", "1"]


def test_a_median_leaves_out_what_is_not_there() -> None:
    assert median_of([outcome(1), outcome(2, 0.5), outcome(9)], "rtf") == 0.5
    assert median_of([outcome(1)], "rtf") is None


@pytest.mark.slow
def test_the_plot_is_a_picture(results: Results) -> None:
    with Image.open(io.BytesIO(plot(PLAN, results))) as picture:
        assert picture.size == (1100, 450)
