"""Contract of all formats: a new file is tested here the moment it exists."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path, PurePosixPath
from typing import get_args

import pytest

import rsegen
from rsegen import Recipe, Scene, compose, load
from rsegen.formats.base import FORMATS, Format, Step, exported
from rsegen.heights.base import IMPORTERS as READ
from rsegen.input_files import JOURNAL
from rsegen.params import extras
from rsegen.params.extras import pip_install
from rsegen.params.registry import summary_of_class
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import to_json
from tests.formats.maps import RECIPES, SCENES, made
from tests.support.complaints import exit_code, the_line
from tests.support.runs import contents

FORMAT = pytest.mark.parametrize("cls", FORMATS.values(), ids=list(FORMATS))
SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
SMALL = RECIPES["frames round every chunk"]


@FORMAT
def test_a_format_explains_itself_and_its_options(cls: type[Format]) -> None:
    assert cls.name.isidentifier()
    assert cls.name.islower()
    assert summary_of_class(cls).endswith(".")
    assert all(option.help and option.describe() for option in parameters(cls).values())
    assert cls().step in get_args(Step)
    assert cls().array_bytes >= 0


@FORMAT
@SCENE
def test_the_same_map_gives_the_same_bytes_in_files_that_stay_in_their_folder(cls: type[Format], scene: Scene) -> None:
    files = made(cls(), scene)
    assert files
    assert files == made(cls(), compose(scene.alone, scene.index))
    for path in map(PurePosixPath, files):
        assert not path.is_absolute()
        assert ".." not in path.parts


@pytest.mark.slow
def test_the_same_bytes_come_from_another_process(tmp_path: Path) -> None:
    (tmp_path / "recipe.json").write_text(to_json(SMALL))
    to = ",".join(FORMATS)
    for seed in ("1", "2"):
        command = ["export", str(tmp_path / "recipe.json"), "--to", to, "-o", str(tmp_path / seed)]
        environment = {"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(filter(None, sys.path))}
        subprocess.run([sys.executable, "-m", "rsegen", *command], check=True, capture_output=True, env=environment)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
    expected = {str(path): b"".join(pieces) for path, pieces in exported(compose(SMALL), _all()).items()}
    found = {name.partition("/")[2]: content for name, content in contents(tmp_path / "1").items()}
    assert found == {**expected, JOURNAL: found[JOURNAL]}


@FORMAT
def test_an_exported_map_carries_its_recipe_and_its_options(cls: type[Format], tmp_path: Path) -> None:
    (one,) = rsegen.export_maps([SMALL], tmp_path, [cls()])
    assert one.folder == tmp_path / "rse_0000"
    assert load(one.folder / "recipe.json") == SMALL
    assert json.loads((one.folder / "formats.json").read_text("utf-8")) == {cls.name: cls().options}
    assert sorted([*one.names, JOURNAL]) == sorted(contents(one.folder))
    assert {name.partition("/")[0] for name in one.names} == {"recipe.json", "formats.json", cls.name}


@FORMAT
def test_a_world_with_a_format_is_the_world_and_the_export(cls: type[Format], tmp_path: Path) -> None:
    rsegen.generate(SMALL, tmp_path / "plain")
    rsegen.export_maps([SMALL], tmp_path / "export", [cls()])
    rsegen.generate(SMALL, tmp_path / "both", formats=[cls()])
    both, parts = contents(tmp_path / "both"), contents(tmp_path / "plain") | contents(tmp_path / "export")
    assert {name for name in both.keys() | parts.keys() if both.get(name) != parts.get(name)} == {f"rse_0000/{JOURNAL}"}


@FORMAT
def test_a_missing_library_is_reported_in_one_line_with_its_install_command(
    cls: type[Format], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if cls.extra is None:
        return
    monkeypatch.setattr(extras, "find_spec", lambda module: None)
    for command in (["export", "peak", "--to"], ["generate", "peak", "--formats"]):
        assert exit_code(*command, cls.name, "-o", tmp_path / "out") == 2
        needed = f"rsegen: {cls.name} needs {cls.extra.module}, which is not installed"
        assert the_line(capsys.readouterr().err) == f"{needed}; {pip_install([cls.extra.name])}"
        assert not (tmp_path / "out").exists()


def test_options_of_one_name_take_the_same_values_and_are_no_others_flags() -> None:
    options = [pair for cls in FORMATS.values() for pair in parameters(cls).items()]
    assert len({(name, option.describe()) for name, option in options}) == len({name for name, _ in options})
    taken = {*parameters(Recipe)} | {name for cls in READ.values() for name in parameters(cls)}
    taken |= {"recipe", "target", "file", "map", "to", "output", "force", "resume", "preview", "formats", "json"}
    assert not taken & {name for name, _ in options}


def _all() -> list[Format]:
    return [cls() for cls in FORMATS.values()]
