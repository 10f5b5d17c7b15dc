"""An experiment in a real Gazebo that is killed: no outcome that was measured is measured again, or lost."""

from __future__ import annotations

import json
import random
import shutil
from pathlib import Path

from rsegen.errors import UserError
from rsegen.simulators.server import choose_installation
from tests.crash.killing import ended, kill_after, started

_PLAN = """
name: crash
seconds: 1
repeats: 2
paces: [free]
rows:
  - {robot: burger, robots: 1, sizes: [0, 10]}
"""
_TRIALS = 4
_SECONDS = 20.0
"""About what the plan takes."""


def has_simulator() -> bool:
    """Return whether there is a Gazebo Classic here."""
    try:
        choose_installation("both", "classic")
    except UserError:
        return False
    return True


def experiment_killed(folder: Path, rng: random.Random) -> list[str]:
    """Problems after an experiment is killed at a random moment and then ends."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    plan, output = folder / "plan.yaml", folder / "out"
    plan.write_text(_PLAN, "utf-8")
    command = ["experiment", str(plan)]
    kill_after(started(command, output), rng.uniform(0, _SECONDS), rng)
    measured = _lines(output)
    code, err = ended(started(command, output))
    if code:
        return [f"cannot be continued: {err.strip()[:300]}"]
    problems = [] if _lines(output)[: len(measured)] == measured else ["outcomes of before the kill are lost"]
    trials = [(line["cell"], line["repeat"]) for line in map(json.loads, _lines(output))]
    if len(trials) != _TRIALS or len({json.dumps(one) for one in trials}) != _TRIALS:
        problems.append(f"{len(trials)} outcomes of {_TRIALS} trials")
    expected = {"table.md", "trials.csv", "summary.json", "plot.png", ".rsegen.jsonl", "tracks"}
    found = {path.name for path in output.iterdir()}
    return problems + [f"{name} is missing or left over" for name in sorted(found ^ expected)]


def _lines(output: Path) -> list[str]:
    """The outcomes in the journal, a text each."""
    path = output / ".rsegen.jsonl"
    text = path.read_text("utf-8") if path.is_file() else ""
    lines = map(json.loads, text[: text.rfind("\n") + 1].splitlines())
    return [json.dumps(line["result"]) for line in lines if "result" in line]
