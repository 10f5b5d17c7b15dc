"""Gymnasium's Ant learns to walk on blocks: `python -m benchmarks.ant_on_blocks`, a quarter of an hour on 16 cores.

PPO of Stable-Baselines3 trains Ant-v5 with its own rewards, on another field of low blocks at each reset, whose heights
around it it sees. Then policies walk on fields of another seed: trained, and the same network untrained. Kept in
benchmarks/results/ant.json; docs/learned.md has it. Needs `pip install stable-baselines3 "gymnasium[mujoco]"`.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from statistics import fmean, median
from typing import Any

from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine
from rsegen.driving.many import wilson

FILE = RESULTS / "ant.json"
FAR = 3.0
"""The way, metres, that counts as far: 2 m of it are on blocks."""
FIELDS = 100
"""Of the evaluation."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ant_on_blocks", description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=900, help="of training")
    parser.add_argument("--jobs", type=int, default=12, help="processes that simulate")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, default=FILE)
    options = parser.parse_args(arguments)
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

    torch.set_num_threads(2)
    record: dict[str, Any] = {"machine": machine(), "seed": options.seed, "curve": []}
    libraries = ("stable-baselines3", "gymnasium", "torch", "mujoco")
    record["versions"] = {name: version(name) for name in libraries}
    raw = SubprocVecEnv([_made(31)] * options.jobs, start_method="spawn")
    raw.seed(options.seed)
    worlds = VecNormalize(raw, clip_obs=10.0)
    network = {"net_arch": [256, 128], "log_std_init": -0.7}
    model = PPO(
        "MlpPolicy", worlds, n_steps=512, batch_size=1024, n_epochs=6, learning_rate=3e-4, gamma=0.99,
        ent_coef=0.0, policy_kwargs=network, seed=options.seed, device="cpu",
    )  # fmt: skip
    untrained = {name: part.clone() for name, part in model.policy.state_dict().items()}
    watch = _Watch(options.seconds, record["curve"])
    model.learn(10**9, callback=watch)
    worlds.training = False
    record["walked"] = {"trained": _walked(model, worlds)}
    model.policy.load_state_dict(untrained)
    record["walked"]["untrained"] = _walked(model, worlds)
    worlds.close()
    keep(record, options.output)
    print("\n".join(table(record)))
    return 0


def _made(seed: int) -> Callable[[], Any]:
    from benchmarks.ant import AntOnBlocks

    return partial(AntOnBlocks, seed)


class _Watch:
    """A callback that keeps a row for each update, and ends the training after some seconds."""

    def __init__(self, seconds: float, curve: list[dict[str, float]]) -> None:
        self._curve, self._begin, self._seconds = curve, time.monotonic(), seconds
        self._x: list[float] = []
        self._touches = self._steps = 0

    def __call__(self, local: Mapping[str, Any], _: Mapping[str, Any]) -> bool:
        """Look at each step of all processes."""
        for info, done in zip(local["infos"], local["dones"], strict=True):
            self._touches += info["touches"] > 0
            if done:
                self._x.append(info["x_position"])
        self._steps += 1
        passed = time.monotonic() - self._begin
        if self._steps == 512:
            row = {"seconds": round(passed, 1), "steps": local["self"].num_timesteps, "episodes": len(self._x)}
            row |= {"x": round(fmean(self._x), 3) if self._x else 0.0, "touching_steps": self._touches}
            self._curve.append(row)
            print(json.dumps(row), flush=True)
            self._x, self._touches, self._steps = [], 0, 0
        return passed < self._seconds


def _walked(model: Any, worlds: Any) -> dict[str, Any]:
    """On fields of another seed: how far the Ant gets in an episode, metres, and how often it touches blocks."""
    env, ways, touching = _made(32)(), [], []
    for field in range(FIELDS):
        observation, _ = env.reset(seed=1000 + field)
        touches, is_over, is_late = 0, False, False
        while not (is_over or is_late):
            action, _ = model.predict(worlds.normalize_obs(observation), deterministic=True)
            observation, _, is_over, is_late, info = env.step(action)
            touches += info["touches"] > 0
        ways.append(round(float(info["x_position"]), 3))
        touching.append(touches)
    return {"metres": ways, "touching_steps": touching}


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures, as lines of Markdown."""
    yield f"| policy | way in 25 s: mean, median | farther than {FAR:g} m | fields on which it touched blocks |"
    yield "|---|---|---|---|"
    for policy, found in record["walked"].items():
        ways, touching = found["metres"], found["touching_steps"]
        far = sum(way > FAR for way in ways)
        low, high = wilson(far, len(ways))
        touched = sum(count > 0 for count in touching)
        share = f"{far} of {len(ways)} ({low:.0%}-{high:.0%})"
        yield f"| {policy} | {fmean(ways):.2f} m, {median(ways):.2f} m | {share} | {touched} of {len(ways)} |"
    last = record["curve"][-1]
    yield f"\n{last['steps']:,} steps in {last['seconds'] / 60:.0f} minutes; while learning, episodes got from"
    yield f"{record['curve'][0]['x']:.2f} m to {last['x']:.2f} m, in the mean."
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    yield f"Measured by `python -m benchmarks.ant_on_blocks` on: {record['machine']}; {versions}."


if __name__ == "__main__":
    sys.exit(main())
