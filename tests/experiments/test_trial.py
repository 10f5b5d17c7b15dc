"""Report of a trial on its server: how often it was started, and whether it had the processors that it would use."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from rsegen.errors import SimulatorFailed
from rsegen.experiments import trial
from rsegen.experiments.plan import Cell, ExperimentPlan, TableRow
from rsegen.experiments.run import journal_entry, read_outcome
from rsegen.experiments.trial import BEHIND, STARVED, Outcome, Trial, is_starved, run_trial
from rsegen.experiments.trial_server import Measurement
from rsegen.scene.scene import compose
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.server import ATTEMPTS, attempted

CLASSIC = Installation(simulator=SIMULATORS["classic"], version="11", commands={})
PLAN = ExperimentPlan(name="p", rows=(TableRow(sizes=(10,), robots=1),), paces=("free",), repeats=1)
OUTCOME = Outcome(load=1.0, memory=2.0, cpu=0.07, speed=3.0, rtf_min=None, rtf=None, rtf_max=None, starved=True)


class Failing:
    """Fails so many times before it gives a result."""

    def __init__(self, failures: int) -> None:
        self.left, self.calls = failures, 0

    def __call__(self, *_: Any, **__: Any) -> Any:
        self.calls += 1
        if self.calls <= self.left:
            raise SimulatorFailed("the server has died")
        return "result"


@pytest.mark.parametrize("failures", range(ATTEMPTS))
def test_attempts_are_counted(failures: int) -> None:
    once = Failing(failures)
    assert attempted(once) == ("result", failures + 1)
    assert once.calls == failures + 1


def test_the_last_failure_says_how_many_there_were() -> None:
    once = Failing(ATTEMPTS)
    with pytest.raises(SimulatorFailed, match=r"^the server has died; this was attempt 4 of 4$"):
        attempted(once)
    assert once.calls == ATTEMPTS


def test_no_other_error_is_another_attempt() -> None:
    def once() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        attempted(once)


def test_a_trial_has_its_attempts_and_they_come_back_from_a_journal(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = Failing(2)

    def once(plan: ExperimentPlan, cell: Cell, seed: int, *_: Any) -> Trial:
        failing()
        return Trial(outcome=OUTCOME, scene=compose(plan.rows[cell.row].map_of(cell.size, seed)), trajectories={})

    monkeypatch.setattr(trial, "_trial", once)
    outcome = run_trial(PLAN, PLAN.cells[0], 0, CLASSIC).outcome
    assert outcome.attempts == 3
    assert read_outcome(journal_entry(PLAN.cells[0], 0, outcome)["outcome"]) == outcome


def span(cpu: float, simulated: float, real: float = 10.0) -> Measurement:
    return Measurement(simulated=simulated, real=real, cpu=cpu, busy=real, frames=0, factors=[1.0], gpu=[])


@pytest.mark.parametrize(
    ("cpu", "simulated", "real", "starved"),
    [
        (0.7, 1.0, False, True),  # 7 % of a core, a simulated second
        (4.9, 50.0, False, True),
        (5.1, 50.0, False, False),  # half a processor and more at full speed
        (11.0, 100.0, False, False),
        (2.0, 10.0, True, False),  # keeps up with a fifth of a processor
        (2.0, 8.9, True, True),  # would use more, and has it not
        (10.0, 3.0, True, False),  # a heavy map, on a processor of its own
    ],
)
def test_a_server_is_starved_if_it_would_use_more_and_has_less_than_half_a_processor(
    cpu: float, simulated: float, real: bool, starved: bool
) -> None:
    assert is_starved(span(cpu, simulated), real=real) == starved
    assert (STARVED, BEHIND) == (0.5, 0.9)


def test_outcomes_of_earlier_versions_are_read() -> None:
    old = {"load": 1.0, "memory": 2.0, "cpu": None, "speed": 3.0}
    found = read_outcome(old)
    assert found == replace(OUTCOME, cpu=None, starved=None)
