"""`rsegen info --verify` notices a change in every file of each kind of output, and all over the journal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.errors import FileError, FilesDamaged
from rsegen.input_files import JOURNAL
from rsegen.writing.journal import read_journal
from tests.fuzz.seeds import cloud
from tests.support.complaints import exit_code, the_line
from tests.support.long import long_unless

RECIPE = "seed: 3\nname: field\nchunk_size: 3\nmaps: 2\nobstacles:\n  - {kind: random, levels: 3}\n"
KINDS: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "maps with all beside them": (
        ["generate", "field.yaml", "--preview", "--sheet", "--formats", "stl,heightmap"],
        ["model.sdf", "levels.csv", "recipe.json", "preview.png", "sheet.pdf", ".stl", ".obj"],
    ),
    "series": (["series", "field.yaml"], ["series.csv", "series.png", "model.sdf"]),
    "terrain": (["terrain", "peak", "--rows", "2", "--columns", "2"], ["terrain_0000.json", "levels.csv"]),
    "meshes": (["export", "field.yaml", "--to", "stl", "--to", "ply", "--to", "mjcf"], [".stl", ".ply", ".xml"]),
    "ROS package": (["export", "field.yaml", "--to", "ros2"], ["package.xml", ".launch.py", ".mtl"]),
    "data set": (
        ["dataset", "field.yaml", "--maps", "20", "--shard-maps", "5"],
        ["manifest.json", "levels-00003.npy", "metrics-00000.npy"],
    ),
    "heights": (["import", "heights.csv", "--unit-cm", "10", "--values", "cm"], ["model.sdf", "levels.csv"]),
    "scan": (["scan", "cloud.xyz", "--block-width-cm", "10"], ["confidence.csv", "fit.png", "model.sdf"]),
    "drive": (
        ["drive", "field.yaml", "--no-predict", "--duration", "0.2"],
        ["drive.json", "recipe.json", "drive.png", ".csv"],
    ),
    "drives": (
        ["drives", "field.yaml", "--duration", "0.2", "--workers", "1"],
        ["drives.csv"],
    ),
    "rating": (
        ["rate", "burger", "--by", "prediction", "--trials", "8", "--chunk-size", "3", "--workers", "1", "--seed", "3"],
        ["rating.json"],
    ),
}
"""Command -> ends of names of files that it writes, of which some must be there."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", long_unless({"series", "meshes", "data set", "drive"}.__contains__, KINDS, reason="a kind of output more")
)
def test_a_byte_that_changes_in_any_file_is_noticed(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "field.yaml").write_text(RECIPE)
    (tmp_path / "heights.csv").write_text("0,10,20\n10,20,0\n")
    np.savetxt(tmp_path / "cloud.xyz", cloud(np.random.default_rng(3)), fmt="%.4f")
    command, wanted = KINDS[kind]
    assert exit_code(*command, "-o", "out") == 0
    folder = tmp_path / "out"
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != JOURNAL]
    for end in wanted:
        assert any(path.name.endswith(end) for path in files), (end, files)
    assert rsegen.verify(folder).files == len(files), "each file is listed once"
    assert rsegen.verify(folder).unlisted == ()
    for path in files:
        content = path.read_bytes()
        for at in sorted({0, len(content) // 2, len(content) - 1}):
            path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
            with pytest.raises(FilesDamaged, match="was changed") as noticed:
                rsegen.verify(folder)
            assert str(path) in str(noticed.value)
        path.write_bytes(content[:-1])
        with pytest.raises(FilesDamaged, match=r"was changed|is missing or empty"):
            rsegen.verify(folder)
        path.write_bytes(content)
    capsys.readouterr()
    for journal in folder.rglob(JOURNAL):
        content = journal.read_bytes()
        for at in range(0, len(content), 1 + len(content) // 1000):
            journal.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
            with pytest.raises(FileError, match="is damaged"):
                read_journal(journal.parent)
        with pytest.raises(FileError, match="is damaged"):
            rsegen.verify(folder)
        journal.write_bytes(content)
    files[0].unlink()
    assert exit_code("info", "out", "--verify") == 1
    assert "is missing or empty" in the_line(capsys.readouterr().err)
