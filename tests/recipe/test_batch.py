"""Many maps at once are the maps that are built one by one, to the last level."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Matrix, Random, Recipe
from rsegen.errors import ParameterError, TooLarge
from rsegen.field.stepfield import Array, Levels
from rsegen.obstacles import Grid, Patch
from rsegen.obstacles.base import Shaped
from rsegen.params.sorts import ANYWHERE, Cell
from rsegen.params.streams import Streams, generator
from rsegen.recipe.examples import EXAMPLES
from tests.support.long import long_unless
from tests.support.strategies import SEEDS, recipes

FAR = (0, 3, 2, 5000, 2**62, 3)


def _one_by_one(recipe: Recipe, indices: Iterable[int]) -> Levels:
    return np.array([rsegen.build(recipe, index).blocks for index in indices])


@given(recipe=recipes(), indices=st.lists(st.integers(0, 2**63 - 1), max_size=3))
def test_many_maps_equal_maps_built_one_by_one(recipe: Recipe, indices: list[int]) -> None:
    found = rsegen.build_many(recipe, [*indices, 0])
    assert found.dtype == np.int16
    assert np.array_equal(found, _one_by_one(recipe, [*indices, 0]))


@pytest.mark.parametrize("example", EXAMPLES)
@pytest.mark.parametrize("changes", [{}, {"difficulty": 0.4}, {"max_step": 1}], ids=str)
def test_many_maps_of_every_example_equal_maps_built_one_by_one(example: str, changes: dict[str, Any]) -> None:
    recipe = replace(rsegen.load(EXAMPLES[example]), **changes)
    assert np.array_equal(rsegen.build_many(recipe, FAR), _one_by_one(recipe, FAR))


@given(seed=SEEDS, index=st.integers(0, 2**63 - 1), key=st.text(max_size=20))
def test_streams_of_many_maps_are_the_generators_of_each(seed: int, index: int, key: str) -> None:
    streams = Streams.of(seed, (index, 0), key)
    alone = [generator(seed, at, key) for at in (index, 0)]
    for rng, own in zip(streams.generators(), alone, strict=True):
        assert rng.bit_generator.state == own.bit_generator.state
    for _ in range(3):
        assert streams.random().tolist() == [own.random() for own in alone]
    arrays = streams.arrays((4, 3))
    assert np.array_equal(arrays, streams.jumped((4, 3)))
    assert np.array_equal(arrays, [own.random((4, 3)) for own in alone])


@st.composite
def _designs(draw: st.DrawFn) -> Recipe:
    """Recipes with everything that many maps share: random kinds of every sort, difficulties, a largest step."""
    recipe = draw(recipes())
    cells = recipe.grid.n_x * recipe.grid.n_y
    weights = tuple(draw(st.lists(st.integers(0, 4), min_size=5, max_size=5).filter(any)))
    low = draw(st.integers(0, cells))
    more = draw(
        st.sampled_from(
            [
                Random(levels=5, weights=weights, softness=draw(st.integers(0, 100))),
                Random(levels=3, counts=(low, 0, cells - low), blend="max"),
                Random(levels=4, first=("random", 2), last=("random", "random"), blend="add"),
            ]
        )
    )
    share = st.floats(0, 1)
    difficulty = draw(
        st.one_of(
            share,
            st.tuples(share, share).filter(lambda pair: pair[0] <= pair[1]),
            st.tuples(share, st.just(1.0), st.integers(2, 4)),
        )
    )
    max_step = draw(st.sampled_from([None, 1, 2]))
    return replace(recipe, obstacles=(*recipe.obstacles, more), difficulty=difficulty, max_step=max_step)


@pytest.mark.slow
@given(recipe=_designs())
def test_many_maps_at_their_difficulties_and_steps_equal_maps_built_one_by_one(recipe: Recipe) -> None:
    assert np.array_equal(rsegen.build_many(recipe, FAR), _one_by_one(recipe, FAR))


DRAWN: dict[str, Any] = {"first": "random", "last": "random"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(rsegen.KINDS))
@pytest.mark.parametrize("blend", ["replace", "max", "add", "min"])
@pytest.mark.parametrize(
    "ends",
    long_unless(
        lambda ends: ends != DRAWN,
        [{}, DRAWN, {"first": (2, "random"), "last": (2, 5)}],
        reason="ends of which a half is drawn in make test",
    ),
)
def test_every_kind_with_drawn_ends_and_every_blend(kind: str, blend: str, ends: dict[str, Any]) -> None:
    obstacle = rsegen.KINDS[kind](levels=5, softness=40, blend=blend, **ends)
    recipe = Recipe(seed=11, chunk_size=6, chunks=(2, 1), ground_level=4, obstacles=[Random(levels=4), obstacle])
    many = rsegen.build_many(recipe, range(6))
    assert np.array_equal(many, _one_by_one(recipe, range(6)))
    if ends:  # without them, some kinds are the same on the whole of every map
        assert len(np.unique(many, axis=0)) > 3


@pytest.mark.parametrize(
    "ends",
    [
        {},
        {"first": (7, 1), "last": (0, 5)},
        {"first": ANYWHERE, "last": ANYWHERE},
        {"first": (4, "random"), "last": ("random", 3)},
    ],
    ids=str,
)
def test_uneven_stones_of_many_maps_are_those_built_one_by_one(ends: dict[str, Any]) -> None:
    stones = rsegen.Stones(levels=5, uneven=3, stone_width=1, platform_width=2, softness=20, key="tops", **ends)
    recipe = Recipe(seed=5, chunk_size=9, ground_level=4, obstacles=[stones, rsegen.Stones(levels=2, uneven=1, **ends)])
    many = rsegen.build_many(recipe, range(40))
    assert np.array_equal(many, _one_by_one(recipe, range(40)))
    assert len(np.unique(many, axis=0)) > 20


@pytest.mark.parametrize(
    "changes",
    [
        {"crossable_by": (5, 5, 20)},
        {"crossable_by": (5, 15, 0), "chunks": (2, 1)},
        {"crossable_by": (10, 10, 30), "max_step": 3, "boundary": "outer"},
        {"crossable_by": (1, 2, 30), "unit_cm": 1 / 3, "block_width_cm": 7.77, "frame_height_cm": 0.9},
    ],
    ids=str,
)
def test_maps_lowered_along_a_path_together_equal_maps_lowered_one_by_one(changes: dict[str, Any]) -> None:
    recipe = Recipe(
        **{"seed": 7, "chunk_size": 8, "unit_cm": 5, "frame_height_cm": 5, "obstacles": [Random(levels=9)], **changes}
    )
    designed = rsegen.build_many(replace(recipe, crossable_by=None), range(40))
    lowered = rsegen.build_many(recipe, range(40))
    assert (lowered < designed).any(axis=(1, 2)).sum() > 20
    assert np.array_equal(lowered, _one_by_one(recipe, range(40)))


@pytest.mark.parametrize("seed", range(12))
def test_pallets_and_reordered_blocks_of_many_maps_are_those_built_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    levels, side = int(rng.integers(4, 7)), int(rng.integers(4, 9))
    ends: dict[str, Any] = {"first": ANYWHERE, "last": ANYWHERE} if seed % 2 else {}
    pallet = rsegen.Pallet(
        levels=levels,
        pattern=tuple(rng.choice(["flat", "hill", "diagonal"], size=2).tolist()),
        turns=tuple(rng.integers(0, 4, size=2).tolist()),
        symmetry=str(rng.choice(["random", "symmetric"])),
        **ends,
    )
    reordered = Random(levels=levels, max_step=levels - 2, key="reordered", blend="max", last=(side - 1, side - 1))
    recipe = Recipe(seed=seed, chunk_size=side, chunks=(2, 1), obstacles=[pallet, reordered])
    many = rsegen.build_many(recipe, range(8))
    assert np.array_equal(many, _one_by_one(recipe, range(8)))
    assert len(np.unique(many, axis=0)) > 4


@given(seed=SEEDS, skipped=st.integers(0, 500))
def test_streams_that_skip_numbers_go_on_as_generators_that_drew_them(seed: int, skipped: int) -> None:
    streams, alone = Streams.of(seed, range(3), "k"), [generator(seed, at, "k") for at in range(3)]
    for own in alone[1:]:
        own.random(skipped)
    part = streams.part([1, 2])
    part.skip(skipped)
    streams.put([1, 2], part)
    assert np.array_equal(streams.drawn((4,)), [own.random(4) for own in alone])
    assert np.array_equal(streams.random(), [own.random() for own in alone])
    assert np.array_equal(Streams.at(alone[0]).arrays((3,)), [alone[0].random(3)])


@pytest.mark.parametrize("difficulty", [1, 0.6])
def test_maps_too_large_to_be_made_together_are_those_built_one_by_one(difficulty: float) -> None:
    obstacles = [
        Random(levels=3, first=ANYWHERE, last=ANYWHERE),
        rsegen.Peak(levels=5),
        rsegen.DiagonalBarrier(levels=4, blend="max"),
    ]
    recipe = Recipe(seed=1, chunk_size=70, obstacles=obstacles, difficulty=difficulty)
    assert np.array_equal(rsegen.build_many(recipe, FAR), _one_by_one(recipe, FAR))


def test_maps_beyond_one_batch_are_those_built_one_by_one() -> None:
    recipe = Recipe(seed=4, chunk_size=3, obstacles=[Random(levels=6)])
    found, places = rsegen.build_many(recipe, range(20_000)), (0, 3640, 3641, 4095, 4096, 19_999)
    assert found.shape == (20_000, 3, 3)
    assert np.array_equal(found[list(places)], _one_by_one(recipe, places))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Raised(Random):
    """Random blocks, all raised by as many levels as one more draw says."""

    kind: ClassVar[str] = "raised"

    @property
    def level_range(self) -> tuple[int, int]:
        return 0, self.levels + 1

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        patch = Random.patch(self, grid, first, last, rng)
        return patch._replace(levels=patch.levels + np.int16(3 * rng.random()))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Blurred(Random):
    """Random blocks, each as high as the mean along its row."""

    kind: ClassVar[str] = "blurred"

    def drawn(self, uniform: Array) -> Levels:
        return np.broadcast_to(uniform.mean(axis=1, keepdims=True) * 5, uniform.shape).astype(np.int16)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Shaken(Matrix):
    """Given levels, raised at random."""

    kind: ClassVar[str] = "shaken"

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        patch = Matrix.patch(self, grid, first, last, rng)
        return patch._replace(levels=patch.levels + np.int16(3 * rng.random()))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing(Random):
    """Random blocks that draw once before their levels, wherever they lie."""

    kind: ClassVar[str] = "drawing"

    def ends(self, grid: Grid, first: object, last: object, rng: np.random.Generator) -> tuple[Cell, Cell]:
        rng.random()
        return (0, 0), (grid.n_x - 1, grid.n_y - 1)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Wedge(Shaped):
    """Levels that rise along x, by methods that know numbers only."""

    kind: ClassVar[str] = "wedge"

    def overhang(self, grid: Grid) -> float:
        return 1.0

    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        low = first[0] if first[0] < last[0] else last[0]
        return np.clip((x - low + 0 * y) / 6, 0, 1)

    def ends(self, grid: Grid, first: object, last: object, rng: np.random.Generator) -> tuple[Cell, Cell]:
        at = int(rng.random() * grid.n_x)
        return ((0, 0), (at, at)) if at < 3 else ((at, 1), (1, at))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Post(rsegen.Obstacle):
    """One block at a cell that its patch draws: a kind with nothing but a patch."""

    kind: ClassVar[str] = "post"

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        i, j = (int(rng.random() * cells) for cells in grid.shape)
        levels = np.full((1, 1), self.levels - 1, dtype=np.int16)
        return Patch((slice(i, i + 1), slice(j, j + 1)), levels, levels > 0)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Turned(rsegen.Peak):
    """A peak whose own ends replace those of all maps at once."""

    kind: ClassVar[str] = "turned"

    def ends(self, grid: Grid, first: object, last: object, rng: np.random.Generator) -> tuple[Cell, Cell]:
        return ((0, 0), (4, 2)) if rng.random() < 0.5 else ((5, 1), (7, 9))


@pytest.mark.parametrize("obstacle", [_Wedge(levels=6), _Post(levels=6), _Turned(levels=6)], ids=lambda own: own.kind)
@pytest.mark.parametrize("difficulty", [1, 0.5])
def test_kinds_of_others_are_those_built_one_by_one(obstacle: rsegen.Obstacle, difficulty: float) -> None:
    recipe = Recipe(seed=9, obstacles=[Random(levels=3), replace(obstacle, blend="max")], difficulty=difficulty)
    assert np.array_equal(rsegen.build_many(recipe, range(60)), _one_by_one(recipe, range(60)))


@pytest.mark.parametrize(
    "obstacle",
    [_Raised(levels=6), _Blurred(levels=6), _Shaken(levels=6, rows=("1 2", "0 .")), _Drawing(levels=6)],
    ids=lambda obstacle: obstacle.kind,
)
def test_kinds_that_draw_in_their_own_way_are_built_map_by_map(obstacle: rsegen.Obstacle) -> None:
    recipe = Recipe(seed=9, obstacles=[replace(obstacle, first=(0, 0), last=(7, 5))])
    found = rsegen.build_many(recipe, FAR)
    assert np.array_equal(found, _one_by_one(recipe, FAR))
    assert len(np.unique(found, axis=0)) > 1


def test_an_error_in_one_map_names_its_obstacle() -> None:
    recipe = Recipe(seed=1, obstacles=[Random(levels=9, max_step=1, key="steep")])
    with pytest.raises(ParameterError, match=r"^obstacles\[0\].max_step: 1: no order"):
        rsegen.build_many(replace(recipe, chunk_size=2), range(50))


@pytest.mark.parametrize("indices", [[-1], [2**63], [0.5], 7, ["1"]], ids=str)
def test_indices_are_whole_numbers_from_0_on(indices: object) -> None:
    with pytest.raises(ParameterError, match="indices"):
        rsegen.build_many(Recipe(seed=1), indices)  # type: ignore[arg-type]  # on purpose


def test_an_empty_list_of_indices_gives_no_map() -> None:
    assert rsegen.build_many(Recipe(seed=1), []).shape == (0, 10, 10)


def test_more_maps_than_memory_are_refused_at_once() -> None:
    with pytest.raises(TooLarge, match=r"^indices: 10,000,000,000,000 maps of 10 x 10 blocks would exceed"):
        rsegen.build_many(Recipe(boundary="none", obstacles=[Random(levels=5)]), range(10**13))
