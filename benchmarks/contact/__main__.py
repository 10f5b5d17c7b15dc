"""`python -m benchmarks.contact`: tries every construction and writes benchmarks/results/contact.md and .json.

With `--simulator sim` it does so in Gazebo Sim, and writes contact-sim.md and .json.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.contact.constructions import ALL, Construction
from benchmarks.contact.report import strayed, table, write
from benchmarks.contact.trial import Trial, tried
from rsegen.errors import SimulatorFailed
from rsegen.simulators.base import SIMULATORS, Installation

RESULTS = Path(__file__).parents[1] / "results"
NO_GAZEBO = 3
"""Exit code."""
SEEDS = (1, 2)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0, or 3 where the simulator is not installed."""
    options = _options(arguments)
    simulator = SIMULATORS[options.simulator]
    gazebo = simulator.installation()
    if not gazebo:
        print(f"no {simulator.title} here: run scripts/gazebo-{options.simulator}", file=sys.stderr)
        return NO_GAZEBO
    chosen = [each for each in ALL if (each.name in options.only if options.only else each.quick or not options.quick)]
    trials, lost = _trials(
        chosen,
        _plan(chosen, SEEDS[:1] if options.quick else SEEDS),
        gazebo,
        options.results,
    )
    print(table(trials, chosen, lost, gazebo))
    return 0


def _plan(chosen: Sequence[Construction], seeds: Sequence[int]) -> list[tuple[Construction, int]]:
    """The most telling constructions on every field, then the others on the first."""
    telling = [(each, seed) for seed in seeds for each in chosen if each.quick]
    return telling + [(each, seeds[0]) for each in chosen if not each.quick]


def _trials(
    chosen: Sequence[Construction], plan: Sequence[tuple[Construction, int]], gazebo: Installation, folder: Path
) -> tuple[list[Trial], list[str]]:
    """All that were done, also where they are interrupted; results are written after each."""
    trials: list[Trial] = []
    lost: list[str] = []
    try:
        for each, seed in plan:
            _report(each, seed, gazebo, trials, lost)
            write(trials, chosen, lost, gazebo, folder)
    except KeyboardInterrupt:
        lost.append("Interrupted: not every construction was tried on every field.")
        write(trials, chosen, lost, gazebo, folder)
    return trials, lost


def _report(each: Construction, seed: int, gazebo: Installation, trials: list[Trial], lost: list[str]) -> None:
    """Try one and say so."""
    began = time.monotonic()
    try:
        trial = tried(each, seed, gazebo)
    except SimulatorFailed as error:
        lost.append(f"Lost: {each.name} on field {seed}.")
        print(f"{each.name}, field {seed}: lost: {error}", file=sys.stderr)
        return
    trials.append(trial)
    seconds = time.monotonic() - began
    print(f"{each.name}, field {seed}: {strayed([trial]):.2f} mm aside, {seconds:.0f} s", file=sys.stderr)
    for line in trial.errors:
        print(line, file=sys.stderr)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact", description=__doc__)
    parser.add_argument("--simulator", choices=list(SIMULATORS), default="classic")
    parser.add_argument("--quick", action="store_true", help="the most telling constructions on one field")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=[each.name for each in ALL], help="only these")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FOLDER")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
