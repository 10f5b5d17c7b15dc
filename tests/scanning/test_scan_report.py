"""A scan for programs: which blocks were seen, how sure each level is, and the lengths as they were measured."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen import Recipe
from rsegen.cli.edge import main
from rsegen.field.stepfield import Array
from rsegen.scanning.finding import find_field
from rsegen.scanning.scan_report import confidence_csv, scan_content

BUILT = rsegen.build(Recipe(seed=3, boundary="outer", obstacles=[rsegen.Random(levels=5)]))
UNSEEN = [(2, 3), (5, 1), (8, 8)]
"""Blocks of which no point is in the cloud, x and y as recipes count them."""
HOLES = [(x, y) for x, y in np.argwhere(BUILT.blocks == 0).tolist() if (x, y) not in UNSEEN]


def cloud(stretch: float = 1.0) -> Array:
    """Points on all tops and the floor, from right above, as `stretch` times as large as the field, without UNSEEN."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-0.85, 0.85, (2, 60_000))
    i, j = (np.floor(at / 0.1).astype(int) + 6 for at in (x, y))
    inside = (i >= 0) & (i < 12) & (j >= 0) & (j < 12)
    z = np.where(inside, BUILT.heights[i.clip(0, 11), j.clip(0, 11)], 0) + rng.normal(0, 0.003, x.shape)
    hidden = np.isin((i - 1) * 100 + j - 1, [block_x * 100 + block_y for block_x, block_y in UNSEEN])
    return np.column_stack([x, y, z])[~hidden] * stretch


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, object], Path]:
    """Output of `scan --json`, and its folder."""
    folder = tmp_path_factory.mktemp("scan")
    np.savetxt(folder / "pallet.xyz", cloud(1.01), fmt="%.4f")
    out = folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        printed: list[str] = []
        patch.setattr("builtins.print", lambda *words, file=None, **_: printed.append(words[0]) if not file else None)
        assert main(["scan", str(folder / "pallet.xyz"), "-o", str(out), "--name", "twin", "--json"]) == 0
    return json.loads(printed[0]), out


def rows_of(path: Path) -> Array:
    """A table that is north up, as (n_x, n_y)."""
    return np.loadtxt(path, delimiter=",", comments="#", ndmin=2)[::-1].T


@pytest.mark.slow
def test_a_program_tells_a_hole_from_a_block_that_nobody_saw(told: tuple[dict[str, object], Path]) -> None:
    _, folder = told
    levels = rows_of(folder / "twin_0000/levels.csv")
    confidence = rows_of(folder / "twin_confidence.csv")
    assert levels.shape == confidence.shape == (10, 10)
    assert {tuple(cell) for cell in np.argwhere(confidence == 0).tolist()} == set(UNSEEN)
    assert len(HOLES) > 5
    for hole in HOLES:
        assert levels[hole] == 0
        assert confidence[hole] > 0.95
    for unseen in UNSEEN:
        assert levels[unseen] == 0  # made up, and said to be


@pytest.mark.slow
def test_scan_json_says_what_was_found(told: tuple[dict[str, object], Path]) -> None:
    content, folder = told
    scan = content["scan"]
    assert isinstance(scan, dict)
    assert [(cell["x"], cell["y"]) for cell in scan["not_seen"]] == UNSEEN
    assert scan["not_seen"][0]["cell"] == [3, 4]
    assert (scan["blocks"], scan["cells"], scan["cells_seen"]) == ([10, 10], 144, 141)
    assert (scan["block_width_m"], scan["unit_m"]) == (0.1, 0.1)
    assert scan["bits_of_grid"] > 46
    assert scan["measured_block_width_m"] == pytest.approx(0.101, abs=2e-4)
    assert scan["measured_unit_m"] == pytest.approx(0.101, abs=2e-4)
    assert 0 < scan["residual_mean_m"] <= scan["residual_most_m"] < 0.005
    levels = np.array(scan["levels"], dtype=float)
    seen = np.isfinite(levels)
    assert (levels[seen] == BUILT.blocks[seen]).all()
    assert {tuple(cell) for cell in np.argwhere(~seen).tolist()} == set(UNSEEN)
    assert (np.array(scan["confidence"]) > 0).tolist() == seen.tolist()
    residuals = np.array(scan["residuals_m"], dtype=float)
    assert np.nanmax(np.abs(residuals)) <= scan["residual_most_m"]
    named = "(x 2 y 3, x 5 y 1, x 8 y 8); blocks among them get level 0"
    assert scan["notes"] == [f"warning: not seen: 3 of 144 cells {named}"]
    assert scan["files"] == {"fit": f"{folder}/twin_fit.png", "confidence": f"{folder}/twin_confidence.csv"}
    assert Path(scan["files"]["confidence"]).is_file()


@pytest.mark.slow
def test_all_cells_are_listed_however_many_they_are() -> None:
    """The line of text names eight of them."""
    points = cloud()
    hidden = (points[:, 0] < -0.2) & (points[:, 0] > -0.4) & (np.abs(points[:, 1]) < 0.49)
    scan = find_field(points[~hidden])
    content = scan_content(scan, 5)
    named = {(cell["x"], cell["y"]) for cell in content["not_seen"]}
    assert len(named) == (~scan.seen).sum() > 15
    table = confidence_csv(scan).decode().splitlines()
    rows = [line.split(",") for line in reversed(table[1:])]
    zeros = {(x, y) for y, row in enumerate(rows) for x, share in enumerate(row) if share == "0"}
    assert zeros == named


@pytest.mark.slow
def test_a_frame_that_was_not_seen_has_a_cell_and_no_block() -> None:
    points = cloud()
    corner = (points[:, 0] < -0.5) & (points[:, 1] < -0.5) & (points[:, 0] > -0.6) & (points[:, 1] > -0.6)
    scan = find_field(points[~corner])
    frames = [cell for cell in scan_content(scan, 5)["not_seen"] if cell["x"] is None]
    assert [frame["cell"] for frame in frames] in ([[0, 0]], [[0, 11]], [[11, 0]], [[11, 11]])
