"""Tables, CSV and plot of outcomes that are known."""

from __future__ import annotations

import csv as reading
import io
from dataclasses import replace
from math import pi, sqrt
from typing import Any

import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from PIL import Image

from rsegen.experiments.plan import Cell, ExperimentPlan, TableRow
from rsegen.experiments.report import (
    FIGURES,
    MARK,
    STARVED_MARK,
    PublishedRow,
    median_of,
    plot,
    published_figures,
    report_page,
    rtf_limits,
    trials_csv,
)
from rsegen.experiments.trial import Outcome, Results
from rsegen.field.steps import steps
from rsegen.recipe.building import build

PAPER: dict[str, Any] = {"unit_cm": 1, "levels": 5}
FRAMED: dict[str, Any] = {"boundary": "divided", "frame_height_cm": 1}
SMALL: dict[str, Any] = {**PAPER, "maps": "peak", "recipe": FRAMED}
LARGE: dict[str, Any] = {**PAPER, "maps": "barriers and peaks", "recipe": FRAMED}
CRAWLED: dict[str, Any] = {"unit_cm": 10, "maps": "barriers and peaks", "recipe": {"boundary": "divided"}}
PLAN = ExperimentPlan(
    name="known",
    rows=(
        TableRow(sizes=(0, 10, 80), **LARGE),
        TableRow(robot="jackal", sizes=(0, 20), recipe={"mesh": "blocks"}, **PAPER),
    ),
)
COMMAND = "rsegen experiment my/known.yaml --simulator classic -o costs"
MACHINE = {"processor": "a quick one", "cores": "2"}
COSTS = ("12 % (mean 12 %)", "170 MiB (mean 170 MiB)")
BURGERS = FIGURES[PublishedRow("burger", 3, 1, 5)]


def outcome(speed: float, rtf: float | None = None, stuck: float = 0.1) -> Outcome:
    found = Outcome(load=1.0, memory=170.0, cpu=None, speed=speed, rtf_min=None, rtf=None, rtf_max=None)
    found = replace(found, simulated=20.0, driven=1.5, stuck=stuck, tipped=0.0, covered=0.02)
    if rtf is None:
        return found
    return replace(found, cpu=0.2, machine=0.125, rtf_min=rtf - 0.1, rtf=rtf, rtf_max=rtf + 0.01)


@pytest.fixture
def results() -> Results:
    found: dict[Cell, list[Outcome]] = {}
    for cell in PLAN.cells:
        speeds = (4.0, 5.0, 30.0) if cell.size == 0 else (4.5, 4.0, 1.0)
        real = cell.pace == "real"
        found[cell] = [outcome(speed, 0.99 - 0.02 * n if real else None) for n, speed in enumerate(speeds)]
    return found


