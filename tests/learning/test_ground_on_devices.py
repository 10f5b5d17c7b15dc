"""The ground on a device: compiled functions trace once, and no question waits for a number or sends one there."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Ground, Random, Recipe, ScanSensor, next_rows
from tests.support.late_import import LateImport

jax = LateImport("jax", reason="jax is not installed")
torch = LateImport("torch", reason="PyTorch is not installed: it is a download of gigabytes")

RECIPE = Recipe(
    seed=7,
    chunk_size=6,
    chunks=(1, 2),
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    obstacles=[Random(levels=6)],
)
POS = (1.0, 2.0, 0.5)
WORLDS = 5
LEVELS = rsegen.build_many(RECIPE, range(WORLDS))
OTHERS = rsegen.build_many(RECIPE, range(50, 52))
SOME = [3, 1]

pytestmark = pytest.mark.slow

Question = Callable[[Ground, Any, Any], Any]
QUESTIONS: dict[str, Question] = {
    "heights": lambda ground, feet, _: ground.heights(feet),
    "friction": lambda ground, feet, _: ground.friction(feet),
    "acting friction": lambda ground, feet, _: ground.acting_friction(feet, 0.7, priority=10),
    "highest": lambda ground, feet, _: ground.highest(feet, 0.17),
    "normals": lambda ground, feet, _: ground.normals(feet, 0.2),
    "lift": lambda ground, feet, _: ground.lift(feet, 0.03),
    "lift of some": lambda ground, feet, some: ground.lift(feet[: len(SOME)], 0.03, worlds=some),
    "scan": lambda ground, feet, _: ground.scan(feet[0, :6, :2], feet.reshape(WORLDS, -1)[:, :4]),
}


def _feet(seed: int) -> np.ndarray:
    points = np.random.default_rng(seed).uniform((0.5, 1.2, 0.3), (1.5, 2.8, 0.9), (WORLDS, 8, 3))
    return points.astype(np.float32)


def _expected(question: Question, levels: np.ndarray, seed: int) -> Any:
    return question(Ground(RECIPE, levels, POS), _feet(seed), SOME)


def _changed() -> np.ndarray:
    levels = LEVELS.copy()
    levels[SOME] = OTHERS
    return levels


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS.keys())
def test_jax_traces_once_and_transfers_nothing(question: Question) -> None:
    jnp = jax.numpy

    traces = []

    @jax.jit  # type: ignore[untyped-decorator]  # jax is not here when types are checked
    def answers(levels: Any, feet: Any, some: Any) -> Any:
        traces.append(1)
        return question(Ground(RECIPE, levels, POS), feet, some)

    maps = (LEVELS, _changed())
    given = [(jnp.asarray(maps[seed]), jnp.asarray(_feet(seed)), jnp.asarray(SOME)) for seed in range(2)]
    answers(*given[0]).block_until_ready()
    with jax.transfer_guard("disallow"):
        found = [answers(*each) for each in given]
    assert len(traces) == 1
    for seed, levels in enumerate(maps):
        assert np.asarray(found[seed]) == pytest.approx(_expected(question, levels, seed), abs=1e-5)


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS.keys())
def test_jax_asks_a_ground_that_was_made_before_without_transfers(question: Question) -> None:
    jnp = jax.numpy

    ground = Ground(RECIPE, jnp.asarray(LEVELS), POS)
    traces = []

    @jax.jit  # type: ignore[untyped-decorator]  # jax is not here when types are checked
    def answers(feet: Any, some: Any) -> Any:
        traces.append(1)
        return question(ground, feet, some)

    given = [(jnp.asarray(_feet(seed)), jnp.asarray(SOME)) for seed in range(2)]
    answers(*given[0]).block_until_ready()
    with jax.transfer_guard("disallow"):
        found = [answers(*each) for each in given]
    assert len(traces) == 1
    assert np.asarray(found[1]) == pytest.approx(_expected(question, LEVELS, 1), abs=1e-5)


def test_jax_maps_worlds_and_writes_maps_in_a_compiled_function() -> None:
    jnp = jax.numpy

    def of_one(levels: Any, feet: Any) -> Any:
        return Ground(RECIPE, levels, POS).lift(feet, 0.03)

    @jax.jit  # type: ignore[untyped-decorator]  # jax is not here when types are checked
    def written(levels: Any, others: Any, some: Any, feet: Any) -> Any:
        ground = Ground(RECIPE, levels, POS)
        ground.write(others, some)
        return ground.heights(feet)

    found = jax.jit(jax.vmap(of_one))(jnp.asarray(LEVELS), jnp.asarray(_feet(0)))
    assert np.asarray(found) == pytest.approx(Ground(RECIPE, LEVELS, POS).lift(_feet(0), 0.03), abs=1e-5)
    found = written(jnp.asarray(LEVELS), jnp.asarray(OTHERS), jnp.asarray(SOME), jnp.asarray(_feet(1)))
    assert np.asarray(found) == pytest.approx(Ground(RECIPE, _changed(), POS).heights(_feet(1)), abs=1e-5)


@pytest.mark.filterwarnings("ignore")  # torch's own
def test_torch_compiles_new_starts_of_sensors_and_new_rows_as_one_graph() -> None:
    # Before those that count: torch's compiler does not know functions that were replaced when it began.
    sensor, ground, poses = ScanSensor(delay=1), Ground(RECIPE, torch.as_tensor(LEVELS), POS), torch.zeros((WORLDS, 4))
    is_new, rows = torch.arange(WORLDS) > 2, torch.full((WORLDS,), 3)
    old, fresh = sensor.start(ground, poses), sensor.start(ground, poses + 1)

    def both(old: Any, fresh: Any, is_new: Any, rows: Any, walked: Any) -> Any:
        return sensor.restart(old, is_new, fresh), next_rows(rows, walked, 1.0, count=9, length=2.0, rng=None)

    torch.compiler.reset()
    state, after = torch.compile(both, fullgraph=True, backend=_Traces())(old, fresh, is_new, rows, 2.0 * is_new)
    assert np.array_equal(state.scans, sensor.restart(old, is_new, fresh).scans)
    assert after.tolist() == [2, 2, 2, 4, 4]


@contextmanager
def _counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Names of what asks a device for a number, or sends numbers of the host there, while it is open."""
    from torch.utils._python_dispatch import TorchDispatchMode

    module, found = sys.modules["torch"], list[str]()

    class Counting(TorchDispatchMode):  # type: ignore[misc]  # torch is not here when types are checked
        def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
            name = str(func)
            if any(word in name for word in ("local_scalar", "nonzero", "is_same_size", "equal.default", "unique")):
                found.append(name)
            return func(*args, **(kwargs or {}))

    with monkeypatch.context() as patch:
        for name in ("asarray", "tensor", "as_tensor", "from_numpy"):
            own = getattr(module, name)

            def sent(*args: Any, _own: Any = own, _name: str = name, **kwargs: Any) -> Any:
                found.append(_name)
                return _own(*args, **kwargs)

            patch.setattr(module, name, sent)
        with Counting():
            yield found


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS.keys())
def test_torch_never_waits_for_the_device(question: Question, monkeypatch: pytest.MonkeyPatch) -> None:
    ground = Ground(RECIPE, torch.as_tensor(LEVELS), POS)
    feet, some, others = torch.as_tensor(_feet(0)), torch.as_tensor(SOME), torch.as_tensor(OTHERS)
    with _counted(monkeypatch) as counted:
        found = question(ground, feet, some)
        ground.write(others, some)
        after = question(ground, feet, some)
        assert counted == []
        int(found.reshape(-1)[0])
        ground.heights(_feet(0))
        assert len(counted) == 2  # what is counted counts
    assert np.asarray(found) == pytest.approx(_expected(question, LEVELS, 0), abs=1e-5)
    assert np.asarray(after) == pytest.approx(_expected(question, _changed(), 0), abs=1e-5)


