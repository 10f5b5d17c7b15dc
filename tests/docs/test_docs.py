"""Everything that the documents say can be done is done."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image, ImageSequence

import rsegen
from docs import catalogue
from docs.generate import SHEET, shows
from rsegen import KINDS
from rsegen.cli.edge import main
from rsegen.recipe.examples import EXAMPLES
from tests.plugins.installed import declare, done

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)


ELSEWHERE = {"CONTRIBUTING.md", "learning.md", "frameworks.md", "gazebo.md", "training.md"}
"""Pages whose programs have tests of their own below."""
LONG = {
    "certainty.md": "a robot tries many ways over a large map",
    "constraints.md": "tests/recipe/constraints has its recipes",
    "datasets.md": "tests/writing has its commands",
    "difficulty.md": "tests/recipe has its commands",
    "formats.md": "tests/formats has every format",
    "README.md": "a robot looks for its ways over several maps",
    "metrics.md": "a robot looks for its ways over several maps",
    "rating.md": "tests/rating has its commands",
    "ros2.md": "tests/ros2 has its commands",
    "scan.md": "tests/scanning/test_scan_command.py has its commands",
    "sheet.md": "tests/build_sheets has its commands",
    "tutorial.md": "a robot looks for its ways over several maps",
}
"""Page -> why make test leaves it to make test-all."""
RUN = [
    page
    for page in PAGES
    if page.name not in ELSEWHERE and re.search("^```(bash|python)$", page.read_text("utf-8"), re.M)
]


class Program(NamedTuple):
    """A block of a page that a reader runs; printed: the output that the page shows after it."""

    language: str
    content: str
    printed: str


def steps(page: Path) -> Iterator[Program | tuple[str, str]]:
    """Steps of a reader on a page, in order: run a program, or save a file, which begins with its name as `# NAME`."""
    fences = r"^```(bash|python|yaml|csv|text)\n(.*?)^```$"
    found = re.findall(fences, page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    for (language, content), (next_language, printed) in pairwise([*found, ("", "")]):
        if name := re.match(r"# (\S+\.(?:yaml|csv|py))\n", content):
            yield name[1], content
        elif language in ("bash", "python"):
            yield Program(language, content, printed if next_language == "text" else "")


def pattern(printed: str) -> str:
    """Return a regular expression of an output as a page shows it: `...` stands for anything."""
    return re.escape(printed).replace(re.escape("..."), ".*")


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.long(reason=LONG[page.name]) if page.name in LONG else ()) for page in RUN],
    ids=lambda page: page.name,
)
def test_a_page_runs_from_top_to_bottom_in_one_folder(page: Path, tmp_path: Path) -> None:
    tools = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    commands = {"bash": ["bash", "-euc"], "python": [sys.executable, "-c"]}
    for step in steps(page):
        if not isinstance(step, Program):
            name, content = step
            (tmp_path / name).write_text(content)
            continue
        command = [*commands[step.language], step.content]
        done = subprocess.run(command, check=False, cwd=tmp_path, env=tools, capture_output=True, text=True)
        assert done.returncode == 0, f"{step.content}\n{done.stderr}"
        assert not step.printed or re.fullmatch(pattern(step.printed), done.stdout, re.DOTALL), done.stdout


def test_a_page_shows_the_output_of_the_program_before_it(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "```csv\n# a.csv\n1\n```\n\n```bash\ncat a.csv\n```\n\n```text\n# ...\n1\n```\n\n```python\n2\n```\n"
    )
    assert [*steps(page)] == [
        ("a.csv", "# a.csv\n1\n"),
        ("bash", "cat a.csv\n", "# ...\n1\n"),
        ("python", "2\n", ""),
    ]
    assert re.fullmatch(pattern("# ...\n1\n"), "# a.csv\n1\n")
    assert not re.fullmatch(pattern("# ...\n1\n"), "# a.csv\n2\n")


def test_the_page_of_python_has_every_public_function_and_class() -> None:
    listed = set(re.findall(r"^::: rsegen\.(\w+)$", (ROOT / "docs" / "api.md").read_text("utf-8"), re.MULTILINE))
    public = {name: getattr(rsegen, name) for name in rsegen.__all__ if name != "__version__"}
    wanted = {name for name, value in public.items() if isinstance(value, type) or inspect.isfunction(value)}
    assert wanted - {"RsegenError", "UserError"} == listed - {"errors"}


def test_the_readme_is_short_and_its_python_makes_a_world(tmp_path: Path) -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    assert len(re.findall(r"^[^\s|#!<]", prose, re.MULTILINE)) <= 60  # without code, tables, headings, pictures
    script = blocks(ROOT / "README.md", "python")[0]
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    assert (tmp_path / "worlds-from-python" / "rse_0000" / "rse_0000.world").is_file()


def test_the_first_commands_of_the_readme_make_worlds_and_drive_over_one_and_play_it(tmp_path: Path) -> None:
    lines = re.findall(r"^    (\S.*?)(?:  +#.*)?$", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE)
    first, *others = lines[:3]
    assert first == "make worlds"
    assert re.search(r"^worlds:", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    assert main(["generate", "turtlebot", "-o", str(tmp_path / "worlds")]) == 0
    drive, play = ([sys.executable, "-m", *line.removeprefix(".venv/bin/").split()] for line in others)
    out = subprocess.run(drive, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "in MuJoCo " in out
    assert "crossed the map after" in out
    with subprocess.Popen([*play, "--no-browser"], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout
            assert "http://localhost:" in server.stdout.readline()
        finally:
            server.terminate()


def test_the_recipe_of_the_page_of_gazebo_has_frictions(tmp_path: Path) -> None:
    (recipe,) = blocks(ROOT / "docs" / "gazebo.md", "yaml")
    (tmp_path / "icy.yaml").write_text(recipe)
    (made,) = rsegen.generate(rsegen.load(tmp_path / "icy.yaml"), tmp_path).maps
    touched = sorted(path.name for path in (made.folder / "meshes" / "touched").iterdir())
    assert touched == [f"rse_0000_friction_{friction}.obj" for friction in (0.1, 0.4, 0.9)]


def of_learning() -> list[str]:
    """Return the Python of the two pages of learning, in the order in which a reader meets it."""
    return [
        program for page in ("learning", "frameworks") for program in blocks(ROOT / "docs" / f"{page}.md", "python")
    ]


@pytest.mark.long(reason="tests/learning has each framework")
@pytest.mark.slow
def test_the_python_of_the_page_of_learning_works(tmp_path: Path) -> None:
    """But for what needs a trainer or another simulator: tests/learning has what can be run of it."""
    for library in ("mujoco", "trimesh", "pxr"):
        pytest.importorskip(library)
    gymnasium = pytest.importorskip("gymnasium")
    (
        terrain,
        exports,
        stairs,
        ground,
        sensor,
        seats,
        many,
        _tensor,
        _isaaclab,
        _mjlab,
        _legged_gym,
        _genesis_and_sapien,
        _playground,
        in_place,
        reset,
        touch,
        ice,
        *_,
    ) = of_learning()
    ant = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "ant.xml"
    (tmp_path / "robot.xml").write_bytes(ant.read_bytes())
    write_ant = 'open("ant_on_blocks.xml", "w").write(spec.to_xml())'
    parts = [terrain, exports, stairs, ground, sensor, seats, many, in_place, write_ant, reset, touch, ice]
    script = "\n".join([*parts, 'assert info["map"] >= 0'])
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    assert (tmp_path / "worlds" / "terrain_0000" / "terrain_0000.world").is_file()
    assert (tmp_path / "terrain.glb").stat().st_size > 100_000


@pytest.mark.long(reason="needs mujoco_warp, with Warp 0.4 GB")
@pytest.mark.slow
def test_the_race_of_the_page_of_learning_is_won_on_easy_fields(tmp_path: Path) -> None:
    pytest.importorskip("mujoco_warp", reason="mujoco_warp is not installed")
    terrain, *_, race, _mjx, _quadruped = of_learning()
    script = f"{terrain.partition('terrain =')[0]}\n{race}"
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert "overflow" not in found.stdout + found.stderr
    easy, hard = map(float, found.stdout.splitlines()[-1].split())
    assert easy > 1.3 > 2 * hard


def test_the_page_of_learning_gives_a_tensor() -> None:
    pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    terrain, _exports, _stairs, _ground, _sensor, _seats, _many, tensor, *_ = of_learning()
    script = f"{terrain.partition('terrain =')[0]}\n{tensor}\nassert tuple(levels.shape) == (16_384, 20, 20)"
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.long(reason="needs MJX, with jax 0.6 GB")
@pytest.mark.slow
def test_the_balls_of_the_page_of_learning_rest_on_the_ground_in_mjx(tmp_path: Path) -> None:
    pytest.importorskip("mujoco.mjx", reason="MJX is not installed")
    terrain, *_, mjx, _quadruped = of_learning()
    imports = "import mujoco\nfrom dataclasses import replace\nfrom rsegen.learning.mujoco import BlockGrid"
    script = f"{terrain.partition('terrain =')[0]}\n{imports}\n{mjx}"
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert float(found.stdout) < 0.001


@pytest.mark.long(reason="needs mjlab")
@pytest.mark.slow
def test_the_quadruped_of_the_page_of_learning_stands_on_flat_tiles_and_falls_on_rough_ones(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    robot = Path(sys.prefix) / "mjlab" / "mjlab" / "asset_zoo" / "robots" / "unitree_go1" / "xmls"
    if not robot.is_dir():
        pytest.skip(f"no mjlab in {robot.parents[4]}: make learners puts it there")
    shutil.copytree(robot, tmp_path, dirs_exist_ok=True)
    terrain, *_, quadruped = of_learning()
    script = f"{terrain.partition('terrain =')[0]}\n{quadruped}"
    found = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True, text=True)
    flat, *_, rough, roughest = map(float, found.stdout.splitlines()[-1].strip("[]").split())
    assert flat < 5
    assert max(rough, roughest) > 20


def test_the_contributing_page_s_file_alone_makes_a_kind(tmp_path: Path) -> None:
    (source,) = blocks(ROOT / "CONTRIBUTING.md", "python")
    shutil.copytree(ROOT / "src" / "rsegen", tmp_path / "rsegen")
    file = tmp_path / "rsegen" / "obstacles" / "wedge.py"
    assert not file.exists(), "it would replace a kind of rsegen's own"
    file.write_text(source)
    row = "wedge levels=5 first=0,0 last=8,9"
    command = ["generate", "--seed", "1", "--boundary", "none", "--obstacle", row, "-o", str(tmp_path / "worlds")]
    subprocess.run([sys.executable, "-m", "rsegen", *command], cwd=tmp_path, check=True, capture_output=True)
    levels = (tmp_path / "worlds" / "rse_0000" / "levels.csv").read_text("utf-8").splitlines()
    assert levels[1:] == ["0,0,1,1,2,2,3,3,4,0"] * 10


def test_the_package_of_the_page_of_plug_ins_is_found(tmp_path: Path) -> None:
    source, (declared,) = (
        blocks(ROOT / "docs" / "plugins.md", "python")[0],
        blocks(ROOT / "docs" / "plugins.md", "toml"),
    )
    (tmp_path / "rsegen_ramps.py").write_text(source)
    offers = re.sub(r'project\.entry-points\."([^"]+)"', r"\1", declared.partition("\n\n")[2]).replace('"', "")
    declare(tmp_path, "rsegen-ramps", "1.2", offers)
    assert "From rsegen-ramps 1.2." in done("obstacles", packages=tmp_path)


@pytest.mark.parametrize("kind", KINDS)
def test_the_command_of_a_kind_makes_the_map_of_its_picture(kind: str, tmp_path: Path) -> None:
    page = (ROOT / "docs" / "obstacles.md").read_text("utf-8")
    (words,) = re.findall(r"^    rsegen (.*)$", page.partition(f"## `{kind}`")[2].partition("\n## ")[0], re.MULTILINE)
    assert main([*shlex.split(words), "-o", str(tmp_path)]) == 0
    made = rsegen.load(tmp_path / f"{kind}_0000" / "recipe.json")
    assert rsegen.build(made) == rsegen.build(catalogue.recipe_of(kind))


def ridge(kind: str) -> set[tuple[int, int]]:
    """The cells of the highest level of a kind's picture."""
    levels = rsegen.build(catalogue.recipe_of(kind)).blocks
    return {(int(i), int(j)) for i, j in np.argwhere(levels == levels.max())}


