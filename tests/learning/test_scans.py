"""Scans have the errors that a sensor is given, and no others: in numpy, torch and jax, and in compiled functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Ground, Random, Recipe
from rsegen.errors import ParameterError
from rsegen.learning.patterns import scan_points
from rsegen.learning.scans import ScanSensor

RECIPE = Recipe(seed=7, chunk_size=30, unit_cm=5, boundary="none", obstacles=[Random(levels=6)])
WORLDS = 40
LEVELS = rsegen.build_many(RECIPE, range(WORLDS))
GROUND = Ground(RECIPE, LEVELS)
PATTERN = scan_points((0.8, 0.6), 0.1)
POSES = np.random.default_rng(1).uniform((-1, -1, 0.3, -3), (1, 1, 0.6, 3), (WORLDS, 4))
TRUE = GROUND.scan(PATTERN, POSES)


def _seen(sensor: ScanSensor, times: int = 1, seed: int = 0) -> np.ndarray:
    """Points that are seen at a number of calls from the same poses, (times, WORLDS, points)."""
    state, rng, seen = sensor.start(GROUND, POSES), np.random.default_rng(seed), []
    for _ in range(times):
        own, state = sensor.sense(GROUND, POSES, state, rng)
        seen.append(own)
    return np.array(seen)


def test_a_sensor_without_errors_gives_the_scan() -> None:
    assert np.array_equal(_seen(ScanSensor(pattern=PATTERN), 3), [TRUE] * 3)
    assert ScanSensor().pattern.shape == scan_points().shape


def test_noise_has_its_deviation_and_is_independent() -> None:
    errors = _seen(ScanSensor(pattern=PATTERN, noise=0.02), 20) - TRUE
    assert errors.std() == pytest.approx(0.02, rel=0.02)
    assert abs(errors.mean()) < 0.0005
    assert abs(np.corrcoef(errors[0].ravel(), errors[1].ravel())[0, 1]) < 0.1
    same = _seen(ScanSensor(pattern=PATTERN, noise=0.02), 20) - TRUE
    assert np.array_equal(errors, same)
    assert not np.array_equal(errors, _seen(ScanSensor(pattern=PATTERN, noise=0.02), 20, seed=1) - TRUE)


def test_heights_are_the_nearest_multiples_of_a_step() -> None:
    (seen,) = _seen(ScanSensor(pattern=PATTERN, step=0.03))
    assert np.allclose(seen / 0.03, np.rint(seen / 0.03))
    assert 0.0145 < np.abs(seen - TRUE).max() <= 0.015 + 1e-9


def test_a_share_of_the_rays_is_lost() -> None:
    seen = _seen(ScanSensor(pattern=PATTERN, dropout=0.2, lost=-9.0), 20)
    assert (seen == -9).mean() == pytest.approx(0.2, rel=0.03)
    assert np.array_equal(seen[seen != -9], np.broadcast_to(TRUE, seen.shape)[seen != -9])


def test_a_late_scan_is_the_one_of_before_in_every_world() -> None:
    sensor, rng = ScanSensor(pattern=PATTERN, delay=3), np.random.default_rng(0)
    ways = [POSES + np.array([0.02 * step, 0, 0, 0]) for step in range(8)]
    state, seen = sensor.start(GROUND, ways[0]), []
    for poses in ways:
        own, state = sensor.sense(GROUND, poses, state, rng)
        seen.append(own)
    expected = [GROUND.scan(PATTERN, ways[max(step - 3, 0)]) for step in range(8)]
    assert np.array_equal(seen, expected)
    assert not np.array_equal(expected[-1], TRUE)


def test_a_map_drifts_farther_and_farther_and_as_a_whole() -> None:
    sensor, rng = ScanSensor(pattern=PATTERN, drift=0.01), np.random.default_rng(0)
    flat = Ground(RECIPE, np.zeros_like(LEVELS))
    state, apart = sensor.start(flat, POSES), []
    for _ in range(100):
        seen, state = sensor.sense(flat, POSES, state, rng)
        assert np.ptp(seen, axis=1).max() < 1e-12  # level ground is level, and the map is too high or too low
        assert seen[:, 0] == pytest.approx(-POSES[:, 2] - state.drift[:, 2])
        apart.append(state.drift)
    spread = np.array(apart).std(axis=(1, 2))
    assert spread[99] == pytest.approx(0.1, rel=0.2)
    assert spread[24] == pytest.approx(0.05, rel=0.25)
    moved = POSES + np.column_stack([state.drift, np.zeros(WORLDS)])
    state = sensor.start(GROUND, POSES)._replace(drift=state.drift)
    seen, _ = ScanSensor(pattern=PATTERN).sense(GROUND, POSES, state, rng)
    assert np.array_equal(seen, GROUND.scan(PATTERN, moved))


def test_places_of_whole_numbers_drift_by_the_same_as_others() -> None:
    sensor = ScanSensor(pattern=PATTERN, drift=0.01)
    drifts = []
    for poses in (np.zeros((WORLDS, 4), dtype=int), np.zeros((WORLDS, 4))):
        state, rng = sensor.start(GROUND, poses), np.random.default_rng(0)
        for _ in range(20):
            _, state = sensor.sense(GROUND, poses, state, rng)
        drifts.append(state.drift)
    assert np.array_equal(*drifts)
    assert 0.02 < drifts[0].std() < 0.07


def test_robots_that_begin_anew_forget_what_was() -> None:
    sensor, rng = ScanSensor(pattern=PATTERN, delay=2, drift=0.05), np.random.default_rng(0)
    state = sensor.start(GROUND, POSES)
    for _ in range(5):
        _, state = sensor.sense(GROUND, POSES, state, rng)
    others = POSES[::-1]
    is_new = np.arange(WORLDS) % 3 == 0
    after = sensor.restart(state, is_new, sensor.start(GROUND, others))
    assert np.array_equal(after.scans[:, is_new], [GROUND.scan(PATTERN, others)[is_new]] * 3)
    assert not after.drift[is_new].any()
    assert np.array_equal(after.scans[:, ~is_new], state.scans[:, ~is_new])
    assert np.array_equal(after.drift[~is_new], state.drift[~is_new])


ALL = ScanSensor(pattern=PATTERN, noise=0.01, step=0.005, dropout=0.1, delay=2, drift=0.002, lost=-7.0)


def _check_all(seen: list[Any]) -> None:
    """The figures of `ALL`, after the delay."""
    late = np.array([np.asarray(own) for own in seen])[2:]
    assert (late == -7).mean() == pytest.approx(0.1, rel=0.1)
    kept = late[late > -7]
    assert np.abs(kept / 0.005 - np.rint(kept / 0.005)).max() < 1e-3
    errors = (late - TRUE)[late > -7]
    assert 0.01 < np.median(np.abs(errors)) * 1.48 < 0.02
    assert len(np.unique(late, axis=0)) == len(late)


@pytest.mark.slow
def test_torch_gives_the_same_errors_on_the_device_of_the_ground() -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    ground, poses = Ground(RECIPE, torch.as_tensor(LEVELS)), torch.as_tensor(POSES.astype(np.float32))
    sensor = replace(ALL, pattern=torch.as_tensor(PATTERN))
    state, random, seen = sensor.start(ground, poses), torch.Generator().manual_seed(3), []
    for _ in range(10):
        own, state = sensor.sense(ground, poses, state, random)
        assert own.dtype == torch.float32
        seen.append(own)
    _check_all(seen)
    after = ALL.restart(state, torch.as_tensor(np.arange(WORLDS) < 3), ALL.start(ground, poses))
    assert not after.drift[:3].any()
    assert torch.equal(after.drift[3:], state.drift[3:])
    for mask in (np.arange(WORLDS) < 3, [robot < 3 for robot in range(WORLDS)]):  # as environments give it
        same = ALL.restart(state, mask, ALL.start(ground, poses))
        assert all(torch.equal(*pair) for pair in zip(same, after, strict=True))
    with pytest.raises(ParameterError, match="random: 3 is no Generator of torch, and the arrays are of torch"):
        sensor.sense(ground, poses, state, 3)


@pytest.mark.slow
def test_jax_compiles_a_sensor_once() -> None:
    jax = pytest.importorskip("jax", reason="jax is not installed")
    ground, poses = Ground(RECIPE, jax.numpy.asarray(LEVELS)), jax.numpy.asarray(POSES.astype(np.float32))
    traces = []

    @jax.jit  # type: ignore[untyped-decorator]  # jax is not here when types are checked
    def sensed(poses: Any, state: Any, key: Any) -> Any:
        traces.append(1)
        return ALL.sense(ground, poses, state, key)

    state, seen = ALL.start(ground, poses), []
    for key in jax.random.split(jax.random.key(5), 10):
        own, state = sensed(poses, state, key)
        seen.append(own)
    assert len(traces) == 1
    _check_all(seen)
    after = ALL.restart(state, np.arange(WORLDS) < 3, ALL.start(ground, poses))
    assert isinstance(after.scans, jax.Array)
    assert not np.asarray(after.drift)[:3].any()
    assert np.array_equal(after.drift[3:], state.drift[3:])
    with pytest.raises(ParameterError, match="random: an empty value is no key of jax, and the arrays are of jax"):
        ALL.sense(ground, poses, state, None)


def test_what_no_sensor_has_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"dropout: 1.5 is outside 0..1"):
        ScanSensor(dropout=1.5)
    with pytest.raises(ParameterError, match=r"delay: 0.5 is not a whole number"):
        ScanSensor(delay=0.5)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"pattern: of shape \(3,\); expected \(points, 2\)"):
        ScanSensor(pattern=np.zeros(3))
    sensor = ScanSensor(noise=0.1)
    with pytest.raises(ParameterError, match="random: 3 is no Generator of numpy, and the arrays are of numpy"):
        sensor.sense(GROUND, POSES, sensor.start(GROUND, POSES), 3)
    with pytest.raises(ParameterError, match=r"poses: of shape \(40, 3\); expected \(..., 4\)"):
        sensor.start(GROUND, POSES[:, :3])
    with pytest.raises(ParameterError, match="state: of 1 scans for a delay of 2; use that of `start`"):
        replace(sensor, delay=2).sense(GROUND, POSES, sensor.start(GROUND, POSES), np.random.default_rng(0))
    state = sensor.start(GROUND, POSES)
    with pytest.raises(ParameterError, match=r"is_new: of shape \(3,\); expected \(40,\), one for each robot"):
        sensor.restart(state, [True, False, True], state)
    with pytest.raises(ParameterError, match=r"state: of robots of shape \(40,\); the poses are of \(3,\)"):
        sensor.sense(GROUND, POSES[:3], state, np.random.default_rng(0))
    with pytest.raises(
        ParameterError, match=r"poses: of shape \(40, 7\); expected \(..., 4\), of which the last is the yaw"
    ):
        sensor.sense(GROUND, np.zeros((40, 7)), state, np.random.default_rng(0))
    with pytest.raises(ParameterError, match="state: of 187 points for a pattern of 3; use that of `start`"):
        replace(sensor, pattern=np.zeros((3, 2))).sense(GROUND, POSES, state, np.random.default_rng(0))
    with pytest.raises(ParameterError, match="lost: 'far' is not a number, in metres"):
        ScanSensor(lost="far")  # type: ignore[arg-type]
