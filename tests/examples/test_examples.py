"""The scripts of examples/, each run in an empty folder: it writes and prints what it says."""

from __future__ import annotations

import re
import runpy
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import rsegen

ROOT = Path(__file__).parents[2]
EXAMPLES = {path.stem: path for path in sorted((ROOT / "examples").glob("*.py"))}

Run = Callable[[str], str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)

    def printed(name: str) -> str:
        runpy.run_path(str(EXAMPLES[name]), run_name="__main__")
        return capsys.readouterr().out

    return printed


def written() -> set[str]:
    return {path.name for path in Path().iterdir() if not path.name.startswith(".")}


def test_a_field_and_its_numbers(run: Run) -> None:
    out = run("a_field_and_its_numbers")
    assert len(re.findall(r"^ ?\[+[\d ]+\]+$", out, re.MULTILINE)) == 10
    assert re.search(r"rms step 0\.\d{3} m; \d+% of the steps", out)
    assert re.search(r"reaches \d+% of the cells", out)
    assert Path("field.png").read_bytes().startswith(b"\x89PNG")


def test_a_world_for_gazebo(run: Run) -> None:
    out = run("a_world_for_gazebo")
    folders = [Path(line) for line in out.splitlines()]
    assert [folder.name for folder in folders] == ["course_0000", "course_0001"]
    assert all((folder / f"{folder.name}.world").is_file() for folder in folders)


def test_an_obstacle_of_your_own(run: Run) -> None:
    (levels,) = run("an_obstacle_of_your_own").splitlines()
    assert levels == "[0 1 2 2 1 0 1 2 2 1]"


def test_very_many_maps(run: Run) -> None:
    assert "10000 maps in rubble/; number 1234 again: True" in run("very_many_maps")
    rsegen.verify("rubble")
    assert written() == {"rubble"}


def test_blocks_in_mujoco(run: Run) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    heights = [float(number) for number in re.findall(r"\d\.\d+", run("blocks_in_mujoco"))]
    assert heights == pytest.approx([0.32, 0.02], abs=0.002)  # three blocks and none, and the radius of a ball


def test_a_scan_measured(run: Run) -> None:
    wrong, forgotten = re.findall(r": \[?(\[\d, \d\])", run("a_scan_measured"))
    assert wrong == forgotten
    assert written() == {"pallet.xyz", "changes.png"}


def test_a_build_sheet(run: Run) -> None:
    assert "# cut: 19 blocks of 10 cm" in run("a_build_sheet")
    assert Path("pallet.pdf").read_bytes().startswith(b"%PDF")
    assert written() == {"pallet.pdf", "pallet.csv"}


def test_a_robot_on_the_blocks(run: Run) -> None:
    out = run("a_robot_on_the_blocks")
    assert re.search(r"stands at \d+% of the places, tilted by \d\.\d degrees", out)
    assert len(re.findall(r"a start at x = -?0\.\d\d, y = -?0\.\d\d m", out)) == 2


@pytest.mark.slow
def test_a_policy_rated(run: Run) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    out = run("a_policy_rated")
    level = re.search(r"policy crosses half of normal-random fields .*? at a unit of (\d\.\d+) cm .* 40 trials", out)
    assert level
    assert 1.5 < float(level[1]) < 3.5  # of 10 fields at 2 and at 3 cm, it crosses 9 and 2
    assert written() == set()


@pytest.mark.slow
def test_a_gymnasium_policy_rated(run: Run) -> None:
    pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    out = run("a_gymnasium_policy_rated")
    level = re.search(r"ant crosses half of ant-blocks fields .*? at a unit of (\d\.\d+) cm .* 24 trials", out)
    assert level
    assert 3 < float(level[1]) < 7  # of 4 fields at 3 and at 10 cm, it crosses 4 and none
    assert written() == set()


@pytest.mark.slow
def test_the_ant_walks_on_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
    example = runpy.run_path(str(EXAMPLES["a_gymnasium_policy_rated"]))
    touched, step = set[str](), mujoco.mj_step

    def watched(model: Any, data: Any, *others: Any, **named: Any) -> None:
        step(model, data, *others, **named)
        touched.update(model.geom(geom).name for geom in set(data.contact.geom.ravel().tolist()))

    monkeypatch.setattr(mujoco, "mj_step", watched)
    assert example["ant"](rsegen.build(replace(example["BLOCKS"], seed=3, unit_cm=1)), 0)
    assert len([name for name in touched if name.startswith("rse_0000_")]) > 8, touched


def test_every_example_is_run_here() -> None:
    tests = {name.removeprefix("test_") for name in globals()}
    assert EXAMPLES
    assert set(EXAMPLES) <= tests
