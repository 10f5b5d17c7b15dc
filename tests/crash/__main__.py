"""python -m tests.crash: kills runs and fills disks at random moments, and says what was lost."""

from __future__ import annotations

import argparse
import json
import platform
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.crash.commands import RUNS
from tests.crash.experiment import experiment_killed, has_simulator
from tests.crash.trials import Files, can_mount, killed, on_a_full_disk


def main() -> int:
    """Run it; 1 if anything was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--disks", type=int, default=20)
    parser.add_argument("--experiments", type=int, default=4, help="kills of an experiment in a real Gazebo")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the result into this JSON file")
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}", flush=True)
    rng, counts = random.Random(arguments.seed), Counter[str]()  # noqa: S311  # moments, not secrets
    with tempfile.TemporaryDirectory(prefix="rsegen-crash-") as folder:
        lost = [*_trials(Path(folder), arguments, rng, counts)]
    print(f"{dict(counts)}: {len(lost)} problems")
    if arguments.record:
        found = {"python": platform.python_version(), "seed": arguments.seed, **counts, "problems": len(lost)}
        arguments.record.write_text(json.dumps(found, indent=2) + "\n", "utf-8")
    return bool(lost)


def _trials(folder: Path, arguments: argparse.Namespace, rng: random.Random, counts: Counter[str]) -> list[str]:
    """What is wrong, a line each."""
    problems: list[str] = []
    wholes: dict[str, Files] = {}
    seconds: dict[str, float] = {}
    for run in RUNS:
        run.whole(folder / "whole")  # so that the next one is timed with all in memory
        start = time.monotonic()
        wholes[run.name] = run.whole(folder / "whole")
        seconds[run.name] = time.monotonic() - start
    disks = arguments.disks if can_mount(folder / "disk") else 0
    if not disks and arguments.disks:
        print("no full disks: this user may not mount a disk in memory")
    experiments = arguments.experiments if has_simulator() else 0
    if not experiments and arguments.experiments:
        print("no experiment is killed: there is no Gazebo Classic")
    for kind, number in (("kills", arguments.kills), ("disks", disks), ("experiments", experiments)):
        for trial in range(number):
            run, counts[kind] = RUNS[trial % len(RUNS)], counts[kind] + 1
            if kind == "kills":
                found = killed(run, folder / "out", wholes[run.name], seconds[run.name], rng)
            elif kind == "disks":
                found = on_a_full_disk(run, folder / "disk", wholes[run.name], rng)
            else:
                found = experiment_killed(folder / "experiment", rng)
            name = "experiment" if kind == "experiments" else run.name
            problems += [f"{kind} {trial} ({name}): {line}" for line in found[:3]]
            print("".join(f"\r{line}\n" for line in problems[-len(found[:3]) :] if found), end="", flush=True)
            print(f"\r{kind} {trial + 1} of {number}, {len(problems)} problems", end="", file=sys.stderr)
    print(file=sys.stderr)
    return problems


sys.exit(main())
