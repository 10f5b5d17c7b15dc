"""A file that is not installed is a plug-in too: --plugin FILE, RSEGEN_PLUGINS, rsegen.load_plugin."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rsegen
from rsegen.errors import PluginError
from tests.plugins.installed import EAGER, done, refused, run
from tests.support.shells import completed

RAMP = '''
from dataclasses import dataclass
from typing import ClassVar

import rsegen
from rsegen.obstacles.base import Shaped


@dataclass(frozen=True, kw_only=True, slots=True)
class Ramp(Shaped):
    """Steps that rise along x from first to last."""

    kind: ClassVar[str] = "ramp"

    def overhang(self, grid):
        return 0.0

    def profile(self, x, y, first, last, grid):
        return abs(x - first[0]) / max(abs(last[0] - first[0]), 1) + 0 * y


@rsegen.metric(unit="m")
def top(field):
    """Highest cell."""
    return field.heights.max()
'''
FLAGS = ["--seed", "1", "--boundary", "none", "--obstacle", "ramp levels=5 first=0,0 last=8,9"]


@pytest.fixture
def ramp(tmp_path: Path) -> Path:
    (tmp_path / "my ramp.py").write_text(RAMP)
    return tmp_path / "my ramp.py"


@pytest.mark.slow
@pytest.mark.parametrize("before", [True, False])
def test_a_file_s_kind_is_made_by_workers_and_recorded_by_its_name(ramp: Path, tmp_path: Path, before: bool) -> None:
    flag = ["--plugin", ramp] if before else [f"--plugin={ramp}"]
    command = ["generate", *FLAGS, "--maps", "4", "--workers", "2", "-o", tmp_path / "worlds"]
    done(*(*flag, *command) if before else (*command, *flag), code=EAGER)
    for number in range(4):
        home = tmp_path / "worlds" / f"rse_000{number}"
        assert (home / "levels.csv").read_text("utf-8").splitlines()[1:] == ["0,0,1,1,2,2,3,3,4,0"] * 10
        assert json.loads((home / "recipe.json").read_text("utf-8"))["plugins"] == {"ramp": "my ramp.py"}


def test_a_kind_that_registers_itself_is_recorded_alike(ramp: Path, tmp_path: Path) -> None:
    registered = RAMP.replace("@dataclass", "@register\n@dataclass").replace("import Shaped", "import Shaped, register")
    ramp.write_text(registered)
    done("generate", *FLAGS, "--plugin", ramp, "-o", tmp_path / "worlds")
    content = json.loads((tmp_path / "worlds" / "rse_0000" / "recipe.json").read_text("utf-8"))
    assert content["plugins"] == {"ramp": "my ramp.py"}


@pytest.mark.slow
def test_the_missing_file_is_named(ramp: Path, tmp_path: Path) -> None:
    done("generate", *FLAGS, "--plugin", ramp, "-o", tmp_path / "worlds")
    assert "kind 'ramp' of my ramp.py is not loaded; load it by --plugin my ramp.py" in refused(
        "info", tmp_path / "worlds"
    )
    assert "plug-in  ramp of my ramp.py" in done("info", tmp_path / "worlds", RSEGEN_PLUGINS=str(ramp))


@pytest.mark.slow
def test_a_data_set_is_made_by_workers_and_ranked_by_the_file_s_metric(ramp: Path, tmp_path: Path) -> None:
    flags = ["--seed", "1", "--maps", "8", "--shard-maps", "2", "--obstacle", "ramp levels=5", "--workers", "2"]
    done("dataset", "--plugin", ramp, *flags, "-o", tmp_path / "set", code=EAGER)
    script = (
        "import sys, rsegen; rsegen.load_plugin(sys.argv[1]); data = rsegen.Dataset(sys.argv[2]);"
        "print(data.tiles(2, 1, by='top').difficulty.ravel() > 0)"
    )
    assert done(ramp, tmp_path / "set", code=script) == "[ True  True]\n"


@pytest.mark.slow
def test_a_data_set_is_not_continued_with_a_file_that_was_changed(ramp: Path, tmp_path: Path) -> None:
    command: list[str | Path] = [
        "dataset",
        "--plugin",
        ramp,
        *FLAGS,
        "--maps",
        "4",
        "--shard-maps",
        "2",
        "-o",
        tmp_path / "set",
    ]
    done(*command)
    (tmp_path / "set" / "levels-00001.npy").unlink()
    done(*command, "--resume")
    ramp.write_text(RAMP.replace("+ 0 * y", "/ 2 + 0 * y"))
    (tmp_path / "set" / "levels-00001.npy").unlink()
    assert "contains a different data set" in refused(*command, "--resume")


def test_a_module_is_loaded_by_its_name(ramp: Path, tmp_path: Path) -> None:
    ramp.rename(tmp_path / "ramps.py")
    assert "From ramps.\n" in done("obstacles", "--plugin", "ramps", packages=tmp_path)


@pytest.mark.slow
def test_a_shell_completes_what_the_file_brings(ramp: Path, tmp_path: Path) -> None:
    file = ramp.rename(tmp_path / "ramp.py").name
    assert completed(f"rsegen generate --plugin {file} --obstacle ramp", tmp_path) == {"ramp"}
    assert completed("rsegen generate --plugin gone.py --obstacle ran", tmp_path) == {"random"}


def test_every_command_names_the_flag_in_its_help() -> None:
    for command in ("generate", "gui", "info"):
        assert "--plugin MODULE" in done(command, "--help")


def test_words_after_two_dashes_are_no_flags(ramp: Path) -> None:
    assert "ramp" not in refused("obstacles", "--", "--plugin", "nowhere.py")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, "there is no such file"),
        ("\nimport nowhere_at_all\n", "line 2: ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("x = (\n", "line 1: SyntaxError: '(' was never closed"),
        ("import sys; sys.exit(3)\n", "line 1: SystemExit: 3"),
    ],
)
def test_a_file_that_cannot_be_run_is_refused_in_one_line(ramp: Path, content: str | None, complaint: str) -> None:
    ramp.unlink()
    if content is not None:
        ramp.write_text(content)
    with pytest.raises(PluginError) as error:
        rsegen.load_plugin(ramp)
    assert str(error.value) == f"plug-in {ramp}: {complaint}"


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (RAMP.replace('"ramp"', '"peak"'), "the name 'peak' is taken by rsegen"),
        (RAMP.replace('    """Steps that rise along x from first to last."""\n', ""), "has no docstring"),
        (RAMP.replace('kind: ClassVar[str] = "ramp"', "pass"), "AttributeError"),
    ],
)
def test_a_file_s_class_that_is_no_kind_is_refused_in_one_line(ramp: Path, content: str, complaint: str) -> None:
    ramp.write_text(content)
    assert refused("--plugin", ramp, "obstacles").startswith(f"rsegen: plug-in my ramp.py (Ramp): {complaint}")


def test_a_kind_of_rsegen_s_own_is_not_replaced_by_a_file(ramp: Path, tmp_path: Path) -> None:
    ramp.write_text(RAMP.replace('"ramp"', '"peak"'))
    flags = ["--seed", "1", "--obstacle", "peak levels=5", "-o", str(tmp_path / "worlds")]
    assert "the name 'peak' is taken by rsegen" in refused("--plugin", ramp, "generate", *flags)
    assert not (tmp_path / "worlds").exists()


def test_two_files_of_one_name_are_refused(ramp: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / ramp.name).write_text(RAMP)
    assert "another plug-in file my ramp.py is loaded" in refused(
        "obstacles", "--plugin", ramp, "--plugin", tmp_path / "other" / ramp.name
    )
    assert run("obstacles", "--plugin", ramp, "--plugin", ramp).returncode == 0


def test_an_error_in_a_plug_in_file_is_attributed_to_it(ramp: Path, tmp_path: Path) -> None:
    ramp.write_text(RAMP.replace("return 0.0", "return 1 / 0"))
    found = run("--plugin", ramp, "generate", *FLAGS, "-o", tmp_path / "worlds")
    line = f"rsegen: plug-in my ramp.py: line {RAMP[: RAMP.index('return 0.0')].count(chr(10)) + 1}: "
    assert (found.returncode, found.stderr) == (1, f"{line}ZeroDivisionError: division by zero\n")
    assert not (tmp_path / "worlds").exists()
