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
from collections.abc import Mapping, Sequence
from pathlib import Path

from docs.records import today
from tests.crash.commands import RUNS
from tests.crash.disks import DISKS, NotMounted
from tests.crash.experiment import experiment_killed, has_simulator
from tests.crash.injection import missing
from tests.crash.running import OWN, OWN_ASIDE, Problem, Tried, numbers, run


def main() -> int:
    """Run trials; 1 if anything was lost."""
    arguments = _parser().parse_args()
    print(f"seed {arguments.seed}", flush=True)
    if why := missing():
        print(f"no trials: {why}")
        return 2
    tried, skipped = _trials(arguments)
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
        _record(arguments.record, arguments.seed, tried, skipped)
        if experiments:
            kills = {"seed": arguments.seed, "tried": experiments, "failed": len(lost)}
            _update(arguments.record, "experiments", {"date": today(), **kills})
    return bool(problems)


def _trials(arguments: argparse.Namespace) -> tuple[list[Tried], dict[str, str]]:
    """Make the trials on each disk; with them come the disks that cannot be mounted, with the reasons."""
    alone, tried, skipped = arguments.number, list[Tried](), dict[str, str]()
    disks = [disk for disk in DISKS if arguments.disks in disk.name and (arguments.mounted or alone is not None)]
    own = [None] if arguments.disks in f"{OWN}; {OWN_ASIDE}" else []
    for disk in (*own, *disks):
        trials = arguments.mounted if disk else arguments.trials
        those = numbers(trials, arguments.only) if alone is None else [alone]
        try:
            tried += run(arguments.seed, those, arguments.processes, _Said(arguments.seed, len(those)), disk)
        except NotMounted as error:
            skipped[disk.name if disk else OWN] = str(error)
            print(f"\rno trials on {disk.name if disk else OWN}: {error}")
    return tried, skipped


def _record(file: Path, seed: int, tried: Sequence[Tried], skipped: Mapping[str, str]) -> None:
    """Write how many trials there were, and after how many something is wrong, by disk and what happens, into a file.

    What it has of other disks stays.
    """
    for disk in dict.fromkeys(each.disk for each in tried):
        counts: dict[str, dict[str, int]] = {}
        for each in (each for each in tried if each.disk == disk):
            count = counts.setdefault(each.kind, {"tried": 0, "failed": 0})
            count["tried"] += 1
            count["failed"] += bool(each.problems)
        commands = len({run.name.split()[0].strip(",") for run in RUNS})
        made = {"date": today(), "seed": seed, "commands": commands, "counts": counts}
        _update(file, "disks", {disk: made})
    _update(file, "skipped", skipped)


def _update(file: Path, name: str, values: Mapping[str, object]) -> None:
    """Change values of one of the objects of a JSON file, which is made if it does not exist."""
    content = json.loads(file.read_text("utf-8")) if file.exists() else {}
    content |= {"python": platform.python_version(), name: {**content.get(name, {}), **values}}
    file.write_text(json.dumps(content, indent=2) + "\n", "utf-8")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.crash", description=__doc__)
    parser.add_argument("--trials", type=int, default=500, help="how many (default: 500)")
    seed = random.SystemRandom().randrange(10**6)
    parser.add_argument("--seed", type=int, default=seed, help="of the trials (default: drawn and printed)")
    parser.add_argument("--mounted", type=int, default=100, help="how many on each other disk (default: 100)")
    parser.add_argument("--number", type=int, help="only this trial of the seed")
    parser.add_argument("--disks", default="", metavar="TEXT", help="only disks with this text in their names")
    parser.add_argument("--only", default="", metavar="TEXT", help="only commands with this text in their names")
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1), help="at the same time")
    parser.add_argument("--experiments", type=int, default=0, help="kills of an experiment in a real Gazebo")
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="write the results into this JSON file, in place of those on the same disks",
    )
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
    """Problems after an experiment in a real Gazebo was killed."""
    rng, lost = random.Random(seed), []  # noqa: S311  # moments, not secrets
    with tempfile.TemporaryDirectory(prefix="rsegen-crash-") as folder:
        for trial in range(kills):
            lost += [f"experiment {trial}: {line}" for line in experiment_killed(Path(folder) / "experiment", rng)]
    for line in lost:
        print(line)
    return lost


if __name__ == "__main__":
    sys.exit(main())