def rows(text: str) -> dict[str, list[str]]:
    cells = ([cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line[:1] == "|")
    return {each[0]: each[1:] for each in cells}


def test_the_page_has_costs_drives_and_the_figures_of_the_paper(results: Results) -> None:
    text = report_page(PLAN, results, MACHINE, COMMAND)
    found = rows(text)
    assert found["processor"] == ["a quick one"]
    assert found["80 x 80"] == [
        "0.85-1.00 (0.97)", "20 % of a core", "12 % (mean 12 %)", "170 MiB (mean 170 MiB)", "1.0 s", "4.0", "0.80",
        "1.50 m in 20 s / 1.50 m in 20 s", "10 % / 10 %", "0.00 / 0.00", "2.0 % / 2.0 %", *BURGERS[80],
    ]  # fmt: skip
    assert found["20 x 20"][6] == "0.80"
    assert "of wall time, in real time and at full speed." in text
    assert len(found["20 x 20"]) == 11
    assert "## 3 jackal, unit 1 cm, 5 levels, mesh blocks" in text
    assert MARK not in text


def test_means_stand_beside_the_paper_s_means_and_nowhere_else(results: Results) -> None:
    trials = [
        replace(outcome(4.0, 0.9), machine=machine, memory=memory)
        for machine, memory in ((0.10, 100.0), (0.11, 110.0), (0.60, 600.0))
    ]
    cells = {Cell(row=row, size=size, pace="real"): trials for row, size in ((0, 80), (1, 20))}
    found = rows(report_page(replace(PLAN, paces=("real",)), cells, MACHINE, COMMAND))
    assert found["80 x 80"][2:4] == ["11 % (mean 27 %)", "110 MiB (mean 270 MiB)"]
    assert found["20 x 20"][2:4] == ["11 %", "110 MiB"]
    said = "The paper has means of three runs of CPU and memory; next to its figures, our means are in brackets."
    assert said in report_page(PLAN, results, MACHINE, COMMAND)
    ours = report_page(replace(PLAN, rows=PLAN.rows[1:]), {}, MACHINE, COMMAND)
    assert said not in ours
    assert "The paper's computer" in report_page(PLAN, results, MACHINE, COMMAND)
    assert "paper" not in ours


def test_rtf_is_the_least_and_the_most_that_any_trial_registered() -> None:
    trials = [replace(outcome(1, rtf), rtf_min=low) for rtf, low in ((0.98, 0.97), (0.95, 0.829), (1.0, 0.91))]
    assert rtf_limits(trials) == pytest.approx((0.829, 2.93 / 3, 1.01))
    assert rtf_limits([outcome(1)]) is None


def test_a_row_whose_robots_rested_is_marked_and_explained(results: Results) -> None:
    resting = [outcome(9, stuck=share) for share in (0.9, 0.2, 0.6)]
    text = report_page(PLAN, {**results, Cell(row=0, size=10, pace="free"): resting}, MACHINE, COMMAND)
    assert rows(text)[f"10 x 10 {MARK}"][8] == "10 % / 57 %"
    assert sum(line.startswith(f"{MARK} The robots were stuck") for line in text.splitlines()) == 1
    moving = [outcome(9, stuck=share) for share in (0.9, 0.2, 0.3)]
    assert MARK not in report_page(PLAN, {**results, Cell(row=0, size=10, pace="free"): moving}, MACHINE, COMMAND)


def test_the_first_sentence_says_where_robots_stood_still_and_why(results: Results) -> None:
    def first(*cells: tuple[int, int]) -> str:
        still = {Cell(row=row, size=size, pace="free"): [outcome(9, stuck=0.9)] for row, size in cells}
        return report_page(PLAN, {**results, **still}, MACHINE, COMMAND).splitlines()[2]

    assert first().startswith("Made by")
    still = "**Robots stood still**, stuck for more than half of the time, where † is: "
    share = steps(build(PLAN.rows[0].map_of(10, PLAN.seed))).share_above(0.01)
    assert share is not None
    assert 0.01 < share < 0.6
    burgers = "3 burger, unit 1 cm, 5 levels, barriers and peaks"
    high = f"{burgers}, as {share:.0%} of the steps are higher than the 1 cm that it climbs"
    jackal = "3 jackal, unit 1 cm, 5 levels, for a reason that is not known"
    assert first((0, 10), (0, 80)) == f"{still}{high}."
    assert first((0, 0), (0, 10)) == f"{still}3 burger, without a map too, so maps are not the reason."
    assert first((0, 10), (1, 20)) == f"{still}{high}; {jackal}."


def starved(cpu: float) -> Outcome:
    return replace(outcome(9), simulated=1.0, cpu=cpu, machine=1.0, starved=True, attempts=1)


def test_a_row_with_starved_trials_is_marked_and_explained(results: Results) -> None:
    cell = Cell(row=0, size=10, pace="free")
    text = report_page(PLAN, {**results, cell: [outcome(9), starved(0.07), starved(0.3)]}, MACHINE, COMMAND)
    assert f"10 x 10 {STARVED_MARK}" in rows(text)
    (line,) = [line for line in text.splitlines() if line.startswith(STARVED_MARK)]
    said = "2 trials, with 7.0 % of a core or more, 1 s of simulation time or more, the machine's load up to 100 %."
    assert line.endswith(said)
    both = report_page(PLAN, {**results, cell: [replace(starved(0.07), stuck=0.9)]}, MACHINE, COMMAND)
    assert f"10 x 10 {MARK} {STARVED_MARK}" in rows(both)
    assert both.count(f"\n{MARK} The robots were stuck") == 1
    (csv_line,) = reading.DictReader(io.StringIO(trials_csv(PLAN, {cell: [starved(0.07)]})))
    assert (csv_line["starved"], csv_line["cpu"], csv_line["attempts"]) == ("yes", "0.07", "1")
    assert STARVED_MARK not in report_page(PLAN, results, MACHINE, COMMAND)


def test_attempts_and_what_happened_to_robots_are_counted_per_cell(results: Results) -> None:
    def recorded(attempts: int, off: float = 0.0, impossible: float = 0.0) -> Outcome:
        return replace(outcome(4.0), attempts=attempts, off=off, impossible=impossible)

    cell = Cell(row=0, size=80, pace="free")
    outcomes = {cell: [recorded(1), recorded(4, off=1.0), recorded(1, impossible=1 / 3)]}
    text = report_page(PLAN, {**results, **outcomes}, MACHINE, COMMAND)
    head = next(line for line in text.splitlines() if line.startswith("| blocks |"))
    assert "| covered | off the map | impossible | attempts | paper: RTF |" in head
    assert rows(text)["80 x 80"][11:14] == ["- / 33 %", "- / 11 %", "- / 6"]
    assert "attempts" not in report_page(PLAN, results, MACHINE, COMMAND).lower()


def test_speeds_are_not_compared_with_the_empty_world_if_drives_are_unknown(results: Results) -> None:
    def unknown(one: Outcome) -> Outcome:
        return replace(one, simulated=None, driven=None, stuck=None, tipped=None, covered=None)

    found = {cell: list(map(unknown, outcomes)) for cell, outcomes in results.items()}
    text = report_page(PLAN, found, MACHINE, COMMAND)
    assert rows(text)["80 x 80"][5:11] == ["4.0", "-", "", "", "", ""]
    assert "It was not recorded what the robots did" in text
    assert "was not recorded" not in report_page(PLAN, results, MACHINE, COMMAND)


def test_the_command_that_made_the_page_is_in_it(results: Results) -> None:
    assert f"Made by `{COMMAND}`" in report_page(PLAN, results, MACHINE, COMMAND)


@pytest.mark.parametrize(
    ("row", "sizes"),
    [
        (TableRow(sizes=(0, 10), **SMALL), [0, 10]),
        (TableRow(**LARGE), [0, 20, 40, 60, 80]),
        (TableRow(**PAPER), []),
        (TableRow(recipe=FRAMED, **PAPER), []),
        (TableRow(), []),
        (TableRow(robots=2, **LARGE), []),
        (TableRow(**{**LARGE, "unit_cm": 0.5}), []),
        (TableRow(**{**LARGE, "levels": 3}), []),
        (TableRow(**{**LARGE, "recipe": None}), []),
        (TableRow(**{**LARGE, "recipe": {"boundary": "divided"}}), []),
        (TableRow(**{**LARGE, "recipe": {**FRAMED, "max_step": 1}}), []),
        (TableRow(simulator="sim", **LARGE), []),
        (TableRow(simulator="classic", **LARGE), [0, 20, 40, 60, 80]),
        (
            TableRow(robot="crawler", robots=1, **{**CRAWLED, "maps": "diagonal_barrier"}, sizes=(10,), levels=5),
            [0, 10],
        ),
        (TableRow(robot="crawler", robots=1, **CRAWLED, levels=5), [0, 20]),
        (TableRow(robot="crawler", robots=1, **CRAWLED, levels=10), [0, 40, 60, 80]),
        (TableRow(robot="jackal", **LARGE), []),
    ],
)
def test_the_paper_s_figures_are_for_the_paper_s_robots_and_maps_only(row: TableRow, sizes: list[int]) -> None:
    assert sorted(published_figures(row)) == sizes


def test_a_row_without_an_empty_world_is_held_against_that_of_the_same_robots(results: Results) -> None:
    jackal = replace(PLAN.rows[1], sizes=(20,))
    for number, (robots, found) in enumerate([(3, "0.80"), (2, "-")], 2):
        plan = replace(PLAN, rows=(*PLAN.rows, *[replace(jackal, robots=robots)] * (number - 1)), paces=("free",))
        outcomes = {**results, Cell(row=number, size=20, pace="free"): [outcome(4.0)]}
        assert rows(report_page(plan, outcomes, MACHINE, COMMAND))["20 x 20"][6] == found
        assert "of wall time, at full speed." in report_page(plan, outcomes, MACHINE, COMMAND)


def test_rows_in_two_simulators_are_one_table(results: Results) -> None:
    both = PLAN.in_simulators(["sim", "classic"])
    outcomes = {cell: [outcome(1.0 + cell.row, 0.9)] for cell in both.cells}
    text = report_page(both, outcomes, MACHINE, COMMAND)
    assert text.count("## ") == 2
    assert ", in Gazebo" not in "".join(line for line in text.splitlines() if line.startswith("## "))
    table = [line for line in text.splitlines() if line.startswith("| Gazebo ") and "80 x 80" in line]
    assert [[cell.strip() for cell in line.split("|")[1:10]] for line in table] == [
        ["Gazebo Sim", "80 x 80", "0.80-0.91 (0.90)", "20 % of a core", *COSTS, "1.0 s", "1.0", "1.00"],
        ["Gazebo Classic", "80 x 80", "0.80-0.91 (0.90)", "20 % of a core", *COSTS, "1.0 s", "2.0", "1.00"],
    ]
    assert [line.count(f"| {BURGERS[80].rtf} |") for line in table] == [0, 1]
    assert next(line["simulator"] for line in reading.DictReader(io.StringIO(trials_csv(both, outcomes)))) == "sim"


def test_a_world_in_turns_with_an_empty_one_is_reported_with_its_error(results: Results) -> None:
    def beside(*contact_shares: float) -> str:
        outcomes = [replace(outcome(4.0), share=share) for share in contact_shares]
        text = report_page(PLAN, {**results, Cell(row=0, size=80, pace="beside"): outcomes}, MACHINE, COMMAND)
        return rows(text)["80 x 80"][6]

    assert beside(0.9) == "0.90"
    assert beside(0.8, 0.9, 0.9, 1.0) == f"0.90 ± {sqrt(pi / 2 / 4 * 0.02 / 3):.2f}" == "0.90 ± 0.05"


@pytest.mark.parametrize("pace", ["camera", "window"])
def test_frames_per_second_are_in_a_page_whose_trials_draw_any(results: Results, pace: str) -> None:
    missing = "No window and no camera, so no frames per second."
    assert missing in report_page(PLAN, results, MACHINE, COMMAND)
    page = report_page(replace(PLAN, paces=["real", pace]), results, MACHINE, COMMAND)
    assert missing not in page
    assert "| frames per s |" in page


def test_a_page_of_nothing_yet_has_no_rows_of_figures() -> None:
    assert "10 x 10" not in report_page(PLAN, {}, MACHINE, COMMAND)


def test_the_csv_has_every_trial(results: Results) -> None:
    lines = list(reading.DictReader(io.StringIO(trials_csv(PLAN, results))))
    assert len(lines) == 3 * len(PLAN.cells)
    assert {line["robot"] for line in lines} == {"burger", "jackal"}
    assert {line["row"]: line["robot"] for line in lines} == {"1": "burger", "2": "jackal"}
    cells = [(line["row"], line["size"], line["pace"]) for line in lines]
    assert [line["trial"] for line in lines] == ["0", "1", "2"] * len(dict.fromkeys(cells))
    assert [line["speed"] for line in lines if line["size"] == "80" and line["pace"] == "free"] == ["4.5", "4", "1"]


def test_a_median_ignores_missing_values() -> None:
    assert median_of([outcome(1), outcome(2, 0.5), outcome(9)], "rtf") == 0.5
    assert median_of([outcome(1)], "rtf") is None


@pytest.mark.slow
def test_the_plot_is_a_picture(results: Results) -> None:
    with Image.open(io.BytesIO(plot(PLAN, results))) as picture:
        assert picture.size == (1500, 550)


def test_the_plot_has_no_empty_axes_for_a_real_time_factor_that_was_not_measured(results: Results) -> None:
    quick = {cell: outcomes for cell, outcomes in results.items() if cell.pace == "free"}
    with Image.open(io.BytesIO(plot(replace(PLAN, paces=["free"]), quick))) as picture:
        assert picture.width == 1000


def test_a_plot_of_nothing_yet_is_a_picture() -> None:
    with Image.open(io.BytesIO(plot(PLAN, {}))) as picture:
        assert picture.width == 1500


def test_the_bars_of_the_plot_reach_from_the_least_to_the_most_of_all_trials(
    results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr("rsegen.experiments.report.encoded", lambda figure, _: drawn.append(figure))
    cell = Cell(row=0, size=80, pace="free")
    plot(PLAN, {**results, cell: [outcome(4), outcome(5), outcome(9)]})
    lines = [lines for axes in drawn[0].axes for lines in axes.collections if isinstance(lines, LineCollection)]
    bars = [segment for part in lines for segment in part.get_segments() if abs(segment[0, 0] - 80) < 5]
    assert any(segment[:, 1].tolist() == [4, 9] for segment in bars)
    of_paper = [float(figure) for figure in BURGERS[80].rtf.split("-")]
    assert any(segment[:, 1].tolist() == pytest.approx(of_paper) for segment in bars)
