"""Exporting adds formats to the folders of maps, and never loses anything that was not named."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest

import rsegen
from rsegen import Recipe, Scene, export_maps
from rsegen.errors import OutputError, ParameterError, TooLarge, UserError, WriteError
from rsegen.formats.arrays import Arrays
from rsegen.formats.exports import plan_exports
from rsegen.formats.heightmap import Heightmap
from rsegen.formats.occupancy import Occupancy
from rsegen.input_files import JOURNAL
from rsegen.recipe.codec import to_json
from rsegen.writing import resources, swap, undo
from rsegen.writing.journal import OpenJournal
from rsegen.writing.plan import OnExisting
from tests.support.complaints import exit_code, snapshot, the_line
from tests.support.runs import contents

RECIPE = Recipe(seed=4, maps=2, chunk_size=4, obstacles=(rsegen.Random(levels=3),))


def formats_of(home: Path) -> dict[str, object]:
    found: dict[str, object] = json.loads((home / "formats.json").read_text("utf-8"))
    return found


def half_written(self: Occupancy, scene: Scene) -> Mapping[str, Iterator[bytes]]:
    def pieces() -> Iterator[bytes]:
        yield b"half"
        raise OSError(28, "No space left on device")

    return {"map.yaml": pieces()}


def test_formats_added_one_by_one_equal_one_export(tmp_path: Path) -> None:
    for format_ in (Heightmap(), Occupancy(climb_cm=12)):
        export_maps([RECIPE], tmp_path / "a", [format_])
    export_maps([RECIPE], tmp_path / "b", [Heightmap(), Occupancy(climb_cm=12)])
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_a_format_added_to_a_world_makes_the_world_that_has_it_from_the_start(tmp_path: Path) -> None:
    rsegen.generate(RECIPE, tmp_path / "a")
    stamps = {path: path.stat().st_ino for path in (tmp_path / "a").rglob("*")}
    made = export_maps([RECIPE], tmp_path / "a", [Heightmap()])
    rsegen.generate(RECIPE, tmp_path / "b", formats=[Heightmap()])
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert all(path.stat().st_ino == stamps[path] for path in stamps if path.name != JOURNAL)
    assert made[0].names == ("formats.json", "heightmap/heightmap.json", "heightmap/rse_0000.png")


def test_a_run_that_goes_on_tidies_the_journals_of_maps_that_were_complete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As they are if a run is killed after the last file of a map, and before its journal is written anew."""
    for name in ("a", "b"):
        rsegen.generate(RECIPE, tmp_path / name)
    with monkeypatch.context() as patch:
        patch.setattr(OpenJournal, "tidy", lambda _: None)
        export_maps([RECIPE], tmp_path / "a", [Heightmap()])
    export_maps([RECIPE], tmp_path / "b", [Heightmap()])
    assert contents(tmp_path / "a") != contents(tmp_path / "b")
    assert export_maps([RECIPE], tmp_path / "a", [Heightmap()], resume=True) == ()
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_a_world_with_an_added_format_is_complete_for_resume(tmp_path: Path) -> None:
    rsegen.generate(RECIPE, tmp_path)
    export_maps([RECIPE], tmp_path, [Heightmap()])
    assert rsegen.generate(RECIPE, tmp_path, formats=[Heightmap()], resume=True).already == (0, 1)


def test_the_command_adds_formats_to_a_folder_that_has_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("export", "peak", "--to", "heightmap", "-o", tmp_path) == 0
    capsys.readouterr()
    assert exit_code("export", "peak", "--to", "occupancy", "-o", tmp_path) == 0
    printed = capsys.readouterr().out.splitlines()
    home = tmp_path / "peak_0000"
    assert printed == [
        str(home / "formats.json"),
        *sorted(map(str, (home / "occupancy").iterdir())),
    ]
    assert list(formats_of(home)) == ["heightmap", "occupancy"]


