"""Training of a robot to cross rubble: `python -m benchmarks.training`, six minutes on two cores that do nothing else.

PPO of Stable-Baselines3 trains the robot of benchmarks/rover.py on a curriculum, on flat ground alone, and on full
difficulty from the first step, three times each. Then each policy crosses fields of another seed; so do the policy
before any training, and two without a network: full speed ahead, with level and with swinging arms. Kept in
benchmarks/results/training.json; docs/training.md has it. Needs `pip install stable-baselines3 "gymnasium[mujoco]"`,
which brings PyTorch.
"""

from __future__ import annotations

import argparse
import io
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib.metadata import version
from importlib.util import find_spec
from itertools import count, product
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine

FILE = RESULTS / "training.json"
ROVER = Path(__file__).with_name("rover.py")
STEPS = 30 * 2048
SEEDS = (1, 2, 3)
FIELDS = 20
"""Fields per row on which a policy is evaluated."""
POLICIES: Mapping[str, int | None] = {"curriculum": None, "flat": 0, "full": 10}
"""Rows on which a policy is trained."""
TITLES = {
    "curriculum": "trained on the curriculum",
    "full": "trained on full difficulty alone",
    "flat": "trained on flat ground alone",
    "swing": "not learned: full speed, arms swinging by the clock",
    "ahead": "not learned: full speed ahead, arms level",
    "untrained": "untrained: random actions of the same network",
}
ROWS = {0: "flat", 5: "half", 10: "full"}
"""Rows on which policies are evaluated."""
COURSE = 2.8
"""Metres from the start to behind the blocks, LENGTH of rover.py."""
UNSEEN = 8
"""Seed of the recipe of their fields; they were trained with another one."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0, or 1 if a library is missing."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.training", description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, help="how many policies learn at once; default: one per core")
    options = parser.parse_args(arguments)
    if missing := [name for name in ("stable_baselines3", "gymnasium", "mujoco") if not find_spec(name)]:
        print(f"{', '.join(missing)}: not installed; pip install stable-baselines3 'gymnasium[mujoco]'")
        return 1
    libraries = ("stable-baselines3", "torch", "gymnasium", "mujoco")
    record: dict[str, Any] = {"machine": machine(), "versions": {name: version(name) for name in libraries}}
    with ProcessPoolExecutor(options.jobs) as pool:
        record["runs"] = list(pool.map(_run, *zip(*product(TITLES, SEEDS), strict=True)))
    keep(record, FILE)
    print("\n".join(table(record)))
    return 0


def _run(policy: str, seed: int) -> dict[str, Any]:
    """Train a policy and evaluate it; seconds of CPU, the curve, and what it walked on each field of each row."""
    import torch

    from benchmarks.rover import learner

    torch.set_num_threads(1)  # of a process that shares the machine with others
    begin = time.process_time()
    model, curve = learner(POLICIES.get(policy, 0), seed), _Curve()
    if policy in POLICIES:
        model.learn(STEPS, callback=curve)
    seconds = time.process_time() - begin

    def learned(observation: Any, _: int) -> Any:
        return model.predict(observation, deterministic=policy != "untrained")[0]

    act = NOT_LEARNED.get(policy, learned)
    walked = {name: _walked(act, row, seed) for row, name in ROWS.items()}
    return {"policy": policy, "seed": seed, "seconds": seconds, "curve": curve.points, "walked": walked}


def _ahead(_: Any, __: int) -> Any:
    return np.array([1.0, 0, 0, 0])


def _swing(observation: Any, step: int) -> Any:
    """Swing the arms up and down once a second, a quarter of that apart, and steer to the middle."""
    aside, along, across = observation[:3]
    phase = 2 * np.pi * step / 10
    return np.array([1.0, -2 * (np.arctan2(across, along) + aside), np.cos(phase), np.cos(phase + np.pi / 2)])


NOT_LEARNED: Mapping[str, Callable[[Any, int], Any]] = {"swing": _swing, "ahead": _ahead}
"""Policies without a network."""


class _Curve:
    """A callback that keeps the mean row and the mean distance of episodes."""

    def __init__(self) -> None:
        self.points: list[tuple[int, float, float]] = []
        self._seen = 0

    def __call__(self, local: Mapping[str, Any], _: Mapping[str, Any]) -> bool:
        """Look at the episodes since the last point after every 2,048 steps."""
        model = local["self"]
        if model.num_timesteps % 2048 == 0:
            episodes = [episode for env in model.env.envs for episode in env.episodes]
            for env in model.env.envs:
                env.episodes.clear()
            if episodes:
                rows, walked = zip(*episodes, strict=True)
                self.points.append((model.num_timesteps, fmean(rows), fmean(walked)))
        return True


def _walked(act: Callable[[Any, int], Any], row: int, seed: int) -> list[float]:
    """Distances on fields that no policy was trained on, the same for all policies, metres."""
    from benchmarks.rover import ROWS as COUNT
    from benchmarks.rover import RUBBLE, course

    robot = course(replace(RUBBLE, seed=UNSEEN), row)
    for number in range(FIELDS):
        observation, _ = robot.reset(seed=1000 * seed + number, options={"map": row + COUNT * number})
        for step in count():
            observation, _, terminated, truncated, _ = robot.step(act(observation, step))
            if terminated or truncated:
                break
    return [round(walked, 3) for _, walked in robot.episodes]


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The program and the figures, as lines of Markdown."""
    yield f"```python\n{ROVER.read_text('utf-8')}```\n\n## What it learned\n"
    yield "![Distance and difficulty while learning, and then the distance of each policy](pictures/training.png)\n"
    runs = record["runs"]
    yield f"Mean distance in 10 s on {len(runs[0]['walked']['flat'])} fields of a seed that no policy was trained on,"
    seeds = len(_of(runs, "flat"))
    yield f"for each of {seeds} seeds of learning, and the share of fields that it crossed ({COURSE} m):\n"
    yield f"| policy | {' | '.join(ROWS.values())} difficulty |\n|---|{'---|' * len(ROWS)}"
    for policy, title in TITLES.items():
        yield f"| {title} | {' | '.join(_cell(_of(runs, policy), name) for name in ROWS.values())} |"
    seconds = [run["seconds"] for run in runs if run["curve"]]
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    steps = max(run["curve"][-1][0] for run in runs if run["curve"])
    yield f"\n{steps:,} steps of 0.1 s took {min(seconds):.0f} to {max(seconds):.0f} s of CPU per policy; {versions}."
    yield f"Measured by `python -m benchmarks.training` on: {record['machine']}."


