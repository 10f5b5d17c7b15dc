"""Needs of a run, in numbers that a person can read."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rsegen import Random, Recipe
from rsegen.errors import TooLarge
from rsegen.formats.base import FORMATS
from rsegen.heights.base import imported, importer_for
from rsegen.writing import control_groups, execute, resources
from rsegen.writing.resources import check_needs, format_bytes


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 bytes"),
        (999, "999 bytes"),
        (1000, "1.0 kB"),
        (200_000, "200.0 kB"),
        (1_300_000, "1.3 MB"),
        (23_500_000_000, "23.5 GB"),
        (150_000_000_000_000, "150.0 TB"),
        (10**15, "millions of GB"),
        (10**400, "millions of GB"),
        (math.inf, "millions of GB"),
    ],
)
def test_bytes_are_in_the_unit_that_fits(size: float, text: str) -> None:
    assert format_bytes(size) == text


def test_a_disk_that_is_too_small_is_refused_in_the_unit_that_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resources, "_free_disk", lambda _: 200_000)
    with pytest.raises(TooLarge, match=r"maps: 106 maps need 1\.3 MB of disk or more, 200\.0 kB are free; make fewer"):
        check_needs([Recipe(seed=1)], 106, tmp_path)


@pytest.fixture
def groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Control groups of a machine that has as much memory as anybody needs; this process is in /docker/abc."""
    monkeypatch.setattr(resources, "_free_on_machine", lambda: 10**15)
    monkeypatch.setattr(control_groups, "_GROUPS", tmp_path / "groups")
    monkeypatch.setattr(control_groups, "_OWN_GROUPS", tmp_path / "own")
    (tmp_path / "own").write_text("2:cpu,cpuacct:/docker/abc\n3:cpuset:/docker\n4:memory:/docker/abc\n0::/docker/abc\n")
    return tmp_path / "groups"


V2 = {"memory.max": "900000000\n", "memory.current": "800000000\n", "memory.stat": "anon 5\ninactive_file 20000000\n"}
V1 = {
    "memory.limit_in_bytes": "900000000\n",
    "memory.usage_in_bytes": "800000000\n",
    "memory.stat": "inactive_file 7\ntotal_inactive_file 20000000\n",
}


@pytest.mark.parametrize(
    ("place", "files"),
    [
        ("", V2),
        ("docker", V2),
        ("docker/abc", V2),
        ("memory", V1),
        ("memory/docker/abc", V1),
    ],
)
def test_a_container_has_the_memory_that_its_control_groups_leave(
    groups: Path, place: str, files: dict[str, str]
) -> None:
    unlimited = groups / "docker" / "abc"
    unlimited.mkdir(parents=True)
    (unlimited / "memory.max").write_text("max\n")
    (groups / place).mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (groups / place / name).write_text(content)
    with pytest.raises(TooLarge, match=r"cells needs about .* of memory, 120\.0 MB are free"):
        resources.refuse_too_large(Recipe(seed=1, chunk_size=1000, chunks=(3, 3)))


@pytest.mark.parametrize("content", ["max\n", "", "much\n"])
def test_a_control_group_without_a_limit_leaves_what_the_machine_has(groups: Path, content: str) -> None:
    groups.mkdir()
    for name, other in V2.items():
        (groups / name).write_text(content if name == "memory.max" else other)
    resources.refuse_too_large(Recipe(seed=1, chunk_size=1000, chunks=(3, 3)))


@pytest.mark.parametrize(
    ("place", "files", "cores"),
    [
        ("docker", {"cpu.max": "150000 100000\n"}, 2),
        ("docker/abc", {"cpu.max": "20000 100000\n"}, 1),
        ("docker/abc", {"cpu.max": "9000000 100000\n"}, 8),
        ("docker/abc", {"cpu.max": "max 100000\n"}, 8),
        ("cpu,cpuacct/docker", {"cpu.cfs_quota_us": "300000\n", "cpu.cfs_period_us": "100000\n"}, 3),
        ("cpu,cpuacct", {"cpu.cfs_quota_us": "-1\n", "cpu.cfs_period_us": "100000\n"}, 8),
        ("cpuset/docker", {"cpu.max": "100000 100000\n"}, 8),
    ],
)
def test_a_container_has_the_processors_that_its_control_groups_leave(
    groups: Path, monkeypatch: pytest.MonkeyPatch, place: str, files: dict[str, str], cores: int
) -> None:
    monkeypatch.setattr("sys.platform", "darwin")
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    (groups / place).mkdir(parents=True)
    for name, content in files.items():
        (groups / place / name).write_text(content)
    assert execute.cores() == cores


