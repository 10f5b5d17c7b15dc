"""`rsegen sheet` and `rsegen generate --sheet`, as people use them; what they do wrong is in tests/bad_input."""

from __future__ import annotations

from pathlib import Path

import pytest

import rsegen
from rsegen import CutSettings
from rsegen.cli.edge import main
from rsegen.input_files import JOURNAL
from rsegen.recipe.examples import EXAMPLES

PALLET = EXAMPLES["red-diagonal-pallet"]
RANDOM = ["--obstacle", "random levels=5", "--chunk-size", "4", "--seed", "7"]


def printed(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """Output of a command that succeeds; it says nothing on stderr."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


@pytest.mark.slow
def test_the_command_writes_the_bytes_of_python(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pdf, table = tmp_path / "new" / "s.PDF", tmp_path / "s.csv"
    out = printed(capsys, "sheet", PALLET, "-o", pdf, "--csv", table, "--kerf-mm", "2", "--stock-cm", "300")
    assert out == f"{pdf}: red-diagonal-pallet_0000, seed 1\n{table}: red-diagonal-pallet_0000, seed 1\n"
    scene, saw = rsegen.compose(rsegen.load(PALLET)), CutSettings(kerf_mm=2, stock_cm=300)
    assert pdf.read_bytes() == rsegen.sheet(scene, saw)
    assert table.read_bytes() == rsegen.sheet(scene, saw, "csv")


def test_the_ending_says_the_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "s.csv"
    printed(capsys, "sheet", "red-diagonal-pallet", "-o", path)
    assert path.read_text("utf-8").startswith("# build sheet of red-diagonal-pallet_0000 with seed 1\n")
    assert {each.name for each in tmp_path.iterdir()} == {path.name}


@pytest.mark.slow
def test_a_sheet_is_replaced_only_by_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "s.pdf"
    printed(capsys, "sheet", *RANDOM, "-o", path)
    before = path.read_bytes()
    assert main(["sheet", str(PALLET), "-o", str(path)]) == 2
    assert path.read_bytes() == before
    printed(capsys, "sheet", PALLET, "-o", path, "--force")
    assert path.read_bytes() != before


@pytest.mark.slow
@pytest.mark.long(reason="one map with its sheet in make test")
def test_generate_writes_the_sheets_of_the_command_into_every_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    worlds = tmp_path / "worlds"
    printed(capsys, "generate", *RANDOM, "--maps", "2", "--sheet", "-o", worlds)
    for index in range(2):
        folder = worlds / f"rse_000{index}"
        printed(
            capsys,
            "sheet",
            worlds,
            "--map",
            str(index),
            "-o",
            tmp_path / "s.pdf",
            "--csv",
            tmp_path / "s.csv",
            "--force",
        )
        for suffix in ("pdf", "csv"):
            assert (folder / f"sheet.{suffix}").read_bytes() == (tmp_path / f"s.{suffix}").read_bytes()


def test_without_the_flag_no_sheet_is_written_and_the_maps_are_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed(capsys, "generate", *RANDOM, "-o", tmp_path / "without")
    printed(capsys, "generate", *RANDOM, "--sheet", "-o", tmp_path / "with")
    without, with_ = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in (tmp_path / "without", tmp_path / "with")
    )
    added = {path.name for path in with_.keys() - without.keys()}
    assert added == {"sheet.csv", "sheet.pdf"}
    assert all(with_[path] == content for path, content in without.items() if path.name != JOURNAL)