def test_pictures_of_kinds_match_their_names() -> None:
    assert ridge("diagonal_barrier") == {(i, i) for i in range(10)}
    assert ridge("horizontal_barrier") == {(i, 5) for i in range(10)}
    assert ridge("peak") <= {(i, j) for i in (4, 5) for j in (4, 5)}
    assert ridge("platform") == {(i, j) for i in range(3, 7) for j in range(3, 7)}
    flat, hill, diagonal = (rsegen.build(catalogue.recipe_of("pallet")).blocks[at : at + 10] for at in (0, 10, 20))
    assert (flat < 4).all()
    assert (hill[4:6] == 4).all()
    assert (np.diagonal(diagonal) == 4).all()


@pytest.mark.parametrize("kind", KINDS)
def test_softness_of_the_gallery_changes_every_kind(kind: str) -> None:
    fields = [rsegen.build(recipe).levels for _, recipe in catalogue.softnesses(kind)]
    assert not np.array_equal(fields[0], fields[1])
    assert not np.array_equal(fields[1], fields[2])


def test_the_moving_picture_is_small_and_lasts_some_seconds() -> None:
    file = ROOT / "docs" / "pictures" / "crossing.webp"
    assert file.stat().st_size < 1_500_000
    with Image.open(file) as picture:
        frames = [picture.info["duration"] for _ in ImageSequence.Iterator(picture) if picture.load()]
    assert 5000 < sum(frames) < 8500


