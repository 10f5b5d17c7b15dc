"""rsegen export, and rsegen generate --formats, as people use them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import rsegen
from rsegen import Recipe, Scene
from rsegen.cli.edge import main
from rsegen.errors import OutputError, WriteError
from rsegen.formats.base import FORMATS
from rsegen.formats.heightmap import Heightmap
from rsegen.formats.occupancy import Occupancy
from rsegen.params.registry import summary_of_class
from rsegen.writing.plan import existing_maps
from rsegen.writing.sidecars import are_complete, chosen_sidecars
from tests.formats.maps import RECIPES
from tests.support.complaints import exit_code
from tests.support.runs import contents

SMALL = replace(RECIPES["frames round every chunk"], maps=3)
TO = ["--to", "heightmap,occupancy", "-o"]


@pytest.fixture
def recipe_file(tmp_path: Path) -> Path:
    rsegen.save(SMALL, tmp_path / "recipe.yaml")
    return tmp_path / "recipe.yaml"


def test_a_recipe_a_map_and_a_folder_of_maps_give_the_same_files(tmp_path: Path, recipe_file: Path) -> None:
    rsegen.generate(SMALL, tmp_path / "worlds")
    assert exit_code("export", recipe_file, *TO, tmp_path / "a") == 0
    assert exit_code("export", tmp_path / "worlds", *TO, tmp_path / "b") == 0
    for index in range(3):
        assert exit_code("export", tmp_path / "worlds" / f"rse_000{index}", *TO, tmp_path / "c") == 0
        assert exit_code("export", recipe_file, "--map", str(index), *TO, tmp_path / "d") == 0
    assert len(list((tmp_path / "a").iterdir())) == 3
    assert contents(tmp_path / "a") == contents(tmp_path / "b") == contents(tmp_path / "c") == contents(tmp_path / "d")


def test_an_example_is_exported_by_its_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("export", "peak", *TO, tmp_path) == 0
    said = capsys.readouterr().out.splitlines()
    assert said == [str(path) for path in sorted(tmp_path.rglob("[!.]*")) if path.is_file()]


def test_json_names_every_file(tmp_path: Path, recipe_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("export", recipe_file, *TO, tmp_path / "out", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in told] == ["rse_0000", "rse_0001", "rse_0002"]
    assert {name for one in told for name in one["files"]} == {
        str(path) for path in (tmp_path / "out").rglob("[!.]*") if path.is_file()
    }


def test_the_list_describes_each_format_and_needs_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("export", "--list") == 0
    told = capsys.readouterr().out
    assert all(f"{name}\n    {summary_of_class(cls)}" in told for name, cls in FORMATS.items())
    assert "    per_block= " in told


def test_two_maps_of_one_name_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    rsegen.generate(SMALL, tmp_path / "worlds")
    (tmp_path / "worlds" / "rse_0001").rename(tmp_path / "worlds" / "copy")
    rsegen.generate(replace(SMALL, maps=2, seed=9, first_map=1), tmp_path / "others")
    (tmp_path / "others" / "rse_0001").rename(tmp_path / "worlds" / "rse_0001")
    assert exit_code("export", tmp_path / "worlds", *TO, tmp_path / "out") == 2
    assert not (tmp_path / "out").exists()


def test_a_map_is_complete_or_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: Occupancy, scene: Scene) -> Mapping[str, Iterator[bytes]]:
        def pieces() -> Iterator[bytes]:
            yield b"half"
            if scene.index == 1:
                raise OSError(28, "No space left on device")

        return {"map.yaml": pieces()}

    monkeypatch.setattr(Occupancy, "files", broken)
    with pytest.raises(WriteError, match="1 of 3 maps are complete"):
        rsegen.export_maps([SMALL], tmp_path, [Heightmap(), Occupancy()])
    assert [path.name for path in tmp_path.iterdir()] == ["rse_0000"]


def generated(folder: Path, *flags: str) -> int:
    recipe = folder.with_suffix(".json")
    rsegen.save(SMALL, recipe, force=True)
    return main(["generate", str(recipe), "-o", str(folder), *flags])


def test_resume_keeps_maps_that_have_the_formats_and_makes_the_others_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "worlds"
    assert generated(folder, "--formats", "heightmap,occupancy") == 0
    before = contents(folder)
    for fewer in ([], ["--formats", "heightmap"], ["--formats", "occupancy,heightmap pixels=1"]):
        capsys.readouterr()
        assert generated(folder, "--resume", *fewer) == 0
        assert capsys.readouterr().out == "3 maps already exist, seed 4\n"
    assert contents(folder) == before
    assert generated(folder, "--resume", "--formats", "heightmap pixels=2") == 0
    assert "3 maps of" in capsys.readouterr().out
    again = contents(folder)
    assert again["rse_0000/heightmap/rse_0000.png"] != before["rse_0000/heightmap/rse_0000.png"]
    # The other format of the earlier run is kept, to the byte.
    assert generated(tmp_path / "plain", "--formats", "heightmap pixels=2,occupancy") == 0
    assert contents(tmp_path / "plain") == again


def test_resume_makes_worlds_of_maps_that_were_exported_alone(tmp_path: Path) -> None:
    rsegen.export_maps([SMALL], tmp_path / "worlds", [Heightmap()])
    assert existing_maps(SMALL, tmp_path / "worlds", partial(are_complete, ())) == []
    assert generated(tmp_path / "worlds", "--resume") == 0
    assert generated(tmp_path / "plain", "--formats", "heightmap") == 0
    assert contents(tmp_path / "worlds") == contents(tmp_path / "plain")


def test_resume_with_another_format_keeps_the_picture_and_the_formats_of_an_earlier_run(tmp_path: Path) -> None:
    folder = tmp_path / "worlds"
    assert generated(folder, "--maps", "1", "--preview", "--formats", "heightmap") == 0
    before = contents(folder)
    assert generated(folder, "--maps", "2", "--resume", "--formats", "occupancy", "--json") == 0
    after = contents(folder)
    added = {"formats.json", ".rsegen.jsonl"}
    kept = {name: content for name, content in before.items() if Path(name).name not in added}
    assert kept.items() <= after.items()
    assert list(json.loads(after["rse_0000/formats.json"])) == ["heightmap", "occupancy"]
    assert list(json.loads(after["rse_0001/formats.json"])) == ["occupancy"]
    rsegen.verify(folder)
    assert generated(tmp_path / "plain", "--maps", "1", "--preview", "--formats", "heightmap,occupancy") == 0
    plain = contents(tmp_path / "plain")
    assert {name: after[name] for name in after if name.startswith("rse_0000")} == plain


def test_resume_keeps_no_format_of_which_a_file_is_missing(tmp_path: Path) -> None:
    folder = tmp_path / "worlds"
    assert generated(folder, "--formats", "heightmap,occupancy") == 0
    before = contents(folder)
    (folder / "rse_0001" / "heightmap" / "heightmap.json").unlink()
    assert generated(folder, "--resume") == 0
    assert not (folder / "rse_0001" / "heightmap").exists()
    assert (folder / "rse_0001" / "occupancy").is_dir()
    assert generated(folder, "--resume", "--formats", "heightmap,occupancy") == 0
    assert contents(folder) == before


@pytest.mark.parametrize("content", [b"", b"[", b"[1]", b'{"heightmap": 1}', b"\xff"])
def test_a_map_with_an_invalid_list_of_formats_is_incomplete(content: bytes, tmp_path: Path) -> None:
    formats = [Heightmap()]
    rsegen.generate(SMALL, tmp_path, formats=formats)
    wanted = partial(are_complete, chosen_sidecars({"formats": formats}))
    homes = [str(tmp_path / f"rse_000{index}") for index in range(3)]
    assert list(map(wanted, homes)) == [True, True, True]
    (tmp_path / "rse_0001" / "formats.json").write_bytes(content)
    assert list(map(wanted, homes)) == [True, False, True]
    assert all(are_complete((), home) for home in homes)


@pytest.mark.long(reason="tests/writing/test_execute.py has workers once for all commands")
@pytest.mark.slow
def test_workers_make_the_same_files(tmp_path: Path) -> None:
    many: Recipe = replace(SMALL, maps=150)
    formats = [Heightmap(pixels=2), Occupancy(climb_cm=12)]
    for workers in (1, 2):
        made = rsegen.generate(many, tmp_path / str(workers), formats=formats, workers=workers)
        assert len(made.maps) == 150
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def test_a_format_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file: is a file"):
        rsegen.export_maps([SMALL], tmp_path / "file", [Heightmap()])
    assert main(["generate", "-o", str(tmp_path / "out"), "--formats", "heightmap,nothing"]) == 2
    assert not (tmp_path / "out").exists()
