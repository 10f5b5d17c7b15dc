"""python -m tests.crash: disturbs every command that writes at random calls, and says what was lost."""

from __future__ import annotations

import argparse
import json
import os
import platform
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from tests.crash.commands import RUNS
from tests.crash.disks import DISKS, NotMounted
from tests.crash.experiment import experiment_killed, has_simulator
from tests.crash.injection import missing
from tests.crash.running import Problem, Tried, numbers, run


def main() -> int:
    """Run trials; 1 if anything was lost."""
    arguments = _parser().parse_args()
    print(f"seed {arguments.seed}", flush=True)
    if why := missing():
        print(f"no trials: {why}")
        return 2
    those = [arguments.number] if arguments.number is not None else numbers(arguments.trials, arguments.only)
    tried = run(arguments.seed, those, arguments.processes, _Said(arguments.seed, len(those)))
    few = those if arguments.number is not None else numbers(arguments.mounted, arguments.only)
    skipped = {}
    for disk in DISKS if few else ():
        try:
            tried += run(arguments.seed, few, arguments.processes, _Said(arguments.seed, len(few)), disk)
        except NotMounted as error:
            skipped[disk.name] = str(error)
            print(f"\rno trials on {disk.name}: {error}")
    print(file=sys.stderr)
    experiments = arguments.experiments if has_simulator() else 0
    if not experiments and arguments.experiments:
        print("no experiment is killed: there is no Gazebo Classic")
    lost = _experiments(experiments, arguments.seed)
    found = [problem for each in tried for problem in each.problems]
    for (command, kind, name), count in sorted(Counter((each.run, each.kind, each.disk) for each in found).items()):
        print(f"{count} problems: {command}, {kind}, {name}")
    problems = len(found) + len(lost)
    print(f"{len(tried)} trials, {experiments} kills of an experiment: {problems} problems")
    if arguments.record:
        record = {
            "python": platform.python_version(),
            "seed": arguments.seed,
            "commands": len({run.name.split()[0].strip(",") for run in RUNS}),
            "counts": _counts(tried),
            "skipped": skipped,
            "experiments": experiments,
            "problems": problems,
        }
        arguments.record.write_text(json.dumps(record, indent=2) + "\n", "utf-8")
    return bool(problems)


def _counts(tried: Sequence[Tried]) -> dict[str, dict[str, dict[str, int]]]:
    """How many trials there were, and after how many something is wrong, by what happens and by disk."""
    counts: dict[str, dict[str, dict[str, int]]] = {}
    for each in tried:
        count = counts.setdefault(each.kind, {}).setdefault(each.disk, {"tried": 0, "failed": 0})
        count["tried"] += 1
        count["failed"] += bool(each.problems)
    return counts


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.crash", description=__doc__)
    parser.add_argument("--trials", type=int, default=500, help="how many (default: 500)")
    seed = random.SystemRandom().randrange(10**6)
    parser.add_argument("--seed", type=int, default=seed, help="of the trials (default: drawn and printed)")
    parser.add_argument("--mounted", type=int, default=100, help="how many on each other disk (default: 100)")
    parser.add_argument("--number", type=int, help="only this trial of the seed")
    parser.add_argument("--only", default="", metavar="TEXT", help="only commands with this text in their names")
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1), help="at the same time")
    parser.add_argument("--experiments", type=int, default=0, help="kills of an experiment in a real Gazebo")
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the result into this JSON file")
    return parser


class _Said:
    """Prints the problems of each trial, and how to repeat it."""

    def __init__(self, seed: int, trials: int) -> None:
        self._seed, self._trials = seed, trials

    def __call__(self, done: int, new: Sequence[Problem]) -> None:
        """Hear of a trial."""
        for problem in new[:3]:
            print(f"\r{problem}")
        if new:
            print(f"  again: python -m tests.crash --seed {self._seed} --number {new[0].number}", flush=True)
        print(f"\r{done} of {self._trials}", end="", file=sys.stderr)


def _experiments(kills: int, seed: int) -> list[str]:
    """What is wrong after an experiment in a real Gazebo was killed."""
    rng, lost = random.Random(seed), []  # noqa: S311  # moments, not secrets
    with tempfile.TemporaryDirectory(prefix="rsegen-crash-") as folder:
        for trial in range(kills):
            lost += [f"experiment {trial}: {line}" for line in experiment_killed(Path(folder) / "experiment", rng)]
    for line in lost:
        print(line)
    return lost


if __name__ == "__main__":
    sys.exit(main())
