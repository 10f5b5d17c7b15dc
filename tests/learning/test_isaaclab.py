"""Sub-terrains for Isaac Lab: its generator gets distinct tiles, and the same ones again, with and without its cache.

The package starts a simulator when it is imported. A stand-in has the parts that the adapter needs, and a generator
that does with a sub-terrain what that of Isaac Lab 2.3 or 3.0 does; where Isaac Lab is installed, its own generator is
asked too.
"""

from __future__ import annotations

import copy
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Pit, Random, Recipe, Stairs
from rsegen.errors import ParameterError, UnknownName

trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")

RECIPE = Recipe(seed=3, unit_cm=5, boundary="none", obstacles=[Random(levels=6)])
ADAPTER = "rsegen.learning.isaaclab"
Tiles = list[tuple[Any, np.ndarray]]


@dataclass
class SubTerrainBaseCfg:
    """The parameters that every sub-terrain of Isaac Lab has."""

    function: Any = None
    proportion: float = 1.0
    size: tuple[float, float] = (10.0, 10.0)

    def __post_init__(self) -> None:
        """Set all values anew, as Isaac Lab does with copies of them."""
        for name in [name for name in dir(self) if not name.startswith("__")]:
            if not callable(value := getattr(self, name)) and not isinstance(getattr(type(self), name, 0), property):
                setattr(self, name, copy.deepcopy(value))

    def copy(self) -> Any:
        return replace(self)


CLONES: dict[str, Callable[[Any], Any]] = {"2.3": lambda cfg: cfg.copy(), "3.0": replace}
"""Copy, by a generator, of the configuration of a sub-terrain for each tile."""


@dataclass
class GeneratorCfg:
    """Parameters of the stand-in's generator, by the names of Isaac Lab's."""

    sub_terrains: dict[str, Any]
    size: tuple[float, float] = (2.0, 2.0)
    num_rows: int = 4
    num_cols: int = 5
    seed: int = 7
    difficulty_range: tuple[float, float] = (1.0, 1.0)
    use_cache: bool = False
    cache_dir: str = ""
    border_width: float = 1.0


def _to_dict(cfg: Any) -> dict[str, Any]:
    """The attributes as the cache of Isaac Lab names them."""
    values = {name: value for name, value in vars(cfg).items() if not name.startswith("__")}
    return {**values, "function": f"{cfg.function.__module__}:{cfg.function.__name__}"}


def _generated(cfg: GeneratorCfg, version: str) -> Tiles:
    """The tiles, as TerrainGenerator makes them: sizes first, then for each a copy, the cache, and the function."""
    for own in cfg.sub_terrains.values():
        own.size = cfg.size
    rng, kept, tiles = np.random.default_rng(cfg.seed), Path(cfg.cache_dir or "."), []
    kinds = list(cfg.sub_terrains.values())
    for number in range(cfg.num_rows * cfg.num_cols):
        difficulty, own = rng.uniform(*cfg.difficulty_range), CLONES[version](kinds[number % len(kinds)])
        own.difficulty, own.seed = float(difficulty), cfg.seed
        name = kept / f"{abs(hash(json.dumps(_to_dict(own), sort_keys=True)))}.npz"
        if not (cfg.use_cache and name.is_file()):
            (mesh,), origin = own.function(difficulty, own)
            if not cfg.use_cache:
                tiles.append((mesh, origin))
                continue
            np.savez(name, vertices=mesh.vertices, faces=mesh.faces, origin=origin)
        found = np.load(name)
        tiles.append((trimesh.Trimesh(found["vertices"], found["faces"], process=False), found["origin"]))
    return tiles


def _packages(monkeypatch: pytest.MonkeyPatch, paths: dict[str, list[str]]) -> None:
    """Enter packages without what they import when they start."""
    for name, path in paths.items():
        package = ModuleType(name)
        package.__path__ = path
        monkeypatch.setitem(sys.modules, name, package)