def test_a_sheet_that_shows_another_version_is_out_of_date(monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = rsegen.compose(rsegen.load(EXAMPLES["five-pallet-dash"])).alone
    assert shows(SHEET, recipe)
    monkeypatch.setattr(rsegen, "__version__", "0.0.1")
    assert not shows(SHEET, recipe)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)|<img src=\"([^\"]+)\"", page.read_text("utf-8"))
    made = re.findall(r"-o docs/(\S+\.html)", (ROOT / "Makefile").read_text("utf-8"))  # with the site
    assert [link for link in map("".join, links) if link not in made and not (page.parent / link).exists()] == []


def test_the_site_finds_pictures_in_html() -> None:
    """The site rewrites links of Markdown alone, so a page must lie where its file lies."""
    assert any('<img src="pictures/' in page.read_text("utf-8") for page in PAGES)
    assert re.search("^use_directory_urls: false", (ROOT / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)


def headings(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    titles = re.findall(r"^#{1,6} (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize(
    "page", [*PAGES, *sorted((ROOT / "docs" / "decisions").glob("*.md"))], ids=lambda page: page.name
)
def test_links_to_headings_lead_to_one(page: Path) -> None:
    """The site names headings otherwise than GitHub; `make site` checks its own."""
    links = re.findall(r"\]\(([^)#: ]*\.md|)#([^)]+)\)", page.read_text("utf-8"))
    assert [(file, name) for file, name in links if name not in headings(page.parent / file if file else page)] == []
