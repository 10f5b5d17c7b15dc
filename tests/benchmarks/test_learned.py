"""Records of robots that learned on blocks: they touched them, the records add up, and the page has the figures."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from benchmarks import ant_on_blocks, flippers, go1_on_blocks, many_worlds
from rsegen.driving.many import wilson


def _record(module: Any) -> dict[str, Any]:
    return dict(json.loads(module.FILE.read_text("utf-8")))


def _crossed(policy: str, part: str = "crossed") -> tuple[int, int]:
    """Number of fields that were crossed, and of all, over all rows and seeds."""
    runs = [run[part] for run in _record(flippers)["runs"] if run["policy"] == policy]
    counts = [row for run in runs for row in run.values()]
    return sum(row[0] for row in counts), sum(row[1] for row in counts)


@pytest.mark.parametrize("part", ["crossed", "in_mujoco"])
def test_a_crawler_that_moves_its_flippers_crosses_more_than_one_that_holds_them(part: str) -> None:
    moved, held = _crossed("moved", part), _crossed("held", part)
    assert moved[1] == held[1] >= 200
    assert wilson(*moved)[0] > wilson(*held)[1]
    touched = [row[1:] for run in _record(flippers)["runs"] if part in run for row in run[part].values()]
    assert all(of == some for of, some in touched), "all touched blocks"


def test_the_curves_of_the_crawler_rise() -> None:
    for run in _record(flippers)["runs"]:
        if run["curve"]:
            shares = [row["across"] / row["ended"] for row in run["curve"]]
            assert np.mean(shares[-5:]) > np.mean(shares[:5]) + 0.3


def test_the_ant_gets_farther_over_blocks_that_it_touches() -> None:
    walked = _record(ant_on_blocks)["walked"]
    far = {policy: sum(way > ant_on_blocks.FAR for way in found["metres"]) for policy, found in walked.items()}
    assert wilson(far["trained"], 100)[0] > wilson(far["untrained"], 100)[1]
    assert all(count > 0 for count in walked["trained"]["touching_steps"])


def test_robots_of_mjlab_touched_blocks() -> None:
    for rows in _record(go1_on_blocks)["walked"].values():
        touched = [row["touched"] / row["robots"] for number, row in rows.items() if number != "0"]
        assert min(touched) > 0.3
        assert rows["0"]["touched"] < rows["5"]["touched"]


def test_many_worlds_are_near_one() -> None:
    found = _record(many_worlds)["robots"]["crawler"]
    own, many = (np.array(across) for across in found["across"])
    assert found["lanes"] == len(own) == len(many)
    assert 0.9 < (own == many).mean() <= 1
    assert found["apart"][1][0] < 0.001, "metres after a second, in the median"


@pytest.mark.parametrize("module", [ant_on_blocks, flippers, go1_on_blocks, many_worlds])
def test_tables_have_a_cell_under_each_head(module: Any) -> None:
    rows = [line.count("|") for line in module.table(_record(module)) if line.startswith("|")]
    assert len(rows) >= 3
    assert all(count >= 3 for count in rows)


@pytest.mark.slow
def test_the_ant_sees_and_touches_blocks_under_it() -> None:
    pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    from benchmarks.ant import MIDDLE, PATTERN, AntOnBlocks

    env = AntOnBlocks(3)
    observation, _ = env.reset(seed=1)
    data = env.unwrapped.data  # type: ignore[attr-defined]
    z = data.qpos[2]
    is_before_the_field = PATTERN[:, 0] < 0.8
    assert observation[-len(PATTERN) :][is_before_the_field] == pytest.approx(-z)
    data.qpos[:3] = MIDDLE, 0, 1.0
    touches = 0
    for _ in range(60):
        observation, *_, info = env.step(np.zeros(8))
        touches += info["touches"]
    assert touches > 10
    assert np.ptp(observation[-len(PATTERN) :]) > 0.03
