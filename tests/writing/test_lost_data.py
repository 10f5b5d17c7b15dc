"""No command destroys what rsegen did not write: files of others, changed files, and what links lead to."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

import rsegen
from rsegen.errors import FileError, FilesDamaged, OutputError
from rsegen.formats.heightmap import Heightmap
from rsegen.input_files import JOURNAL
from rsegen.writing.journal import read_journal
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.runs import contents

OBSTACLE = ["--obstacle", "random levels=5", "--chunk-size", "4", "--seed", "7"]
WORK = "years of work"


def refused(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: str | Path) -> str:
    """The one line of a command that writes nothing."""
    before = snapshot(folder)
    capsys.readouterr()
    assert exit_code(*arguments) == 2
    assert snapshot(folder) == before
    return the_line(capsys.readouterr().err)


@pytest.fixture
def world(tmp_path: Path) -> Path:
    """The folder of a map."""
    assert exit_code("generate", *OBSTACLE, "-o", tmp_path) == 0
    return tmp_path / "rse_0000"


@pytest.mark.parametrize("name", ["notes.txt", "meshes/texture.png", "deep/er/notes.txt"])
def test_force_keeps_a_map_with_a_file_of_somebody_else(
    world: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    (world / name).parent.mkdir(parents=True, exist_ok=True)
    (world / name).write_text(WORK)
    line = refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, "--force")
    assert f"{world / name}: was not written by rsegen, and would be overwritten" in line


def test_force_keeps_a_map_that_was_changed(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = world / "rse_0000.world"
    file.write_text(file.read_text("utf-8").replace("<gravity>", "<gravity><!-- moon -->"), "utf-8")
    file.write_bytes(file.read_bytes() + b"\n")
    for flag in ("--force", "--resume"):
        line = refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, flag)
        assert f"{file}: was changed after rsegen wrote it" in line


@pytest.mark.parametrize("inside", ["recipe.json", "meshes"])
def test_force_keeps_a_map_with_a_link_in_it(world: Path, capsys: pytest.CaptureFixture[str], inside: str) -> None:
    elsewhere = world.parent / "elsewhere"
    (world / inside).rename(elsewhere)
    (world / inside).symlink_to(elsewhere)
    assert "was" in refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, "--force")


def test_any_folder_with_a_recipe_in_it_is_not_a_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    home = tmp_path / "rse_0000"
    home.mkdir()
    (home / "recipe.json").write_text('{"ingredients": ["flour"]}')
    commands: list[list[str | Path]] = [
        ["generate", *OBSTACLE],
        ["series", *OBSTACLE, "--maps", "2", "--name", "rse"],
        ["export", *OBSTACLE, "--to", "stl"],
    ]
    for command in commands:
        line = refused(capsys, tmp_path, *command, "-o", tmp_path, "--force")
        assert f"{home / 'recipe.json'}: was not written by rsegen" in line


@pytest.mark.parametrize("flag", ["--force", "--resume"])
def test_a_map_without_a_journal_is_not_replaced(world: Path, capsys: pytest.CaptureFixture[str], flag: str) -> None:
    (world / JOURNAL).unlink()
    (world / "rse_0000.world").write_text(WORK)
    assert str(world) in refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, flag)


def test_a_picture_next_to_an_empty_recipe_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    home = tmp_path / "rse_0000"
    home.mkdir()
    (home / "recipe.json").write_text("")
    (home / "preview.png").write_text(WORK)
    for flag in ("--force", "--resume"):
        assert str(home) in refused(capsys, tmp_path, "generate", *OBSTACLE, "-o", tmp_path, flag, "--preview")


SINGLE_FILES: dict[str, list[str]] = {
    "preview": ["peak", "-o", "a.png"],
    "view": ["peak", "-o", "a.html"],
    "sheet": ["peak", "-o", "a.pdf", "--csv", "a.csv"],
    "metrics": ["peak", "--climb-cm", "10", "-o", "a.svg"],
    "examples": ["-o", "."],
}


@pytest.mark.slow
@pytest.mark.parametrize("command", SINGLE_FILES)
def test_a_single_file_leaves_nothing_next_to_it_and_is_replaced_by_force_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = [command, *SINGLE_FILES[command]]
    assert exit_code(*arguments) == 0
    made = sorted(path.name for path in tmp_path.iterdir())
    names = [name for name in arguments if name.startswith("a.")]
    assert made == sorted(names) if names else all(name.endswith(".yaml") for name in made)
    (tmp_path / made[0]).write_text(WORK)
    assert "exists already" in refused(capsys, tmp_path, *arguments)
    assert exit_code(*arguments, "--force") == 0
    assert (tmp_path / made[0]).read_bytes() != WORK.encode()
    assert sorted(path.name for path in tmp_path.iterdir()) == made


def test_a_data_set_that_cannot_be_made_leaves_the_old_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("dataset", *OBSTACLE, "--maps", "30", "-o", tmp_path) == 0
    cannot = ["--obstacle", "random levels=5 counts=50,0,0,0,50 max_step=1", "--seed", "2", "--maps", "50"]
    assert "no order of these blocks" in refused(capsys, tmp_path, "dataset", *cannot, "-o", tmp_path, "--force")
    assert exit_code("dataset", *OBSTACLE, "--maps", "20", "-o", tmp_path, "--force") == 0
    assert len(rsegen.Dataset(tmp_path)) == 20


@pytest.mark.parametrize("flag", ["--force", "--resume"])
@pytest.mark.parametrize("name", ["levels-00000.npy", "metrics-00000.npy", "manifest.json"])
def test_a_data_set_keeps_a_file_that_its_owner_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, flag: str
) -> None:
    assert exit_code("dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path) == 0
    (tmp_path / name).write_text(WORK)
    line = refused(capsys, tmp_path, "dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path, flag)
    assert f"{name}: was changed after rsegen wrote it" in line


@pytest.mark.parametrize("kind", ["symbolic", "hard", "dangling"])
@pytest.mark.parametrize("flag", ["--force", "--resume"])
@pytest.mark.parametrize("name", [".rsegen.jsonl", "manifest.json", "levels-00000.npy"])
def test_a_data_set_overwrites_no_link(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, flag: str, name: str
) -> None:
    victim, folder = tmp_path / "victim", tmp_path / "w"
    folder.mkdir()
    if kind != "dangling":
        victim.write_text(WORK)
    (os.link if kind == "hard" else os.symlink)(victim, folder / name)
    line = refused(capsys, tmp_path, "dataset", *OBSTACLE, "--maps", "3", "-o", folder, flag)
    assert str(folder) in line


def test_a_stopped_data_set_is_continued_and_hard_links_stay(tmp_path: Path) -> None:
    folder, copy = tmp_path / "w", tmp_path / "backup"
    assert exit_code("dataset", *OBSTACLE, "--maps", "3", "-o", folder) == 0
    copy.mkdir()
    for path in folder.iterdir():
        os.link(path, copy / path.name)
    before = snapshot(copy)
    assert exit_code("dataset", *OBSTACLE[:-1], "8", "--maps", "3", "-o", folder, "--force") == 0
    assert snapshot(copy) == before


def test_a_data_set_keeps_a_shard_that_is_not_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path) == 0
    (tmp_path / "levels-00009.npy").write_text(WORK)
    line = refused(capsys, tmp_path, "dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path, "--force")
    assert "levels-00009.npy: was not written by rsegen" in line


@pytest.mark.parametrize("flag", ["--force", "--resume"])
@pytest.mark.parametrize("name", [".rsegen.jsonl", "manifest.json", "levels-00000.npy", "metrics-00000.npy"])
@pytest.mark.parametrize("kind", ["pipe", "folder", "link to a device"])
def test_a_data_set_keeps_and_waits_for_nothing_that_is_no_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, name: str, flag: str
) -> None:
    assert exit_code("dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path / "set") == 0
    path = tmp_path / "set" / name
    path.unlink(missing_ok=True)
    {"pipe": os.mkfifo, "folder": os.mkdir, "link to a device": lambda path: path.symlink_to("/dev/zero")}[kind](path)
    refused(capsys, tmp_path, "dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path / "set", flag)


@pytest.mark.parametrize("flag", ["--force", "--resume"])
def test_a_map_whose_recipe_is_a_pipe_is_refused_at_once(
    world: Path, capsys: pytest.CaptureFixture[str], flag: str
) -> None:
    (world / "recipe.json").unlink()
    os.mkfifo(world / "recipe.json")
    assert "rse_0000" in refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, flag)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["series.csv", "series.png"])
def test_a_series_keeps_a_table_of_somebody_else(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    command: list[str | Path] = ["series", *OBSTACLE, "--maps", "2", "-o", tmp_path / "out", "--force"]
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text(WORK)
    assert f"{name}: was not written by rsegen" in refused(capsys, tmp_path, *command)
    (tmp_path / "out" / name).unlink()
    assert exit_code(*command) == 0
    assert exit_code(*command) == 0
    (tmp_path / "out" / name).write_text(WORK)
    assert f"{name}: was changed after rsegen wrote it" in refused(capsys, tmp_path, *command)


@pytest.mark.parametrize("target", ["there", "nowhere"])
def test_a_file_that_is_a_link_is_not_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str], target: str) -> None:
    (tmp_path / "there").write_text(WORK)
    (tmp_path / "a.png").symlink_to(tmp_path / target)
    line = refused(capsys, tmp_path, "preview", "peak", "-o", tmp_path / "a.png", "--force")
    assert "a.png: is a link, so it is not replaced" in line


def test_a_file_that_rsegen_adds_to_a_map_is_its_own(world: Path) -> None:
    assert exit_code("preview", world, "-o", world / "large.png") == 0
    journal = read_journal(world)
    assert journal
    assert "large.png" in journal.files
    assert exit_code("generate", *OBSTACLE, "-o", world.parent, "--force") == 0
    assert not (world / "large.png").exists()


def test_a_map_is_not_a_drive(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(OutputError, match="contains a map, not a drive"):
        rsegen.drive(str(world), output=world, force=True)
    before = snapshot(world)
    assert exit_code("drive", world, "-o", world, "--force") == 2
    assert snapshot(world) == before
    assert the_line(capsys.readouterr().err)


def test_a_folder_of_maps_is_not_a_drive(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, world.parent, "drive", world, "-o", world.parent, "--force")
    assert f"contains a map in {world.name}" in line


def test_export_adds_to_a_map_with_files_of_somebody_else_and_loses_none(world: Path) -> None:
    (world / "notes.txt").write_text(WORK)
    for force in (False, True):
        rsegen.export_maps([rsegen.load(world / "recipe.json")], world.parent, [Heightmap()], force=force)
    assert (world / "notes.txt").read_text() == WORK


# A power failure.


@pytest.mark.parametrize("flags", [[], ["--no-sync"]])
def test_a_map_with_empty_files_is_made_again(tmp_path: Path, flags: list[str]) -> None:
    command: list[str | Path] = ["generate", *OBSTACLE, "--maps", "3", *flags]
    assert exit_code(*command, "-o", tmp_path / "whole") == 0
    assert exit_code(*command, "-o", tmp_path / "cut") == 0
    (tmp_path / "cut" / "rse_0000" / "rse_0000.world").write_bytes(b"")
    for path in (tmp_path / "cut" / "rse_0001").rglob("[a-z]*.*"):
        path.write_bytes(b"")
    (tmp_path / "cut" / "rse_0002" / "meshes" / "rse_0002.obj").unlink()
    assert exit_code(*command, "-o", tmp_path / "cut", "--resume") == 0
    assert snapshot(tmp_path / "cut") == snapshot(tmp_path / "whole")


def test_info_verify_compares_every_file(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (world / "notes.txt").write_text(WORK)
    capsys.readouterr()
    for folder in (world, world.parent):
        assert exit_code("info", folder, "--verify") == 0
        out = capsys.readouterr().out
        assert out.endswith(f"in 1 folder as rsegen wrote them\nnot written by rsegen: {world / 'notes.txt'}\n")
    assert exit_code("info", world, "--verify", "--json") == 0
    assert json.loads(capsys.readouterr().out)["unlisted"] == [str(world / "notes.txt")]
    (world / "levels.csv").write_bytes(b"")
    assert exit_code("info", world, "--verify") == 1
    assert "levels.csv: is missing or empty" in the_line(capsys.readouterr().err)
    (world / "levels.csv").write_bytes(b"1")
    with pytest.raises(FilesDamaged, match=r"levels.csv: was changed"):
        rsegen.verify(world)


def test_info_verify_compares_series_and_data_sets(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("series", *OBSTACLE, "--maps", "2", "-o", tmp_path / "series") == 0
    assert exit_code("dataset", *OBSTACLE, "--maps", "3", "-o", tmp_path / "set") == 0
    capsys.readouterr()
    assert exit_code("info", tmp_path / "series", "--verify") == 0
    assert "in 3 folders as rsegen wrote them" in capsys.readouterr().out
    assert exit_code("info", tmp_path / "set", "--verify") == 0
    assert "3 files in 1 folder as" in capsys.readouterr().out
    (tmp_path / "set" / "levels-00000.npy").write_bytes(b"1")
    assert exit_code("info", tmp_path / "set", "--verify") == 1


@pytest.mark.parametrize("target", ["peak", "."])
def test_info_verify_needs_a_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], target: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code("info", target, "--verify") == 2
    assert the_line(capsys.readouterr().err)


BEGIN = '{"rsegen_journal": 1, "holds": "map"}\n'
JOURNALS = {
    "empty": "",
    "cut off": BEGIN[:-1],
    "no JSON": "{\n",
    "a list": "[]\n",
    "another format": '{"rsegen_journal": 2, "holds": "map"}\n',
    "of nothing": '{"rsegen_journal": 1}\n',
    "a path that leads out": BEGIN + '{"file": "../x", "bytes": 1, "sha256": ""}\n',
    "files of another type": BEGIN + '{"file": 17}\n',
    "lines of another type": BEGIN + "17\n",
    "deep": "[" * 100_000 + "\n",
    "another key": '{"rsegen_journal": 1, "holds": "map", "crc33": "00000000"}\n',
    "a wrong checksum": '{"rsegen_journal": 1, "holds": "map", "crc32": "00000000"}\n',
}


@pytest.mark.parametrize("text", JOURNALS.values(), ids=JOURNALS.keys())
def test_with_a_damaged_journal_nothing_is_replaced(world: Path, capsys: pytest.CaptureFixture[str], text: str) -> None:
    (world / JOURNAL).write_text(text)
    for flag in ("--force", "--resume"):
        line = refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, flag)
        assert f"{JOURNAL}: is not a journal of rsegen, or is damaged" in line
    assert JOURNAL in refused(capsys, world.parent, "info", world, "--verify")


def test_each_byte_of_a_journal_that_changes_is_noticed(world: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its checksums notice it in any byte; nothing is replaced then, and once the folder is moved away all goes on."""
    journal, whole = world / JOURNAL, contents(world)
    text = journal.read_bytes()
    for at, byte in enumerate(text):
        for changed in {byte ^ 1, byte ^ 0x20, byte ^ 0xFF, *b'\n "'} - {byte}:
            journal.write_bytes(text[:at] + bytes([changed]) + text[at + 1 :])
            with pytest.raises(FileError, match=f"{JOURNAL}: is not a journal of rsegen, or is damaged"):
                read_journal(world)
        if at % 20 == 0 or at == len(text) - 1:
            assert JOURNAL in refused(capsys, world.parent, "info", world, "--verify")
            for flag in ("--force", "--resume"):
                line = refused(capsys, world.parent, "generate", *OBSTACLE, "-o", world.parent, flag)
                assert "move the folder away, or use another one" in line
    world.rename(world.with_name("away"))
    assert exit_code("generate", *OBSTACLE, "-o", world.parent, "--resume") == 0
    assert contents(world) == whole


# What a stopped export goes on with.


def test_a_stopped_export_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command: list[str | Path] = ["export", *OBSTACLE, "--maps", "3", "--to", "stl,heightmap"]
    assert exit_code(*command, "-o", tmp_path / "whole") == 0
    assert exit_code("export", *OBSTACLE, "--maps", "2", "--to", "stl", "-o", tmp_path / "cut") == 0
    assert exit_code(*command, "--maps", "1", "-o", tmp_path / "cut", "--resume") == 0
    capsys.readouterr()
    assert exit_code(*command, "-o", tmp_path / "cut", "--resume") == 0
    assert capsys.readouterr().out.startswith("1 map complete already\n2 maps:")
    assert snapshot(tmp_path / "cut") == snapshot(tmp_path / "whole")
    assert exit_code(*command, "-o", tmp_path / "cut", "--resume") == 0
    assert capsys.readouterr().out == "3 maps complete already\n"
    assert exit_code(*command[:-1], "stl,heightmap pixels=2", "-o", tmp_path / "cut", "--resume") == 0
    assert snapshot(tmp_path / "cut") != snapshot(tmp_path / "whole")
