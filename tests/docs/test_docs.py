"""What the documents say can be done is done."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rsegen
from tests.plugins.installed import declare, done

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_the_readme_s_commands_and_recipe_work_in_one_folder(tmp_path: Path) -> None:
    (recipe,) = blocks(ROOT / "README.md", "yaml")
    name = recipe.partition("\n")[0].removeprefix("# ")
    (tmp_path / name).write_text(recipe)
    tools = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for script in blocks(ROOT / "README.md", "bash"):
        subprocess.run(["bash", "-euc", script], cwd=tmp_path, env=tools, check=True, capture_output=True)
    made = {path.name for path in (tmp_path / "worlds").iterdir()}
    assert {"rse_0000", "rubble_0000", "rubble_0001", "rubble_0002"} == made
    assert (tmp_path / "rubble.png").stat().st_size > 10_000


def test_the_readme_s_python_works(tmp_path: Path) -> None:
    (script,) = blocks(ROOT / "README.md", "python")
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    assert (tmp_path / "worlds-from-python" / "rse_0000" / "rse_0000.world").is_file()


def test_the_python_of_the_page_of_metrics_works() -> None:
    (script,) = blocks(ROOT / "docs" / "metrics.md", "python")
    found = subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True, capture_output=True, text=True)
    assert found.stdout.startswith("0.13017")


@pytest.mark.slow
def test_the_python_of_the_page_of_difficulty_works(tmp_path: Path) -> None:
    (script,) = blocks(ROOT / "docs" / "difficulty.md", "python")
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    assert (tmp_path / "course" / "mixed-course-0004_0000" / "mixed-course-0004_0000.world").is_file()
    assert (tmp_path / "course" / "series.png").is_file()


def test_the_recipe_of_the_page_of_gazebo_has_frictions(tmp_path: Path) -> None:
    (recipe,) = blocks(ROOT / "docs" / "gazebo.md", "yaml")
    (tmp_path / "icy.yaml").write_text(recipe)
    (made,) = rsegen.generate(rsegen.load(tmp_path / "icy.yaml"), tmp_path).maps
    touched = sorted(path.name for path in (made.folder / "meshes" / "touched").iterdir())
    assert touched == [f"rse_0000_friction_{friction}.obj" for friction in (0.1, 0.4, 0.9)]


@pytest.mark.slow
def test_the_python_of_the_page_of_formats_works(tmp_path: Path) -> None:
    (recipe,), (script,) = blocks(ROOT / "README.md", "yaml"), blocks(ROOT / "docs" / "formats.md", "python")
    (tmp_path / "rubble.yaml").write_text(recipe)
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    for folder in ("exported", "worlds"):
        assert (tmp_path / folder / "rubble_0002" / "posture" / "raster.npy").is_file()


@pytest.mark.slow
def test_the_python_of_the_page_of_build_sheets_works() -> None:
    (script,) = blocks(ROOT / "docs" / "sheet.md", "python")
    found = subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True, capture_output=True, text=True)
    assert found.stdout == "# build sheet of rse_0000 with seed 7\n"


@pytest.mark.slow
def test_the_python_of_the_page_of_data_sets_works(tmp_path: Path) -> None:
    script = "".join(blocks(ROOT / "docs" / "datasets.md", "python"))
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    *_, tiles, kinds, index, columns = found.stdout.splitlines()
    assert [tiles, kinds, index] == ["(10, 20, 10, 10) (10, 20, 3)", "hills 1", "1999"]
    assert columns.strip("[]").split() == ["1"] * 14 + ["0"] * 6


@pytest.mark.slow
def test_the_python_of_the_page_of_learning_works(tmp_path: Path) -> None:
    """But for Isaac Lab's configuration: no package here has all of it."""
    for library in ("mujoco", "trimesh", "pxr"):
        pytest.importorskip(library)
    gymnasium = pytest.importorskip("gymnasium")
    terrain, exports, many, _, in_place, reset, _ = blocks(ROOT / "docs" / "learning.md", "python")
    ant = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "ant.xml"
    (tmp_path / "robot.xml").write_bytes(ant.read_bytes())
    write_ant = 'open("ant_on_blocks.xml", "w").write(spec.to_xml())'
    script = "\n".join([terrain, exports, many, in_place, write_ant, reset, 'assert info["map"] >= 0'])
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    assert (tmp_path / "worlds" / "terrain_0000" / "terrain_0000.world").is_file()
    assert (tmp_path / "terrain.glb").stat().st_size > 100_000


@pytest.mark.slow
def test_the_race_of_the_page_of_learning_is_won_on_easy_fields(tmp_path: Path) -> None:
    pytest.importorskip("mujoco_warp", reason="mujoco_warp is not installed: it needs Python 3.11")
    terrain, *_, race = blocks(ROOT / "docs" / "learning.md", "python")
    script = f"{terrain.partition('terrain =')[0]}\n{race}"
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert "overflow" not in found.stdout + found.stderr
    easy, hard = map(float, found.stdout.splitlines()[-1].split())
    assert easy > 1.3 > 2 * hard


def test_the_contributing_page_s_file_alone_makes_a_kind(tmp_path: Path) -> None:
    (source,) = blocks(ROOT / "CONTRIBUTING.md", "python")
    shutil.copytree(ROOT / "src" / "rsegen", tmp_path / "rsegen")
    (tmp_path / "rsegen" / "field" / "obstacles" / "stairs.py").write_text(source)
    row = "stairs max_height=5 first=0,0 last=8,9"
    command = ["generate", "--seed", "1", "--boundary", "none", "--obstacle", row, "-o", str(tmp_path / "worlds")]
    subprocess.run([sys.executable, "-m", "rsegen", *command], cwd=tmp_path, check=True, capture_output=True)
    levels = (tmp_path / "worlds" / "rse_0000" / "levels.csv").read_text("utf-8").splitlines()
    assert levels[1:] == ["0,0,1,1,2,2,3,3,4,0"] * 10


def test_the_page_of_plug_ins_works_as_a_file(tmp_path: Path) -> None:
    source, script = blocks(ROOT / "docs" / "plugins.md", "python")
    (tmp_path / "ramp.py").write_text(source)
    tools = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    said = [
        subprocess.run(
            ["bash", "-euc", commands], cwd=tmp_path, env=tools, check=True, capture_output=True, text=True
        ).stdout
        for commands in blocks(ROOT / "docs" / "plugins.md", "bash")
    ]
    assert "Steps that rise along x from first to last. From ramp.py." in said[0]
    assert "Height of the highest cell" in said[0]
    assert said[1].endswith("plug-in  ramp of ramp.py\n")
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert found.stdout == "(2, 2)\n(2, 2)\n"


def test_the_package_of_the_page_of_plug_ins_is_found(tmp_path: Path) -> None:
    source, (declared,) = (
        blocks(ROOT / "docs" / "plugins.md", "python")[0],
        blocks(ROOT / "docs" / "plugins.md", "toml"),
    )
    (tmp_path / "rsegen_ramps.py").write_text(source)
    offers = re.sub(r'project\.entry-points\."([^"]+)"', r"\1", declared.partition("\n\n")[2]).replace('"', "")
    declare(tmp_path, "rsegen-ramps", "1.2", offers)
    assert "From rsegen-ramps 1.2." in done("obstacles", packages=tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text("utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []
