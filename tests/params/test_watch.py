"""A search tells whoever watches how far it is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rsegen
from rsegen.cli import main
from rsegen.params.watch import tell, watched

WAY = ["--seed", "7", "--chunk-size", "8", "--unit-cm", "5", "--boundary", "none", "--crossable-by", "burger"]
ROUGH = rsegen.Recipe(
    seed=7,
    chunk_size=8,
    unit_cm=5,
    boundary="none",
    crossable_by="burger",
    obstacles=[rsegen.Random(levels=4)],
)


def test_a_search_for_a_way_across_tells_its_share_and_its_end() -> None:
    told: list[tuple[str, float]] = []
    with watched(lambda what, share: told.append((what, share))):
        watched_field = rsegen.build(ROUGH)
    *shares, last = (share for _, share in told)
    assert last == 1
    assert len(shares) > 2
    assert all(0 < share < 1 for share in shares)
    assert {what for what, _ in told[:-1]} == {"a way for the burger"}
    assert (watched_field.levels == rsegen.build(ROUGH).levels).all()


def test_nobody_has_to_watch() -> None:
    with watched(lambda *_: pytest.fail("told after the end")):
        pass
    tell("anything", 0.5)


def test_the_command_line_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["generate", *WAY, "--obstacle", "random levels=4", "-o", str(tmp_path), "--progress", "json"]
    assert main(words) == 0
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    shares = [line["done"] for line in lines if line["unit"] == "%"]
    assert shares == sorted(shares)
    assert shares[-1] > 50