def test_a_format_that_a_map_has_is_replaced_by_force_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rsegen.generate(RECIPE, tmp_path, formats=[Heightmap(), Occupancy()])
    (tmp_path / "rse_0000" / "notes.txt").write_text("mine")
    rsegen.save(RECIPE, tmp_path / "recipe.yaml")
    before = contents(tmp_path)
    command: list[str | Path] = ["export", tmp_path / "recipe.yaml", "--to", "heightmap pixels=2", "-o", tmp_path]
    assert exit_code(*command) == 2
    assert "rse_0000/heightmap: exists already; use --force to replace it" in the_line(capsys.readouterr().err)
    assert contents(tmp_path) == before
    assert exit_code(*command, "--force") == 0
    after = contents(tmp_path)
    changed = {name for name in before if before[name] != after[name]}
    assert after.keys() == before.keys()
    assert changed == {
        f"rse_000{index}/{name}"
        for index in range(2)
        for name in ("formats.json", JOURNAL, f"heightmap/rse_000{index}.png", "heightmap/heightmap.json")
    }
    assert formats_of(tmp_path / "rse_0000")["heightmap"] == Heightmap(pixels=2).options
    assert formats_of(tmp_path / "rse_0000")["occupancy"] == Occupancy().options


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("world", [False, True])
def test_formats_of_different_maps_are_not_mixed(tmp_path: Path, force: bool, world: bool) -> None:
    formats = [Heightmap(), Occupancy()]
    if world:
        rsegen.generate(RECIPE, tmp_path, formats=formats)
    else:
        export_maps([RECIPE], tmp_path, formats)
    before = snapshot(tmp_path)
    with pytest.raises(OutputError, match=r"rse_0000: .* another map"):
        export_maps([replace(RECIPE, seed=5)], tmp_path, [Heightmap()], force=force)
    assert snapshot(tmp_path) == before


def test_force_replaces_another_map_if_every_format_is_named(tmp_path: Path) -> None:
    other = replace(RECIPE, seed=5)
    export_maps([RECIPE], tmp_path / "a", [Heightmap(), Occupancy()])
    export_maps([other], tmp_path / "a", [Occupancy(), Heightmap(), Arrays()], force=True)
    export_maps([other], tmp_path / "b", [Occupancy(), Heightmap(), Arrays()])
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_a_recipe_file_of_another_version_is_the_same_map(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap()])
    file = tmp_path / "rse_0000" / "recipe.json"
    text = file.read_text("utf-8").replace(rsegen.__version__, "0.0.9")
    file.write_text(text, "utf-8")
    export_maps([RECIPE], tmp_path, [Occupancy()])
    assert file.read_text("utf-8") == text
    assert list(formats_of(tmp_path / "rse_0000")) == ["heightmap", "occupancy"]


@pytest.mark.parametrize("force", [False, True])
def test_foreign_files_are_never_replaced(tmp_path: Path, force: bool) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap()])
    home = tmp_path / "rse_0001"
    (home / "occupancy").mkdir()
    (home / "occupancy" / "thesis.tex").write_text("years of work")
    before = snapshot(tmp_path)
    with pytest.raises(OutputError, match=r"rse_0001/occupancy(/thesis.tex)?: was not written by rsegen"):
        export_maps([RECIPE], tmp_path, [Occupancy()], force=force)
    assert snapshot(tmp_path) == before


def test_a_damaged_list_of_formats_is_left_alone(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap()])
    (tmp_path / "rse_0001" / "formats.json").write_bytes(b"[")
    before = snapshot(tmp_path)
    with pytest.raises(OutputError, match=r"rse_0001/formats.json: is damaged"):
        export_maps([RECIPE], tmp_path, [Occupancy()], force=True)
    assert snapshot(tmp_path) == before


def test_resume_writes_a_format_anew_that_lost_a_file(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap(), Occupancy()])
    before = contents(tmp_path)
    (tmp_path / "rse_0001" / "heightmap" / "heightmap.json").unlink()
    (again,) = export_maps([RECIPE], tmp_path, [Heightmap(), Occupancy()], resume=True)
    assert again.folder.name == "rse_0001"
    assert not any("occupancy" in name for name in again.names)
    assert contents(tmp_path) == before


def test_a_plan_refuses_what_would_be_lost_before_a_map_is_made(tmp_path: Path) -> None:
    other = replace(RECIPE, seed=5)
    for name, file, recipe, chosen in (
        ("list", "formats.json", RECIPE, Occupancy()),  # valid, so that the format could be added to it
        ("map", "heightmap/heightmap.json", other, Heightmap()),
    ):
        export_maps([RECIPE], tmp_path / name, [Heightmap()])
        plan_exports([recipe], tmp_path / name, [chosen], OnExisting.REPLACE)
        with (tmp_path / name / "rse_0001" / file).open("ab") as changed:
            changed.write(b" ")
        with pytest.raises(OutputError, match=rf"rse_0001/{file}: was changed after rsegen wrote it"):
            plan_exports([recipe], tmp_path / name, [chosen], OnExisting.REPLACE)