class _Traces:
    """A backend of torch's compiler that counts its graphs, and runs each as it is."""

    count = 0

    def __call__(self, graph: Any, inputs: Any) -> Any:
        self.count += 1
        return graph.forward


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS.keys())
@pytest.mark.filterwarnings("ignore")  # torch's own
def test_torch_compiles_every_question_as_one_graph(question: Question) -> None:
    """By the front of the compiler, which finds graphs; what makes them fast needs a C++ compiler."""
    ground, traces = Ground(RECIPE, torch.as_tensor(LEVELS), POS), _Traces()
    torch.compiler.reset()
    compiled = torch.compile(question, fullgraph=True, backend=traces)
    for seed in range(3):
        found = compiled(ground, torch.as_tensor(_feet(seed)), torch.as_tensor(SOME))
        assert np.asarray(found) == pytest.approx(_expected(question, LEVELS, seed), abs=1e-5)
    assert traces.count == 1


@pytest.mark.filterwarnings("ignore")  # torch's own
def test_torch_compiles_the_writing_of_maps_as_one_graph() -> None:
    ground, traces = Ground(RECIPE, torch.as_tensor(LEVELS), POS), _Traces()
    torch.compiler.reset()
    compiled = torch.compile(ground.write, fullgraph=True, backend=traces)
    for maps, expected in ((OTHERS, _changed()), (LEVELS[SOME], LEVELS)):
        compiled(torch.as_tensor(maps), torch.as_tensor(SOME))
        assert np.array_equal(np.asarray(ground.levels), expected)
    assert traces.count == 1


@pytest.mark.parametrize("name", ["torch", "jax.numpy"])
def test_levels_on_a_device_are_kept_within_those_of_the_recipe(name: str) -> None:
    library = pytest.importorskip(name, reason=f"{name} is not installed")
    ground = Ground(RECIPE, library.asarray(LEVELS), POS)
    ground.write(library.asarray(np.array([[[9]], [[-3]]]) + 0 * OTHERS), library.asarray(SOME))
    assert np.asarray(ground.levels)[SOME].reshape(2, -1).tolist() == [[5] * 72, [0] * 72]
