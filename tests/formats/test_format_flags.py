"""Formats with their options after their names, as in --to stl,'mjcf shape=hfield'."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.params import extras
from rsegen.params.extras import pip_install
from tests.support.complaints import exit_code, the_line


def options(folder: Path, *flags: str) -> dict[str, object]:
    """The formats that an export wrote, with their options."""
    assert main(["export", "peak", *flags, "-o", str(folder)]) == 0
    found: dict[str, object] = json.loads((folder / "peak_0000" / "formats.json").read_text("utf-8"))
    return found


HFIELD = {"shape": "hfield", "pixels": 4, "priority": 10}


@pytest.mark.parametrize(
    "flags",
    [
        ["--to", "heightmap,mjcf shape=hfield pixels=4"],
        ["--to", "heightmap mjcf shape=hfield pixels=4"],
        ["--to", "heightmap", "--to", "mjcf shape=hfield pixels=4"],
        ["--to", "mjcf pixels=4 shape=hfield, heightmap"],
        ["--to", "mjcf pixels='4' shape=\"hfield\",heightmap pixels=1"],
    ],
)
def test_options_stand_after_the_name_of_their_format(flags: list[str], tmp_path: Path) -> None:
    assert options(tmp_path, *flags) == {"mjcf": HFIELD, "heightmap": {"pixels": 1}}


def test_generate_takes_options_after_names_too(tmp_path: Path) -> None:
    assert main(["generate", "peak", "--formats", "heightmap pixels=2", "-o", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "peak_0000" / "formats.json").read_text("utf-8"))
    assert found == {"heightmap": {"pixels": 2}}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("stl shape=box", ["--to 'stl shape=box': unknown option of stl 'shape' (there is none)"]),
        ("mjcf shap=hfield", ["--to 'mjcf shap=hfield': unknown option of mjcf 'shap'; did you mean 'shape'?"]),
        ("mjcf shape=round", ["--to 'mjcf shape=round': shape: 'round' is not one of boxes, hfield, mesh"]),
        ("mjcf shape=hfield shape=mesh", ["shape: is given twice"]),
        ("mjcf,mjcf", ["--to: mjcf is given twice"]),
        ("mjfc", ["--to: unknown format 'mjfc'; did you mean 'mjcf'?"]),
        ("obj", ["--to: unknown format 'obj'; rsegen generate writes meshes as OBJ"]),
        ("sdf", ["--to: unknown format 'sdf'; rsegen generate writes worlds and models in SDF"]),
        ("numpy", ["did you mean 'arrays'?"]),
        ("MuJoCo", ["did you mean 'mjcf'?"]),
        ("png", ["did you mean 'heightmap'?"]),
        ("shape=hfield", ["--to: unknown format 'shape=hfield'"]),
        ("", ["--to: unknown format ''"]),
        ("heightmap,", ["--to: unknown format ''"]),
        ("heightmap pixels='1", ["a quotation mark is not closed"]),
    ],
)
def test_a_mistake_is_one_line(
    text: str, words: Sequence[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("export", "peak", "--to", text, "-o", tmp_path / "out") == 2
    line = the_line(capsys.readouterr().err)
    assert [word for word in words if word not in line] == []
    assert not (tmp_path / "out").exists()


def test_the_help_names_every_format(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("export", "--help") == 0
    words = set(re.findall(r"\w+", capsys.readouterr().out))
    assert set(rsegen.FORMATS) <= words


def test_everything_that_is_missing_is_named_at_once_with_this_pythons_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda module: None)
    assert exit_code("export", "peak", "--to", "stl,heightmap,usd,glb", "-o", tmp_path / "out") == 2
    line = the_line(capsys.readouterr().err)
    assert line == (f"rsegen: stl, usd, glb need trimesh, pxr, which are not installed; {pip_install(['mesh', 'usd'])}")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "file", "other"), [("arrays", "levels.mat", "levels.npy"), ("posture", "posture.mat", "raster.npy")]
)
def test_without_scipy_all_but_the_mat_file_is_written_with_a_note(
    name: str,
    file: str,
    other: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda module: None)
    assert exit_code("export", "peak", "--to", name, "-o", tmp_path) == 0
    line = the_line(capsys.readouterr().err)
    assert line == f"rsegen: {name}: {file} is left out, as scipy is not installed; {pip_install(['mat'])}"
    folder = tmp_path / "peak_0000" / name
    assert (folder / other).is_file()
    assert not (folder / file).exists()
    assert not any(file in path.read_text("utf-8") for path in folder.glob("*.json"))


def test_the_extra_all_has_every_other_extra() -> None:
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text("utf-8")
    _, _, table = text.partition("[project.optional-dependencies]\n")
    rows = [line.partition(" = ") for line in table.partition("\n\n")[0].splitlines() if " = [" in line]
    extras = {name: value for name, _, value in rows}
    assert extras.pop("all") == f'["rsegen[{",".join(sorted(extras))}]"]'