@pytest.mark.parametrize("force", [False, True])
def test_a_format_that_fails_on_the_way_leaves_all_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, force: bool
) -> None:
    rsegen.generate(RECIPE, tmp_path, formats=[Occupancy()] if force else [])
    before = contents(tmp_path)
    monkeypatch.setattr(Occupancy, "files", half_written)
    with pytest.raises(WriteError, match="nothing was changed"):
        export_maps([RECIPE], tmp_path, [Heightmap(), Occupancy()], force=force)
    assert contents(tmp_path) == before
    assert not list(tmp_path.rglob(".rsegen"))


@pytest.mark.parametrize("swaps", range(4))
def test_a_run_that_is_stopped_between_two_swaps_leaves_all_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, swaps: int
) -> None:
    """Two formats, and formats.json, which also is there already."""
    rsegen.generate(RECIPE, tmp_path, formats=[Heightmap(), Occupancy()])
    before, exchange, done = contents(tmp_path), swap.exchange, list[Path]()

    def stopped(new: Path, place: Path, aside: Path) -> None:
        done.append(place)
        if len(done) == swaps + 1:
            raise KeyboardInterrupt
        exchange(new, place, aside)

    monkeypatch.setattr(undo, "exchange", stopped)
    formats = [Heightmap(pixels=2), Occupancy(climb_cm=12)]
    if swaps < 3:
        with pytest.raises(KeyboardInterrupt):
            export_maps([replace(RECIPE, maps=1)], tmp_path, formats, force=True)
        assert contents(tmp_path) == before
    else:
        export_maps([replace(RECIPE, maps=1)], tmp_path, formats, force=True)
        assert contents(tmp_path) != before
    assert not list(tmp_path.rglob(".rsegen"))


def test_a_format_that_was_being_replaced_when_all_was_killed_comes_back(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path / "a", [Heightmap(), Occupancy()])
    aside = tmp_path / "a" / ".rsegen" / "old" / "2" / "rse_0000"
    aside.mkdir(parents=True)
    (tmp_path / "a" / "rse_0000" / "heightmap").rename(aside / "heightmap")
    export_maps([RECIPE], tmp_path / "a", [Heightmap()], force=True)
    export_maps([RECIPE], tmp_path / "b", [Heightmap(), Occupancy()])
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_a_run_that_was_killed_after_its_last_rename_leaves_nothing_to_the_next(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap()])
    before = contents(tmp_path)
    (tmp_path / "rse_0000" / ".rsegen.0123abcd" / "new").mkdir(parents=True)
    assert export_maps([RECIPE], tmp_path, [Heightmap()], resume=True) == ()
    assert contents(tmp_path) == before
    assert not list(tmp_path.rglob(".rsegen"))


def test_workers_add_the_same_formats(tmp_path: Path) -> None:
    many = replace(RECIPE, maps=120)
    for workers in (1, 2):
        export_maps([many], tmp_path / str(workers), [Heightmap()])
        export_maps([many], tmp_path / str(workers), [Occupancy()], workers=workers)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def refused_exports(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, type[UserError]]]:
    """Every check of an export, made to fail."""
    (folder / "file").write_text("")
    yield "file", OutputError
    rsegen.generate(replace(RECIPE, seed=9), folder / "another")
    yield "another", OutputError
    (folder / "foreign" / "rse_0001").mkdir(parents=True)
    (folder / "foreign" / "rse_0001" / "thesis.tex").write_text("years of work")
    yield "foreign", OutputError
    rsegen.generate(RECIPE, folder / "linked")
    shutil.move(folder / "linked" / "rse_0001", folder / "elsewhere")
    (folder / "linked" / "rse_0001").symlink_to(folder / "elsewhere")
    yield "linked", OutputError
    monkeypatch.setattr(resources, "_free_memory", lambda: 10)
    yield "new", TooLarge
    monkeypatch.undo()
    monkeypatch.setattr(resources, "_free_disk", lambda _: 10)
    yield "new", TooLarge


def test_a_check_that_fails_leaves_nothing_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, error in refused_exports(tmp_path, monkeypatch):
        before = snapshot(tmp_path)
        with pytest.raises(error):
            export_maps([RECIPE], tmp_path / name, [Heightmap()], force=True)
        assert snapshot(tmp_path) == before
    with pytest.raises(ParameterError, match="heightmap is given twice"):
        export_maps([RECIPE], tmp_path / "new", [Heightmap(), Heightmap()])
    assert not (tmp_path / "new").exists()


def test_the_recipe_of_a_map_is_its_own(tmp_path: Path) -> None:
    export_maps([RECIPE], tmp_path, [Heightmap()])
    for index in RECIPE.indices:
        expected = to_json(RECIPE.alone(index))
        assert (tmp_path / RECIPE.map_name(index) / "recipe.json").read_text("utf-8") == expected
