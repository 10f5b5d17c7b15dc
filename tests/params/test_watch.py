"""A search tells whoever watches how far it is."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.cli.report import progress_of
from rsegen.params.watch import report_share, watched

WAY = ["--seed", "7", "--chunk-size", "5", "--unit-cm", "1", "--boundary", "none", "--crossable-by", "burger"]
ROUGH = rsegen.Recipe(
    seed=7,
    chunk_size=5,
    unit_cm=1,
    boundary="none",
    crossable_by="burger",
    obstacles=[rsegen.Random(levels=4)],
)


@pytest.mark.slow
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
    told: list[float] = []
    with watched(lambda _, share: told.append(share)):
        report_share("anything", 0.5)
    report_share("anything", 0.75)  # when nobody watches any more
    assert told == [0.5]


@pytest.mark.slow
def test_the_command_line_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["generate", *WAY, "--obstacle", "random levels=4", "-o", str(tmp_path), "--progress", "json"]
    assert main(words) == 0
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    shares = [line["done"] for line in lines if line["unit"] == "%"]
    assert shares == sorted(shares)
    assert shares[-1] > 50


@pytest.mark.slow
def test_a_series_tells_how_many_of_its_fields_are_measured(tmp_path: Path) -> None:
    told: list[tuple[str, float]] = []
    with watched(lambda what, share: told.append((what, share))):
        rsegen.series(
            rsegen.Recipe(seed=1, obstacles=[rsegen.Random(levels=4)]), tmp_path, maps=100, by="steps.highest"
        )
    assert {what for what, _ in told} == {"fields as designed"}
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert len(shares) > 1
    assert shares[-1] == 1


def test_a_large_mesh_and_its_file_tell_how_far_they_are(tmp_path: Path) -> None:
    told: list[tuple[str, float]] = []
    recipe = rsegen.Recipe(chunk_size=300, boundary="none", mesh="watertight", obstacles=[rsegen.Random(levels=5)])
    with watched(lambda what, share: told.append((what, share))), pytest.MonkeyPatch.context() as patch:
        for module in ("rsegen.geometry.watertight_mesh", "rsegen.gazebo.obj"):
            patch.setattr(sys.modules[module], "LARGE", 1e5)
        rsegen.generate(recipe, tmp_path)
    for what in ("a closed mesh", "vertices of an OBJ file", "faces of an OBJ file"):
        shares = [share for name, share in told if name == what]
        assert len(shares) > 2
        assert shares == sorted(shares)
        assert shares[-1] == 1


def test_one_work_inside_another_has_a_bar_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_of(argparse.Namespace(progress="json", quiet=False)):
        report_share("the whole", 0.25)
        for share in (0.3, 0.6, 1):
            report_share("a part", share)
        report_share("the whole", 0.75)
        report_share("the whole", 1)
    steps = [json.loads(line)["step"] for line in capsys.readouterr().err.splitlines()]
    assert steps[0] == "the whole"
    assert "a part" in steps
    assert set(steps) == {"the whole", "a part"}


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_terminal_that_does_not_know_its_size_has_a_bar(tmp_path: Path) -> None:
    """As that of `script` or of a container: it says that it has 0 columns."""
    import pty

    command = [sys.executable, "-m", "rsegen", "generate", "--maps", "3", "-o", str(tmp_path / "maps")]
    ours, theirs = pty.openpty()
    with open(ours, "rb", buffering=0) as terminal:
        done = subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=theirs)
        os.close(theirs)
        assert done.returncode == 0
        assert b"3/3" in terminal.read(10_000)
