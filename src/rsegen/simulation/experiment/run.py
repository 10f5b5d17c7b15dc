"""The whole of an experiment: trial by trial, kept as they come, told at the end."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from rsegen.io.writer import write_file
from rsegen.simulation.experiment.machine import description
from rsegen.simulation.experiment.plan import Cell, Plan, Row
from rsegen.simulation.experiment.report import csv, page, plot
from rsegen.simulation.experiment.results import Results, ResultsLog
from rsegen.simulation.experiment.trial import Outcome, run_trial
from rsegen.simulation.simulators import Installation

RESULTS_FILE = "results.jsonl"


def experiment(
    plan: Plan, here: Installation, folder: Path, progress: Callable[[int, Cell], None] = lambda *_: None
) -> Results:
    """Try what has not been tried yet, and write table.md, trials.csv, plot.png and summary.json into the folder.

    `progress` is told how many trials are done, and the cell that is next.
    """
    log = ResultsLog(path=folder / RESULTS_FILE)
    log.begin(asdict(plan))
    done = {(cell, repeat) for cell, repeat, _ in log.entries()}
    machine = {"simulator": str(here), **description()}
    for number, (cell, repeat) in enumerate(plan.order()):
        progress(number, cell)
        if (cell, repeat) not in done:
            log.add(cell, repeat, run_trial(plan, cell, repeat, here))
    results = log.results()
    for name, content in _files(plan, results, machine).items():
        write_file([content], folder / name, force=True)
    return results


def told(summary: Path) -> tuple[Plan, Results, dict[str, str]]:
    """The plan, the outcomes and the machine of a summary.json that `experiment` wrote."""
    said = json.loads(summary.read_text("utf-8"))
    plan = Plan(**{**said["plan"], "rows": tuple(Row(**row) for row in said["plan"]["rows"])})
    results = {
        Cell(row=cell["row"], size=cell["size"], pace=cell["pace"]): [Outcome(**one) for one in cell["outcomes"]]
        for cell in said["cells"]
    }
    return plan, results, said["machine"]


def _files(plan: Plan, results: Results, machine: dict[str, str]) -> dict[str, bytes]:
    cells = [
        {**asdict(cell), "outcomes": [asdict(one) for one in results[cell]]} for cell in plan.cells if cell in results
    ]
    summary = {"machine": machine, "plan": asdict(plan), "cells": cells}
    return {
        "table.md": page(plan, results, machine).encode(),
        "trials.csv": csv(plan, results).encode(),
        "summary.json": json.dumps(summary, indent=2).encode() + b"\n",
        "plot.png": plot(plan, results),
    }