@pytest.fixture
def isaaclab(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The adapter on the stand-in."""
    _packages(monkeypatch, {"isaaclab": [], "isaaclab.terrains": [], "isaaclab.utils": []})
    monkeypatch.setattr(sys.modules["isaaclab.terrains"], "SubTerrainBaseCfg", SubTerrainBaseCfg, raising=False)
    monkeypatch.setattr(sys.modules["isaaclab.utils"], "configclass", dataclass, raising=False)
    yield import_module(ADAPTER)
    sys.modules.pop(ADAPTER)


@pytest.fixture
def real(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Any, type, Callable[[Any], Tiles]]]:
    """The adapter on Isaac Lab's own files, its configuration and its generator."""
    found = find_spec("isaaclab")
    if found is None or not found.origin:
        pytest.skip("Isaac Lab is not installed: pip install --no-deps isaaclab, beside torch and warp-lang")
    pytest.importorskip("torch", reason="torch is not installed")
    pytest.importorskip("warp", reason="Warp is not installed")
    own = Path(found.origin).parent
    home = own if (own / "terrains").is_dir() else own / "source" / "isaaclab" / "isaaclab"  # 3.0, and 2.3
    names = {"isaaclab": home, "isaaclab.terrains": home / "terrains", "isaaclab.utils": home / "utils"}
    _packages(monkeypatch, {name: [str(path)] for name, path in names.items()})
    homes = {
        "isaaclab.utils": ("configclass", "dict"),
        "isaaclab.terrains": ("sub_terrain_cfg", "terrain_generator_cfg"),
    }
    for package, modules in homes.items():
        for module in (import_module(f"{package}.{name}") for name in modules):
            for name, value in list(vars(module).items()):
                if getattr(value, "__module__", None) == module.__name__:
                    setattr(sys.modules[package], name, value)
    generator_cfg = import_module("isaaclab.terrains.terrain_generator_cfg").TerrainGeneratorCfg

    def generated(cfg: Any) -> Tiles:
        generator = import_module("isaaclab.terrains.terrain_generator").TerrainGenerator(cfg)
        *meshes, _border = generator.terrain_meshes
        return list(zip(meshes, generator.terrain_origins.reshape(-1, 3), strict=True))

    yield import_module(ADAPTER), generator_cfg, generated
    for name in [name for name in sys.modules if name.startswith("isaaclab.") or name == ADAPTER]:
        sys.modules.pop(name)


def _shapes(tiles: Tiles) -> list[bytes]:
    """The surface of each tile, wherever it is."""
    placed = (np.asarray(mesh.vertices) - np.asarray(mesh.vertices).min(axis=0) for mesh, _ in tiles)
    return [np.round(points[np.lexsort(points.T)], 6).tobytes() for points in placed]


def _check_generation(terrain: type, generator_cfg: type, generated: Callable[[Any], Tiles], folder: Path) -> Tiles:
    """Ask a generator for 20 tiles of one difficulty: distinct, and the same in every way that Isaac Lab has."""
    values = {"num_rows": 4, "num_cols": 5, "seed": 7, "size": (2.0, 2.0), "border_width": 1.0}
    values |= {"difficulty_range": (1.0, 1.0), "cache_dir": str(folder)}

    def made(**own: Any) -> Any:
        return generator_cfg(**values | {"use_cache": False, "sub_terrains": {"r": terrain(recipe=RECIPE)}} | own)

    cfg = made()
    tiles = generated(cfg)
    shapes = _shapes(tiles)
    assert len(set(shapes)) == 20
    assert _shapes(generated(made())) == shapes
    assert _shapes(generated(cfg)) == shapes
    assert _shapes(generated(copy.deepcopy(cfg))) == shapes
    assert _shapes(generated(made(use_cache=True))) == shapes
    assert _shapes(generated(made(use_cache=True))) == shapes
    assert _shapes(generated(made(seed=8))) != shapes
    assert len(set(_shapes(generated(made(difficulty_range=(0.0, 1.0)))))) == 20
    return tiles


@pytest.mark.parametrize("version", list(CLONES))
def test_tiles_are_distinct_and_the_same_again(isaaclab: Any, version: str, tmp_path: Path) -> None:
    _check_generation(isaaclab.StepFieldTerrainCfg, GeneratorCfg, partial(_generated, version=version), tmp_path)


@pytest.mark.parametrize("version", list(CLONES))
def test_sub_terrains_alike_and_unlike_have_tiles_of_their_own(isaaclab: Any, version: str) -> None:
    """Two of one recipe never share a map, and another sort in between leaves the maps of the first as they are."""
    terrain = isaaclab.StepFieldTerrainCfg
    alike = {name: terrain(recipe=RECIPE) for name in ("a", "b")}
    assert len(set(_shapes(_generated(GeneratorCfg(sub_terrains=alike), version)))) == 20
    other = {"a": terrain(recipe=RECIPE), "b": terrain(recipe=replace(RECIPE, seed=4))}
    shapes = _shapes(_generated(GeneratorCfg(sub_terrains=other), version))
    assert len(set(shapes)) == 20
    alone = _shapes(_generated(GeneratorCfg(sub_terrains={"a": terrain(recipe=RECIPE)}), version))
    assert shapes[::2] == alone[:10]


def test_a_configuration_that_is_no_copy_has_the_first_tile(isaaclab: Any) -> None:
    terrain = isaaclab.StepFieldTerrainCfg
    cfg = terrain(recipe=RECIPE)
    _generated(GeneratorCfg(sub_terrains={"a": cfg}, size=(10.0, 10.0)), "3.0")
    assert cfg.tile == terrain(recipe=RECIPE).tile == 0
    assert [replace(cfg).tile for _ in range(2)] == [20, 21]
    assert _to_dict(cfg).keys() == {field.name for field in fields(cfg)}


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning")  # Isaac Lab's own, of torch and Warp
@pytest.mark.long(reason="Isaac Lab with torch, which are installed by hand")
def test_tiles_of_isaac_lab_are_distinct_and_the_same_again(real: Any, tmp_path: Path) -> None:
    adapter, generator_cfg, generated = real
    terrain = adapter.StepFieldTerrainCfg
    tiles = _check_generation(terrain, generator_cfg, generated, tmp_path)
    # Hydra: a configuration becomes a dictionary, is changed by texts, and is read again.
    values = {"num_rows": 4, "num_cols": 5, "seed": 7, "size": (2.0, 2.0), "border_width": 1.0}
    values |= {"difficulty_range": (1.0, 1.0), "use_cache": False}
    cfg = generator_cfg(**values, sub_terrains={"r": terrain(recipe=RECIPE)})
    other = generator_cfg(**values, sub_terrains={"r": terrain(recipe=replace(RECIPE, seed=99))})
    other.from_dict(json.loads(json.dumps(cfg.to_dict())))
    other.validate()
    assert _shapes(generated(other)) == _shapes(tiles)
    surface = trimesh.util.concatenate([mesh for mesh, _ in tiles])
    for x, y, z in (origin for _, origin in tiles):
        corners = surface.vertices - (4, 5, 0)  # the generator puts the middle of all tiles there at last
        near = (np.abs(corners[:, 0] - x) <= 1 + 1e-6) & (np.abs(corners[:, 1] - y) <= 1 + 1e-6)
        assert z == pytest.approx(corners[near, 2].max())


def _heights(mesh: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The highest point of a mesh over each place of x times y."""
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    corners = mesh.vertices[mesh.faces]
    upward = mesh.face_normals[:, 2] > 0.5
    low, high = corners[upward].min(axis=1), corners[upward].max(axis=1)
    heights = np.full(len(places), -np.inf)
    for lowest, highest in zip(low, high, strict=True):
        inside = ((places >= lowest[:2]) & (places <= highest[:2])).all(axis=1)
        heights[inside] = np.maximum(heights[inside], highest[2])
    return heights.reshape(len(x), len(y))


@pytest.mark.parametrize("kind", ["merged", "watertight"])
def test_the_map_is_amid_level_ground_from_0_to_the_size(isaaclab: Any, kind: str) -> None:
    cfg = isaaclab.StepFieldTerrainCfg(recipe=RECIPE, mesh=kind, spawn_radius=0.0)
    cfg.size, cfg.seed = (2.0, 1.5), 42
    (mesh,), origin = cfg.function(1.0, cfg)
    assert mesh.bounds[0] == pytest.approx([0, 0, -0.05])
    assert mesh.bounds[1][:2] == pytest.approx([2, 1.5])
    x, y = np.arange(20) * 0.1 + 0.05, np.arange(15) * 0.1 + 0.05
    levels = np.rint(_heights(mesh, x, y) / 0.05).astype(int)
    own = levels[5:15, 2:12]
    assert any(np.array_equal(own, rsegen.build(RECIPE, index).levels) for index in [isaaclab.hashed_index(42, 1.0, 0)])
    assert origin == pytest.approx([1.0, 0.7, own[4:6, 4:6].max() * 0.05])
    levels[5:15, 2:12] = 0
    assert not levels.any()
    assert mesh.is_watertight == (kind != "merged")
    assert isaaclab.StepFieldTerrainCfg(recipe=RECIPE).function(0.0, cfg)[0][0].bounds[1][2] == pytest.approx(0)


@pytest.mark.parametrize("kind", ["merged", "watertight"])
def test_holes_are_below_the_ground_that_is_z_0(isaaclab: Any, kind: str) -> None:
    gap = Pit(levels=4, gap_width=3, first=(0, 0), last=(9, 9))
    step = Stairs(levels=3, direction="down", first=(4, 4), last=(5, 5))
    recipe = replace(RECIPE, ground_level=4, obstacles=[gap, step])
    cfg = isaaclab.StepFieldTerrainCfg(recipe=recipe, mesh=kind, spawn_radius=0.0)
    cfg.size = (2.0, 1.5)
    (mesh,), origin = cfg.function(1.0, cfg)
    x, y = np.arange(20) * 0.1 + 0.05, np.arange(15) * 0.1 + 0.05
    own = rsegen.build(recipe).levels.astype(int) - 4
    expected = np.zeros((20, 15))
    expected[5:15, 2:12] = own * 0.05
    assert (own.min(), own.max(), own[4, 4]) == (-3, 0, -1)
    assert np.allclose(_heights(mesh, x, y), expected, atol=1e-9)
    assert origin == pytest.approx([1.0, 0.7, -0.05])
    cfg.spawn_radius = 0.3
    assert cfg.function(1.0, cfg)[1] == pytest.approx([1.0, 0.7, own[2:8, 2:8].max() * 0.05])
    assert mesh.bounds[0] == pytest.approx([0, 0, -0.25])
    assert mesh.is_watertight == (kind != "merged")
    (flat,), _ = cfg.function(0.0, cfg)
    assert flat.bounds[1][2] == pytest.approx(0)
    assert np.isin(np.round(flat.vertices[:, 2], 9), [0, -0.25]).all()


@pytest.mark.parametrize(
    ("values", "size", "message"),
    [
        ({}, (0.9, 2.0), "size: a map of 10 x 10 cells is larger than a tile of 9 x 20; use 1 x 1 m or more"),
        ({}, (1.23, 2.0), "size: 1.23 m along x is not a multiple of the block width 0.1 m; use 1.2 or 1.3"),
        (
            {"recipe": replace(RECIPE, level_friction=(0.5,))},
            None,
            "level_friction: a terrain of Isaac Lab is one",
        ),
        ({"recipe": replace(RECIPE, difficulty=(0, 1))}, None, "difficulty: .* is a range, and tiles have their own"),
        ({"recipe": [RECIPE]}, None, r"recipe: \[.*\] is not a recipe; pass one, and a sub-terrain for each"),
        ({"mesh": "boxes"}, None, r"unknown mesh 'boxes' .*merged, watertight"),
        ({"spawn_radius": -1}, None, r"spawn_radius: -1 is outside 0\.\.100"),
    ],
    ids=["larger", "no multiple", "frictions", "range", "a list", "mesh", "radius"],
)
def test_impossible_values_are_refused(isaaclab: Any, values: Any, size: Any, message: str) -> None:
    def made() -> None:
        cfg = isaaclab.StepFieldTerrainCfg(**{"recipe": RECIPE, **values})
        cfg.size = size
        cfg.function(1.0, cfg)

    with pytest.raises((ParameterError, UnknownName), match=message):
        made()
