"""mjlab's Unitree Go1 learns to walk on step fields: `python -m benchmarks.go1_on_blocks`, on a GPU.

The task, the rewards and PPO are mjlab's own (Mjlab-Velocity-Rough-Unitree-Go1, rsl_rl); its terrain alone is rsegen's,
four columns of random blocks in a curriculum of rows. Then policies walk on a terrain of other seeds: the trained one,
and the same network untrained. What touches blocks is counted in MuJoCo's contacts. Kept in
benchmarks/results/go1.json; docs/learned.md has it. Needs `pip install mjlab`.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import rsegen
from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine
from rsegen.driving.many import wilson

FILE = RESULTS / "go1.json"
TASK = "Mjlab-Velocity-Rough-Unitree-Go1"
ROWS, COLUMNS, SIDE = 6, 4, 6.0
"""Of the terrain, and metres of a tile."""
HIGHEST = 12
"""Of the last row, cm; the first one is flat."""
SPEED, SECONDS = 0.6, 10.0
"""Of the evaluation: m/s ahead, and how long."""


def rubble(seed: int) -> rsegen.Recipe:
    """4.8 x 4.8 m of blocks of 40 cm, amid level ground."""
    return rsegen.Recipe(
        name="rubble",
        seed=seed,
        unit_cm=4,
        block_width_cm=40,
        chunk_size=12,
        boundary="none",
        obstacles=[rsegen.Random(levels=4)],
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.go1_on_blocks", description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=1200, help="of training")
    parser.add_argument("--worlds", type=int, default=4096)
    parser.add_argument("--walkers", type=int, default=1536, help="robots of the evaluation")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--device", default="cuda:0")
    parser.add_argument("-o", "--output", type=Path, default=FILE)
    options = parser.parse_args(arguments)
    import torch

    from benchmarks.flippers import device_name

    libraries = ("mjlab", "rsl-rl-lib", "torch", "mujoco-warp")
    record: dict[str, Any] = {"machine": f"{device_name(options.device)}; {machine()}", "seed": options.seed}
    record["versions"] = {name: version(name) for name in libraries}
    worlds = _worlds(options.worlds, 21, options)
    runner = _runner(worlds, options)
    untrained = {name: part.clone() for name, part in runner.alg.get_policy().state_dict().items()}
    record["curve"], begin = [], time.monotonic()
    while time.monotonic() - begin < options.seconds:
        runner.learn(5)
        runner.current_learning_iteration += 1
        record["curve"].append(_row(worlds, runner, time.monotonic() - begin))
        keep(record, options.output)
    worlds.close()
    fresh = _worlds(options.walkers, 22, options, seconds=SECONDS)
    act = runner.get_inference_policy(options.device)
    record["walked"] = {"trained": _walked(fresh, act)}
    with torch.inference_mode():  # in which it has been used
        runner.alg.get_policy().load_state_dict(untrained)
    record["walked"]["untrained"] = _walked(fresh, act)
    keep(record, options.output)
    print("\n".join(table(record)))
    return 0


def _worlds(count: int, seed: int, options: argparse.Namespace, seconds: float | None = None) -> Any:
    """mjlab's environment on rsegen's terrain, as rsl_rl takes it; with seconds: of an evaluation, which ends then."""
    import mjlab.tasks.velocity.config.go1  # noqa: F401  # it brings the task
    from mjlab.envs import ManagerBasedRlEnv
    from mjlab.rl import RslRlVecEnvWrapper
    from mjlab.tasks.registry import load_env_cfg
    from mjlab.terrains.terrain_generator import TerrainGeneratorCfg

    from rsegen.learning.mjlab import columns

    settings = load_env_cfg(TASK)
    settings.scene.terrain.terrain_generator = TerrainGeneratorCfg(
        curriculum=True, size=(SIDE, SIDE), border_width=10.0, num_rows=ROWS, num_cols=COLUMNS, seed=seed,
        sub_terrains=columns([rubble(seed)], COLUMNS),
    )  # fmt: skip
    settings.scene.num_envs, settings.seed = count, options.seed
    if seconds is not None:
        settings.episode_length_s = 2 * seconds
        settings.curriculum = {}
        settings.scene.terrain.max_init_terrain_level = None
        twist = settings.commands["twist"]
        twist.ranges.lin_vel_x, twist.ranges.lin_vel_y, twist.ranges.ang_vel_z = (SPEED, SPEED), (0, 0), (0, 0)
        twist.rel_standing_envs = twist.rel_heading_envs = 0.0
        del settings.events["push_robot"]
    return RslRlVecEnvWrapper(ManagerBasedRlEnv(cfg=settings, device=options.device))


def _runner(worlds: Any, options: argparse.Namespace) -> Any:
    from mjlab.rl import MjlabOnPolicyRunner
    from mjlab.tasks.registry import load_rl_cfg

    settings = asdict(load_rl_cfg(TASK)) | {"seed": options.seed}
    return MjlabOnPolicyRunner(worlds, settings, log_dir=None, device=options.device)


def _row(worlds: Any, runner: Any, seconds: float) -> dict[str, float]:
    """A row of the curve: the mean row of the curriculum, and what robots touch now."""
    blocks, ground = _touched(worlds)
    row = {
        "seconds": round(seconds, 1),
        "iterations": runner.current_learning_iteration,
        "row": round(float(worlds.unwrapped.scene.terrain.terrain_levels.float().mean()), 3),
        "on_blocks": int(blocks.sum()),
        "on_ground": int(ground.sum()),
    }
    print(json.dumps(row), flush=True)
    return row


def _touched(worlds: Any) -> tuple[Any, Any]:
    """The contacts of each robot with blocks of rsegen's and with level ground, (worlds,)."""
    import torch

    simulation = worlds.unwrapped.sim
    model, contact = simulation.mj_model, simulation.data.contact
    terrain = model.body("terrain").id
    top = model.geom_pos[:, 2] + model.geom_size[:, 2]
    kind = np.where(model.geom_bodyid != terrain, 0, np.where(top > 1e-3, 1, 2))
    kinds = torch.as_tensor(kind, device=worlds.device)
    count = int(simulation.data.nacon[0])
    pairs, owners = contact.geom[:count].long(), contact.worldid[:count].long()
    own = kinds[pairs].amax(dim=-1)
    is_of_robot = (kinds[pairs] == 0).any(dim=-1)
    found = []
    for wanted in (1, 2):
        touches = torch.zeros(worlds.num_envs, dtype=torch.long, device=worlds.device)
        found.append(touches.index_add_(0, owners, ((own == wanted) & is_of_robot).long()))
    return found[0], found[1]