def _cell(runs: Sequence[Mapping[str, Any]], row: str) -> str:
    """Return the mean distance of each seed, and the share of all of their fields that were crossed."""
    every = [walked for run in runs for walked in run["walked"][row]]
    means = ", ".join(f"{fmean(run['walked'][row]):.2f}" for run in runs)
    return f"{means} m; {fmean(walked > COURSE for walked in every):.0%}"


def _of(runs: Sequence[Mapping[str, Any]], policy: str) -> list[Mapping[str, Any]]:
    return [run for run in runs if run["policy"] == policy]


def plot(record: Mapping[str, Any]) -> bytes:
    """Draw a PNG: distance and difficulty of the episodes while learning, and afterwards each policy on three rows."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 4.8), dpi=100, layout="constrained")
    walked, row, after = figure.subplots(1, 3, width_ratios=(1, 1, 1.2))
    colours = {policy: f"C{number}" for number, policy in enumerate(TITLES)}
    for run in record["runs"]:
        if run["curve"]:
            steps, rows, distances = np.array(run["curve"]).T
            line = {"color": colours[run["policy"]], "lw": 1.5}
            walked.plot(steps, distances, **line)
            row.plot(steps, rows / max(ROWS), **line)
    walked.set(xlabel="steps", ylabel="distance per episode, at its difficulty [m]", ylim=(0, None))
    row.set(xlabel="steps", ylabel="difficulty of the episodes", ylim=(-0.03, 1.03))
    width = 0.8 / len(TITLES)
    for number, (policy, title) in enumerate(TITLES.items()):
        means = np.array(
            [[fmean(run["walked"][name]) for name in ROWS.values()] for run in _of(record["runs"], policy)]
        )
        places = np.arange(len(ROWS)) + (number - (len(TITLES) - 1) / 2) * width
        after.bar(places, means.mean(axis=0), width * 0.9, color=colours[policy], alpha=0.6, label=title)
        after.plot(places, means.T, "k.", ms=5)
    after.set_xticks(range(len(ROWS)), [f"{name} difficulty" for name in ROWS.values()])
    after.set(ylabel="distance on unseen fields [m]")
    figure.legend(loc="outside lower center", ncols=3)
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()


if __name__ == "__main__":
    sys.exit(main())