@pytest.mark.slow
def test_more_obstacles_than_a_large_map_can_take_are_refused_before_the_work() -> None:
    rows = (Random(levels=5),) * 20_001
    recipe = Recipe(seed=1, chunk_size=1000, boundary="none", obstacles=rows)
    with pytest.raises(TooLarge, match=r"obstacles: 20,001 of them on .* cells .* use 20,000 or fewer"):
        resources.refuse_too_large(recipe)
    resources.refuse_too_large(replace(recipe, obstacles=rows[:-1]))


def test_heights_that_do_not_fit_into_memory_are_refused_before_they_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "heights.npy", np.zeros((100, 200)))
    monkeypatch.setattr(resources, "_free_memory", lambda: 1_000_000)
    with pytest.raises(TooLarge, match=r"100 x 200 cells need about 41\.0 MB of memory, 1\.0 MB are free$"):
        imported(tmp_path / "heights.npy", importer_for(tmp_path / "heights.npy")())


@pytest.mark.parametrize(("free", "maps"), [(300_000, 1), (50_205_000, 1), (100_410_000, 2), (1_000_000_000, 19)])
def test_no_more_maps_are_made_at_once_than_fit_into_memory(
    free: int, maps: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A worker has 50 MB, and a map of 100 cells 50 bytes for each, and 2000 for each while a piece is meshed.
    monkeypatch.setattr(resources, "_free_memory", lambda: free)
    recipe = Recipe(seed=1, boundary="none")
    assert check_needs([recipe], 5, tmp_path) == maps
    assert resources.maps_in_memory(recipe) == maps


GB = 10**9
MEASURED = {
    ("world", 2000): 288,
    ("boxes", 1000): 2173,
    ("blocks", 1000): 479,
    ("watertight", 500): 955,
    ("difficulty", 2000): 398,
    ("measure", 2000): 752,
    ("stl", 500): 965,
    ("stl", 1000): 2687,
    ("usd", 1000): 2739,
    ("glb", 500): 956,
    ("posture", 1000): 2712,
    ("mjcf", 2000): 2708,
    ("urdf", 1000): 2201,
    ("ros2", 500): 564,
}
"""MB of memory for what is made of a map with this number of cells along each side, most of them of 100 levels."""


def needed(side: int, what: str = "world", **options: Any) -> int:
    """The bytes that a map needs by the rule."""
    recipe = Recipe(seed=1, chunk_size=500, chunks=(side // 500, side // 500), boundary="none")
    match what:
        case "boxes" | "blocks":
            recipe = replace(recipe, collision=what)
        case "watertight":
            recipe = replace(recipe, mesh="watertight")
        case "difficulty":
            recipe = replace(recipe, difficulty=0.5)
    formats = [FORMATS[what](**options)] if what in FORMATS else []
    return resources._memory(recipe, "measure" if what == "measure" else "build", formats)


@pytest.mark.parametrize(("what", "side"), MEASURED)
def test_the_rule_is_near_the_measurements(what: str, side: int) -> None:
    assert 0.8 < needed(side, what) / (MEASURED[what, side] * 1e6) < 4.5


def test_a_large_world_of_merged_meshes_needs_no_large_machine() -> None:
    assert needed(8000) < 8 * GB


@pytest.mark.parametrize(
    ("name", "options", "measured"),
    [
        ("heightmap", {"pixels": 10}, 223),
        ("occupancy", {"pixels": 10}, 222),
        ("posture", {"per_block": 20}, 17_650),
        ("mjcf", {"shape": "hfield", "pixels": 20}, 6362),
    ],
)
def test_values_within_a_cell_are_counted(name: str, options: dict[str, Any], measured: int) -> None:
    piece = 500**2 * resources.BYTES_PER_CELL["surface"]
    assert 0.8 < (needed(500, name, **options) - piece) / (500**2 * measured) < 4.5


def test_a_map_needs_more_to_be_measured_or_exported_than_to_be_built(monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = Recipe(seed=1, chunk_size=1000, boundary="none")
    monkeypatch.setattr(resources, "_free_memory", lambda: 700_000_000)
    resources.refuse_too_large(recipe)
    with pytest.raises(TooLarge, match=r"^chunks: a map of 1000 x 1000 cells needs about 824\.3 MB of memory, 700"):
        resources.refuse_too_large(recipe, "measure")
    with pytest.raises(TooLarge, match=r"needs about 4\.5 GB of memory, .* use fewer chunks or a smaller chunk_size"):
        resources.refuse_too_large(recipe, things=[FORMATS["stl"]()])