def _walked(worlds: Any, act: Any) -> dict[str, Any]:
    """Of each row: robots, those that did not fall, those that touched blocks, and the median of their ways, metres."""
    import torch

    environment = worlds.unwrapped
    with torch.inference_mode():  # in which it may have been used
        seen, _ = worlds.reset()
    terrain, robot = environment.scene.terrain, environment.scene["robot"]
    rows = terrain.terrain_levels.clone()
    begin = robot.data.root_link_pos_w[:, :2].clone()
    is_up = torch.ones(worlds.num_envs, dtype=torch.bool, device=worlds.device)
    walked, has_touched = torch.zeros(worlds.num_envs, device=worlds.device), torch.zeros_like(is_up)
    with torch.inference_mode():
        for _ in range(round(SECONDS / environment.step_dt)):
            before = robot.data.root_link_pos_w[:, :2].clone()
            seen, _, done, extras = worlds.step(act(seen))
            is_down = (done > 0) & ~extras["time_outs"].bool()
            walked = torch.where(is_up, (before - begin).norm(dim=-1), walked)
            has_touched |= is_up & (_touched(worlds)[0] > 0)
            is_up &= ~is_down
            # One that has left the terrain begins anew; it has not fallen, and its way ends there.
            begin = torch.where(((done > 0) & is_up)[:, None], robot.data.root_link_pos_w[:, :2], begin)
    found = {}
    for row in range(ROWS):
        own = rows == row
        found[str(row)] = {
            "robots": int(own.sum()),
            "up": int((own & is_up).sum()),
            "touched": int((own & has_touched).sum()),
            "metres": round(float(walked[own].median()), 2) if own.any() else 0.0,
        }
    return found


def table(record: Mapping[str, Any]) -> Iterator[str]:
    """The figures, as lines of Markdown."""
    yield f"| policy | {' | '.join(f'up to {HIGHEST * row / (ROWS - 1):.3g} cm' for row in range(ROWS))} |"
    yield f"|---|{'---|' * ROWS}"
    for policy, rows in record["walked"].items():
        yield f"| {policy} | {' | '.join(_cell(rows[str(row)]) for row in range(ROWS))} |"
    last = record["curve"][-1]
    blocks, ground, minutes = last["on_blocks"], last["on_ground"], last["seconds"] / 60
    yield f"\nShare of robots that are up after {SECONDS:g} s at {SPEED} m/s, its 95 % interval, their count, and"
    yield f"the median way, on a terrain of other seeds, after {last['iterations']} updates in {minutes:.0f} minutes."
    yield f"At their end the mean row of the curriculum was {last['row']}, and {blocks:,} contacts were with blocks,"
    touched = [row for rows in record["walked"].values() for key, row in rows.items() if key != "0"]
    some, robots = sum(row["touched"] for row in touched), sum(row["robots"] for row in touched)
    yield f"{ground:,} with level ground. On rows with blocks {some:,} of {robots:,} robots touched some."
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    yield f"Measured by `python -m benchmarks.go1_on_blocks` on: {record['machine']}; {versions}."


def _cell(row: Mapping[str, Any]) -> str:
    if not row["robots"]:
        return ""
    low, high = wilson(row["up"], row["robots"])
    return (
        f"{row['up'] / row['robots']:.0%} ({low:.0%}-{high:.0%}; {row['up']} of {row['robots']}), {row['metres']:.2g} m"
    )


if __name__ == "__main__":
    sys.exit(main())
