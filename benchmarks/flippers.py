"""Training of a crawler to use its flippers: `python -m benchmarks.flippers`, on a GPU an hour, without one days.

PPO of rsl_rl, the trainer of mjlab and Isaac Lab, drives rsegen's crawler over fields of 2 x 1 m in thousands of worlds
of mujoco_warp: with flippers that it moves, and with flippers that are held as `rsegen drive` holds them. Then each
policy crosses fields of another seed, from easy to hard; so do the policy before any training, and straight driving.
Kept in benchmarks/results/flippers.json; docs/training.md has it. Needs `pip install rsl-rl-lib mujoco-warp`.

--policy and --seed do one of the runs, and -o keeps it in a file; --record puts such files together.
"""

from __future__ import annotations

import argparse
import io
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import rsegen
from benchmarks.figures import RESULTS, keep, record_in
from benchmarks.machine import machine
from rsegen.driving.many import wilson
from rsegen.training.crossing import Crossing

FILE = RESULTS / "flippers.json"
ROWS = 5
RUBBLE = rsegen.Recipe(
    name="rubble",
    seed=11,
    unit_cm=5,
    chunks=(2, 1),
    chunk_size=10,
    boundary="none",
    maps=20_000,
    difficulty=(0.34, 1, ROWS),  # blocks up to 10, 15, 20, 25 and 30 cm
    obstacles=[rsegen.Random(levels=7)],
)
HIGHEST = (10, 15, 20, 25, 30)
"""Of each row, cm."""
UNSEEN = 12
"""Seed of the recipe of the fields of the evaluation."""
FIELDS = 2560
"""Of them."""
JUDGED = 200
"""Fields on which a learned policy is judged in MuJoCo once more."""
TITLES = {
    "moved": "learned, flippers moved",
    "held": "learned, flippers held",
    "straight": "not learned: straight ahead at half speed, flippers held",
    "untrained": "untrained: the same network, flippers moved",
}
SEEDS = (1, 2)
_STEPS = 24
"""Periods of each world between two updates of PPO."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0, or 1 if a library is missing."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.flippers", description=__doc__.splitlines()[0])
    parser.add_argument("--policy", choices=TITLES, help="one of the policies; default: all")
    parser.add_argument("--seed", type=int, help="one of the seeds; default: all")
    parser.add_argument("--seconds", type=float, default=900, help="of training, for each run")
    parser.add_argument("--worlds", type=int, default=4096)
    parser.add_argument("--fields", type=int, default=FIELDS, help="of the evaluation")
    parser.add_argument("--device", default="cuda:0")
    parser.add_argument("-o", "--output", type=Path, default=FILE, help="file of the runs")
    parser.add_argument("--record", nargs="+", type=Path, help="put the runs of these files together")
    options = parser.parse_args(arguments)
    if options.record:
        parts = [record_in(path) for path in options.record]
        record = parts[0] | {"runs": [run for part in parts for run in part["runs"]]}
    else:
        if missing := [name for name in ("rsl_rl", "torch", "mujoco_warp") if not find_spec(name)]:
            print(f"{', '.join(missing)}: not installed; pip install rsl-rl-lib mujoco-warp")
            return 1
        libraries = ("rsl-rl-lib", "torch", "mujoco-warp", "warp-lang")
        record = {"machine": f"{device_name(options.device)}; {machine()}"}
        record |= {"versions": {name: version(name) for name in libraries}, "runs": []}
        for policy in [options.policy] if options.policy else TITLES:
            for seed in [options.seed] if options.seed else SEEDS:
                record["runs"].append(_run(policy, seed, options))
                keep(record, options.output)
    keep(record, options.output)
    print("\n".join(table(record)))
    return 0


def device_name(name: str) -> str:
    """The name of a GPU, for records."""
    import torch

    return torch.cuda.get_device_name(name) if name.startswith("cuda") else "no GPU"


def settings(seed: int) -> dict[str, Any]:
    """The settings of rsl_rl: those that mjlab has for its robots, with a longer way of looking ahead."""
    network = {
        "class_name": "MLPModel",
        "hidden_dims": (256, 128, 64),
        "activation": "elu",
        "obs_normalization": True,
    }
    return {
        "seed": seed,
        "num_steps_per_env": _STEPS,
        "save_interval": 10**9,
        "obs_groups": {"actor": ["policy"], "critic": ["policy"]},
        "actor": network
        | {"distribution_cfg": {"class_name": "GaussianDistribution", "init_std": 0.6, "std_type": "scalar"}},
        "critic": dict(network),
        "algorithm": {
            "class_name": "PPO",
            "num_learning_epochs": 5,
            "num_mini_batches": 4,
            "learning_rate": 1e-3,
            "schedule": "adaptive",
            "gamma": 0.99,
            "lam": 0.95,
            "entropy_coef": 0.003,
            "desired_kl": 0.01,
            "max_grad_norm": 1.0,
            "value_loss_coef": 1.0,
            "use_clipped_value_loss": True,
            "clip_param": 0.2,
            "rnd_cfg": None,
            "symmetry_cfg": None,
        },
    }


def _run(policy: str, seed: int, options: argparse.Namespace) -> dict[str, Any]:
    """Train a policy and evaluate it: the curve, and of each row how many fields were crossed of how many."""
    import torch
    from rsl_rl.runners import OnPolicyRunner

    from rsegen.training.worlds import CrossingWorlds

    torch.manual_seed(seed)
    moves, device = policy in ("moved", "untrained"), options.device
    crossing = Crossing(recipe=RUBBLE, robot="crawler", uses_flippers=moves)
    worlds = CrossingWorlds(crossing, options.worlds, device=device, maps=RUBBLE.maps, seed=seed)
    act: Callable[[Any], Any] = _straight
    curve: list[dict[str, float]] = []
    seconds = 0.0
    if policy != "straight":
        runner = OnPolicyRunner(worlds, settings(seed), log_dir=None, device=device)
        if policy != "untrained":
            begin = time.monotonic()
            watch = _Curve(worlds, curve, begin)
            while time.monotonic() - begin < options.seconds:
                runner.learn(1)
                runner.current_learning_iteration += 1
                watch.add()
            seconds = time.monotonic() - begin
            torch.save(runner.alg.get_policy().state_dict(), options.output.with_suffix(f".{policy}.{seed}.pt"))
        act = runner.get_inference_policy(device)
    unseen = replace(crossing, recipe=replace(RUBBLE, seed=UNSEEN))
    count = min(options.fields, options.worlds)
    fresh = CrossingWorlds(unseen, count, device=device, maps=count, seed=1000 + seed)
    crossed = evaluated(fresh, act)
    run = {"policy": policy, "seed": seed, "seconds": seconds, "curve": curve, "crossed": crossed}
    return run | {"in_mujoco": judged(unseen, act)} if curve else run


def _straight(observation: Any) -> Any:
    """Half speed, east: the heading is seen as sine and cosine before the place, and the last action behind it."""
    import torch

    seen = observation["policy"]
    heading = torch.atan2(seen[:, -5], seen[:, -4])
    return torch.stack([torch.full_like(heading, 0.5), (-2 * heading).clamp(-1, 1)], -1)


class _Curve:
    """Keeps, after each update, what became of the episodes that have ended since, by wrapping the worlds' step."""

    def __init__(self, worlds: Any, curve: list[dict[str, float]], begin: float) -> None:
        self._curve, self._begin = curve, begin
        self._ended = self._across = self._touched = 0
        step = worlds.step

        def watched(actions: Any) -> Any:
            found = step(actions)
            ended = worlds.ended
            is_over = ended["is_across"] | ended["has_failed"] | ended["is_late"]
            self._ended += is_over.sum()
            self._across += ended["is_across"].sum()
            self._touched += (is_over & (ended["touched"] > 0)).sum()
            return found

        worlds.step = watched

    def add(self) -> None:
        """Add a row of the curve, if episodes have ended."""
        ended, across, touched = int(self._ended), int(self._across), int(self._touched)
        if ended:
            row = {"seconds": round(time.monotonic() - self._begin, 1), "ended": ended, "across": across}
            self._curve.append(row | {"touched": touched})
            self._ended = self._across = self._touched = 0
            if len(self._curve) % 10 == 1:
                print(f"{row['seconds']:.0f} s: {across} of {ended} crossed, {touched} touched blocks", flush=True)


