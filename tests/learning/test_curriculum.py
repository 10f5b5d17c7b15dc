"""The next row of each robot, by the rule of legged_gym: up beyond half a tile, else down, random after the last."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rsegen import next_rows
from rsegen.errors import ParameterError

ROWS = np.array([0, 3, 3, 3, 9, 0])
WALKED = np.array([4.1, 4.1, 3.9, 1.0, 4.1, 0.5])
COMMANDED = np.array([20.0, 0.0, 7.0, 7.0, 20.0, 20.0])


def test_robots_go_up_down_or_stay() -> None:
    after = next_rows(ROWS, WALKED, COMMANDED, count=10, length=8.0, rng=np.random.default_rng(1))
    assert after[[0, 1, 2, 3, 5]].tolist() == [1, 4, 3, 2, 0]
    assert 0 <= after[4] < 10


def test_robots_that_solved_the_last_row_are_spread_over_all_rows() -> None:
    last, far = np.full(5000, 9), np.full(5000, 5.0)
    after = next_rows(last, far, far, count=10, length=8.0, rng=np.random.default_rng(1))
    assert np.bincount(after, minlength=10) == pytest.approx(np.full(10, 500), abs=90)
    assert np.array_equal(after, next_rows(last, far, far, count=10, length=8.0, rng=np.random.default_rng(1)))


@pytest.mark.parametrize("kind", ["int8", "uint8", "int64", "uint32"])
def test_robots_stay_in_the_first_row_whatever_sort_of_integers_rows_are(kind: str) -> None:
    first = np.zeros(50, dtype=kind)
    after = next_rows(first, 0 * first, 1.0, count=10, length=8.0, rng=np.random.default_rng(1))
    assert (after == 0).all()
    assert after.dtype == kind


@pytest.mark.parametrize("name", ["torch", "jax.numpy"])
def test_torch_and_jax_agree_with_numpy(name: str) -> None:
    library = pytest.importorskip(name, reason=f"{name} is not installed")
    given = [library.asarray(values) for values in (ROWS, WALKED, COMMANDED)]
    after = next_rows(*given, count=10, length=8.0, rng=np.random.default_rng(1))
    expected = next_rows(ROWS, WALKED, COMMANDED, count=10, length=8.0, rng=np.random.default_rng(1))
    assert type(after) is type(given[0])
    assert np.asarray(after).tolist() == expected.tolist()


def test_rows_that_are_no_integers_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"rows: float64 of shape \(6,\); expected integers, one per robot"):
        next_rows(WALKED, WALKED, COMMANDED, count=10, length=8.0, rng=np.random.default_rng(1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"walked": WALKED[:1]}, r"walked: of shape \(1,\) for 6 robots; expected one for each"),
        ({"commanded": COMMANDED[:, None]}, r"commanded: of shape \(6, 1\) for 6 robots; expected one for each"),
        ({"walked": np.array(["far"] * 6)}, "walked: of <U3; expected metres"),
        ({"count": 0}, "count: 0 is not 1 or more"),
        ({"length": np.nan}, "length: nan is not a finite number"),
        ({"rng": 7}, "rng: 7 is no Generator of numpy, and the arrays are of numpy"),
    ],
)
def test_values_that_decide_no_row_are_refused(change: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"walked": WALKED, "commanded": COMMANDED, "count": 10, "length": 8.0}
    with pytest.raises(ParameterError, match=message):
        next_rows(ROWS, **(given | {"rng": np.random.default_rng(1)} | change))


def test_one_command_is_that_of_all_robots() -> None:
    one, each = (
        next_rows(ROWS, WALKED, commanded, count=10, length=8.0, rng=np.random.default_rng(1))
        for commanded in (7.0, np.full(6, 7.0))
    )
    assert one.tolist() == each.tolist()


@pytest.mark.slow
def test_torch_draws_rows_by_its_own_generator() -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    last, far = torch.full((5000,), 9), torch.full((5000,), 5.0)
    after, again = (
        next_rows(last, far, far, count=10, length=8.0, rng=torch.Generator().manual_seed(3)) for _ in range(2)
    )
    assert after.dtype == torch.int64
    assert np.bincount(after.numpy(), minlength=10) == pytest.approx(np.full(10, 500), abs=90)
    assert torch.equal(after, again)


@pytest.mark.slow
def test_jax_draws_other_rows_by_each_key_in_a_compiled_function() -> None:
    jax = pytest.importorskip("jax", reason="jax is not installed")
    last, far = jax.numpy.full(5000, 9), jax.numpy.full(5000, 5.0)

    def drawn(rows: Any, rng: Any) -> Any:
        return next_rows(rows, far, far, count=10, length=8.0, rng=rng)

    compiled = jax.jit(drawn)
    first, second = (np.asarray(compiled(last, key)) for key in jax.random.split(jax.random.key(3)))
    for after in (first, second):
        assert np.bincount(after, minlength=10) == pytest.approx(np.full(10, 500), abs=90)
    assert (first == second).mean() < 0.2
    with pytest.raises(ParameterError, match="rng: a Generator of numpy draws only once in what jax compiles"):
        jax.jit(lambda rows: drawn(rows, np.random.default_rng(1)))(last)