def evaluated(worlds: Any, act: Callable[[Any], Any]) -> dict[str, list[int]]:
    """Of each row, by its number: how many of the first episodes crossed, of how many, and how many touched blocks."""
    import torch

    count = worlds.num_envs
    worlds.begin(torch.arange(count, device=worlds.device), torch.arange(count, device=worlds.device))
    is_open = torch.ones(count, dtype=torch.bool, device=worlds.device)
    crossed, touched = torch.zeros_like(is_open), torch.zeros_like(is_open)
    seen = worlds.get_observations()
    with torch.inference_mode():
        for _ in range(worlds.max_episode_length):
            seen, *_ = worlds.step(act(seen))
            ended = worlds.ended
            crossed |= is_open & ended["is_across"]
            touched |= is_open & (ended["touched"] > 0)
            is_open &= ~(ended["is_across"] | ended["has_failed"] | ended["is_late"])
    rows = torch.arange(count, device=worlds.device) % ROWS
    return {
        str(row): [int(crossed[rows == row].sum()), int((rows == row).sum()), int(touched[rows == row].sum())]
        for row in range(ROWS)
    }


def judged(crossing: Crossing, act: Callable[[Any], Any]) -> dict[str, list[int]]:
    """The same of other fields in one world of MuJoCo, of 64 bits, whose contacts are found by other code."""
    import torch

    from rsegen.training.gymnasium import CrossingEnv

    env = CrossingEnv(crossing)
    counts = {str(row): [0, 0, 0] for row in range(ROWS)}
    for field in range(FIELDS, FIELDS + JUDGED):
        seen, _ = env.reset(seed=field, options={"map": field})
        touched = is_over = is_late = False
        while not (is_over or is_late):
            with torch.inference_mode():
                action = act({"policy": torch.as_tensor(seen)[None]})[0]
            seen, _, is_over, is_late, info = env.step(action.cpu().numpy())
            touched |= info["touches"] > 0
        row = counts[str(field % ROWS)]
        row[:] = row[0] + info["is_across"], row[1] + 1, row[2] + touched
    return counts


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures, as lines of Markdown."""
    runs = record["runs"]
    yield f"| policy | {' | '.join(f'up to {highest} cm' for highest in HIGHEST)} | all |"
    yield f"|---|{'---|' * (ROWS + 1)}"
    for policy, title in TITLES.items():
        own = [run for run in runs if run["policy"] == policy]
        if own:
            cells = [_cell([run["crossed"][str(row)] for run in own]) for row in range(ROWS)]
            every = [counts for run in own for counts in run["crossed"].values()]
            yield f"| {title} | {' | '.join(cells)} | {_cell(every)} |"
        if again := [run["in_mujoco"] for run in own if "in_mujoco" in run]:
            cells = [_cell([counts[str(row)] for counts in again]) for row in range(ROWS)]
            every = [counts for found in again for counts in found.values()]
            yield f"| the same in one world of MuJoCo | {' | '.join(cells)} | {_cell(every)} |"
    seeds = sorted({run["seed"] for run in runs})
    touched = [counts for run in runs for counts in run["crossed"].values()]
    yield ""
    yield "Of the fields of a seed that no policy was trained on, the share that was crossed within 20 s, its 95 %"
    yield f"interval and the count, over the seeds of learning {', '.join(map(str, seeds))}; robots touched blocks in"
    yield f"{sum(counts[2] for counts in touched):,} of {sum(counts[1] for counts in touched):,} of these episodes."
    learned = [run for run in runs if run["curve"]]
    if learned:
        episodes = sum(row["ended"] for run in learned for row in run["curve"])
        seconds = max(run["seconds"] for run in learned)
        yield f"{episodes:,} episodes in {len(learned)} runs of {seconds:.0f} s at most."
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    yield f"Measured by `python -m benchmarks.flippers` on: {record['machine']}; {versions}."


def _cell(counts: Sequence[Sequence[int]]) -> str:
    crossed, of = sum(count[0] for count in counts), sum(count[1] for count in counts)
    low, high = wilson(crossed, of)
    return f"{crossed / of:.0%} ({low:.0%}-{high:.0%}; {crossed} of {of})"


def plot(record: Mapping[str, Any]) -> bytes:
    """Draw a PNG: the share of episodes that cross while learning, and of unseen fields by their highest blocks."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.2), dpi=100, layout="constrained")
    learning, after = figure.subplots(1, 2)
    colours = {policy: f"C{number}" for number, policy in enumerate(TITLES)}
    for run in record["runs"]:
        if run["curve"]:
            minutes = [row["seconds"] / 60 for row in run["curve"]]
            shares = [row["across"] / row["ended"] for row in run["curve"]]
            learning.plot(minutes, shares, color=colours[run["policy"]], lw=1.5)
    learning.set(xlabel="minutes of learning", ylabel="share of episodes across", ylim=(0, 1))
    for policy, title in TITLES.items():
        own = [run for run in record["runs"] if run["policy"] == policy]
        for number, run in enumerate(own):
            shares = [run["crossed"][str(row)][0] / run["crossed"][str(row)][1] for row in range(ROWS)]
            label = title if number == 0 else None
            after.plot(HIGHEST, shares, "o-", color=colours[policy], lw=1.5, ms=4, label=label)
    after.set(xlabel="highest blocks [cm]", ylabel="share of unseen fields crossed", ylim=(0, 1))
    figure.legend(loc="outside lower center", ncols=2)
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()


if __name__ == "__main__":
    sys.exit(main())
