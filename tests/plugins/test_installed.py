"""A package that somebody installs beside rsegen is at home everywhere."""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import rsegen
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe
from tests.plugins.installed import DEMO, EAGER, RAMP, STEPS, done, install, refused, run
from tests.support.long import long_unless

RECIPE = "boundary: none\nseed: 1\nmaps: 3\nobstacles:\n  - {kind: ramp, levels: 5, first: [0, 0], last: [8, 9]}\n"


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return install(tmp_path_factory.mktemp("packages"))


@pytest.fixture(scope="module")
def worlds(packages: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three maps of a flag, made by two workers, with the package's format."""
    folder = tmp_path_factory.mktemp("worlds")
    flags = ["--seed", "1", "--boundary", "none", "--maps", "3", "--obstacle", RAMP]
    formats = ["--formats", "ascii", "--workers", "2"]
    done("generate", *flags, *formats, "-o", folder / "worlds", packages=packages, code=EAGER)
    return folder / "worlds"


@pytest.mark.slow
def test_an_obstacle_is_a_flag_s_and_made_by_workers(worlds: Path) -> None:
    for number in range(3):
        levels = (worlds / f"rse_000{number}" / "levels.csv").read_text("utf-8").splitlines()
        assert levels[1:] == [STEPS] * 10


def test_an_obstacle_is_a_recipe_file_s(packages: Path, tmp_path: Path) -> None:
    (tmp_path / "ramp.yaml").write_text(RECIPE)
    said = json.loads(done("info", tmp_path / "ramp.yaml", "--json", packages=packages))
    assert said["levels"] == [0, 1, 2, 3, 4] or said["levels"] == ["0", "1", "2", "3", "4"]


@pytest.mark.slow
def test_lists_show_it_with_its_package(packages: Path) -> None:
    kinds = done("obstacles", packages=packages)
    assert "ramp\n    Steps that rise along x from first to last. From rsegen-demo 1.2.\n" in kinds
    assert "    tread          depth of a step: 1..100 blocks\n" in kinds
    assert "ascii\n    Heights as an ASCII grid" in done("export", "--list", packages=packages)
    assert "buy a pencil" in done("sim", packages=packages)
    for command in ("drive", "metrics", "spawn"):
        assert "tall_burger" in done(command, "--help", packages=packages)


def test_the_schema_knows_its_parameters(packages: Path) -> None:
    rows = json.loads(done("schema", packages=packages))["properties"]["obstacles"]["items"]["oneOf"]
    (ramp,) = (row for row in rows if row["title"] == "ramp")
    assert ramp["properties"]["tread"]["maximum"] == 100


def test_recipes_record_the_package_and_its_version(worlds: Path) -> None:
    for number in range(3):
        content = json.loads((worlds / f"rse_000{number}" / "recipe.json").read_text("utf-8"))
        assert content["plugins"] == {"ramp": "rsegen-demo 1.2"}


def test_formats_record_it_too(worlds: Path) -> None:
    said = json.loads((worlds / "rse_0000" / "formats.json").read_text("utf-8"))
    assert said == {"ascii": {"digits": 3, "plugin": "rsegen-demo 1.2"}}


def test_a_recipe_without_plug_ins_records_none() -> None:
    assert "plugins" not in to_json(Recipe(seed=1))


def test_info_names_the_package(packages: Path, worlds: Path) -> None:
    one = worlds / "rse_0000"
    assert done("info", one, packages=packages).endswith("\nplug-in  ramp of rsegen-demo 1.2\n")
    assert json.loads(done("info", one, "--json", packages=packages))["plugins"] == {"ramp": "rsegen-demo 1.2"}


def test_the_missing_package_is_named_with_the_command_that_installs_it(worlds: Path) -> None:
    line = refused("info", worlds)
    assert line.startswith(
        f"rsegen: {worlds / 'rse_0000' / 'recipe.json'}: the obstacle kind 'ramp' of rsegen-demo 1.2"
    )
    assert line.endswith(f"is not installed; {sys.executable} -m pip install 'rsegen-demo==1.2'")


def test_another_version_of_the_package_is_warned_of(worlds: Path, tmp_path: Path) -> None:
    found = run("info", worlds, packages=install(tmp_path, "1.3"))
    assert found.returncode == 0
    warned = "ramp of rsegen-demo 1.2 was used to make this, and rsegen-demo 1.3 is here: maps may differ"
    assert found.stderr == f"rsegen: warning: {warned}\n"


def test_resume_makes_missing_outputs(packages: Path, tmp_path: Path) -> None:
    (tmp_path / "ramp.yaml").write_text(RECIPE)
    command = ("generate", tmp_path / "ramp.yaml", "-o", tmp_path / "worlds")
    done(*command, packages=packages)
    before = (tmp_path / "worlds" / "rse_0001" / "recipe.json").read_bytes()
    (tmp_path / "worlds" / "rse_0001").rename(tmp_path / "gone")
    done(*command, "--resume", packages=packages)
    assert (tmp_path / "worlds" / "rse_0001" / "recipe.json").read_bytes() == before


@pytest.mark.slow
def test_a_format_exports_and_an_importer_reads_it_back(packages: Path, worlds: Path, tmp_path: Path) -> None:
    done("export", worlds, "--map", "0", "--to", "ascii digits=2", "-o", tmp_path / "out", packages=packages)
    grid = tmp_path / "out" / "rse_0000" / "ascii" / "rse_0000.heights"
    assert grid.read_text("utf-8").splitlines()[3] == "0.00 0.00 0.10 0.10 0.20 0.20 0.30 0.30 0.40 0.00"
    done("import", grid, "--head", "3", "-o", tmp_path / "back", packages=packages)
    levels = (tmp_path / "back" / "rse_0000_0000" / "levels.csv").read_text("utf-8").splitlines()
    assert levels[1:] == [STEPS] * 10


@pytest.mark.slow
def test_a_robot_gives_its_figures(packages: Path) -> None:
    small = [
        "--obstacle",
        "random levels=2",
        "--chunk-size",
        "4",
        "--boundary",
        "none",
        "--unit-cm",
        "1",
        "--seed",
        "1",
    ]
    said = json.loads(done("metrics", *small, "--robot", "tall_burger", "--json", packages=packages))
    as_file = json.loads(done("metrics", *small, "--robot", "burger", "--json", packages=packages))
    assert said[0]["reach"] == as_file[0]["reach"]  # as of the Burger, of which it is made


@pytest.mark.slow
def test_a_map_for_a_robot_records_its_package(packages: Path, tmp_path: Path) -> None:
    words = (
        "--seed",
        "1",
        "--chunk-size",
        "4",
        "--unit-cm",
        "0.3",
        "--crossable-by",
        "tall_burger",
        "--boundary",
        "none",
    )
    done("generate", *words, "-o", tmp_path, packages=packages)
    map_file = tmp_path / "rse_0000" / "recipe.json"
    assert json.loads(map_file.read_text("utf-8"))["plugins"] == {"tall_burger": "rsegen-demo 1.2"}
    line = refused("info", tmp_path / "rse_0000")
    assert line.startswith(f"rsegen: {map_file}: the robot 'tall_burger' of rsegen-demo 1.2 is not installed; ")
    found = run("info", tmp_path / "rse_0000", packages=install(tmp_path / "newer", "1.3"))
    assert found.returncode == 0
    assert "tall_burger of rsegen-demo 1.2 was used to make this, and rsegen-demo 1.3 is here" in found.stderr


@pytest.mark.slow
def test_a_metric_is_in_every_output(packages: Path, worlds: Path) -> None:
    (said,) = json.loads(done("metrics", worlds, "--map", "0", "--json", packages=packages))
    assert said["flat_share"] == pytest.approx(130 / 180)
    rows = list(csv.DictReader(done("metrics", worlds, "--csv", packages=packages).splitlines()))
    assert [float(row["flat_share"]) for row in rows] == pytest.approx([130 / 180] * 3)
    assert "\nflat_share 0.7222 of all pairs (Share of" in done("metrics", worlds, "--map", "0", packages=packages)
    heads, units, *_ = done("metrics", worlds, packages=packages).splitlines()
    assert heads.endswith(" flat_share")
    assert units.endswith("  of all pairs")


@pytest.mark.slow
def test_a_data_set_of_it_is_made_by_workers_and_read(packages: Path, tmp_path: Path) -> None:
    flags = ["--seed", "1", "--maps", "8", "--shard-maps", "2", "--obstacle", "ramp levels=5", "--workers", "2"]
    done("dataset", *flags, "-o", tmp_path / "set", packages=packages, code=EAGER)
    assert json.loads((tmp_path / "set" / "manifest.json").read_text("utf-8"))["recipes"][0]["plugins"] == {
        "ramp": "rsegen-demo 1.2"
    }
    script = (
        "import sys, rsegen; data = rsegen.Dataset(sys.argv[1]); data.verify(); "
        "found = data.tiles(2, 2, by='flat_share').difficulty.ravel(); print(len(data), list(found) == sorted(found))"
    )
    assert done(tmp_path / "set", packages=packages, code=script) == "8 True\n"
    assert "plug-in  ramp of rsegen-demo 1.2" in done("info", f"{tmp_path / 'set'}#3", packages=packages)
    assert "'ramp' of rsegen-demo 1.2 is not installed" in refused("info", f"{tmp_path / 'set'}#3")


ON_RAMPS = "{robots: 1, sizes: [10], recipe: {obstacles: [{kind: ramp, levels: 2}]}}"
BY_ONE = "{robot: tall_burger, robots: 1, sizes: [10]}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "row", long_unless(BY_ONE.__eq__, [ON_RAMPS, BY_ONE], reason="robots of another version are in make test")
)
def test_an_experiment_is_not_continued_with_another_version(row: str, tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(f"{{seconds: 1, repeats: 1, paces: [free], rows: [{row}]}}")
    command: list[str | Path] = [
        "experiment",
        tmp_path / "plan.yaml",
        "--simulator",
        "mujoco",
        "-q",
        "-o",
        tmp_path / "costs",
    ]
    done(*command, packages=install(tmp_path / "1"))
    done(*command, packages=tmp_path / "1")
    assert "of a robot or plug-in that was changed" in refused(*command, packages=install(tmp_path / "2", "1.3"))


@pytest.mark.slow
def test_a_rating_is_not_continued_with_another_version_of_the_robot(tmp_path: Path) -> None:
    flags = ["--by", "prediction", "--seed", "1", "-q"]
    command: list[str | Path] = ["rate", "tall_burger", *flags, "-o", tmp_path / "rating", "--trials"]
    done(*command, "8", packages=install(tmp_path / "1"))
    done(*command, "9", packages=tmp_path / "1")
    assert "has another rating" in refused(*command, "10", packages=install(tmp_path / "2", "1.3"))


def test_a_simulator_is_opened_by_its_name_if_it_is_there(packages: Path, worlds: Path) -> None:
    assert "Pencil and Paper" in refused("open", worlds, "--simulator", "paper", packages=packages)


def test_a_simulator_in_this_process_drives_where_it_is_named_alone(packages: Path, tmp_path: Path) -> None:
    command = ["drive", "peak", "--seed", "1", "--simulator", "air", "--no-predict", "--json", "-q"]
    said = json.loads(done(*command, "-o", tmp_path / "air", packages=packages))
    assert (said["simulator"], said["notes"]) == ("Thin Air 1", ["In Thin Air blocks have no weight."])
    (robot,) = said["robots"]
    assert robot["crossed"]
    assert robot["distance"] == pytest.approx(0.22 * robot["seconds"], abs=0.01), "nothing stops a Burger there"
    code = "from rsegen.simulators.embedded import *; print(*EMBEDDED, embedded_simulator(None))"
    assert done(packages=packages, code=code).startswith("mujoco air MuJoCo "), "though air comes first in the alphabet"


def test_a_simulator_of_many_worlds_drives_over_all_maps(packages: Path, tmp_path: Path) -> None:
    command = ["drives", "peak", "--maps", "3", "--simulator", "air_batch", "--json", "-q"]
    found = json.loads(done(*command, "-o", tmp_path / "drives", packages=packages))
    assert (found["simulator"], found["crossed"], found["drives"]) == ("Much Thin Air", 3, 3)


def test_there_is_a_plug_in_of_each_sort_and_the_manual_names_all() -> None:
    house = Path(rsegen.__file__).parent
    groups = {
        group
        for file in house.rglob("*.py")
        for group in re.findall(r'\bgroup="(rsegen\.\w+)"', file.read_text("utf-8"))
    }
    groups.add("rsegen.capabilities")
    assert len(groups) > 8
    assert groups == set(
        re.findall(r'^\[project\.entry-points\."(.+)"\]', (DEMO / "pyproject.toml").read_text("utf-8"), re.M)
    )
    manual = (house.parents[1] / "docs" / "plugins.md").read_text("utf-8")
    assert groups == set(re.findall(r"^\| `(rsegen\.\w+)` \|", manual, re.M))


def test_the_commands_that_need_none_look_for_none(packages: Path) -> None:
    script = (
        "import sys, rsegen; from rsegen import KINDS, build, Recipe, Peak;"
        "build(Recipe(seed=1, obstacles=[KINDS['peak'](levels=3)]), 0);"
        "print([name for name in ('importlib.metadata', 'rsegen_demo') if name in sys.modules])"
    )
    assert done(packages=packages, code=script) == "[]\n"


def test_only_requested_modules_are_imported(packages: Path) -> None:
    script = "import sys, rsegen; rsegen.KINDS['ramp']; print([name for name in sys.modules if 'demo.' in name])"
    assert done(packages=packages, code=script) == "['rsegen_demo.obstacle']\n"


@pytest.mark.slow
def test_pip_installs_it_and_it_is_found(tmp_path: Path) -> None:
    if not importlib.util.find_spec("hatchling"):
        pytest.skip("hatchling is not installed, which builds the package")
    quiet = ["-q", "--no-build-isolation", "--no-deps", "--no-index", "--disable-pip-version-check"]
    command = [sys.executable, "-m", "pip", "install", *quiet, "--target", str(tmp_path), str(DEMO)]
    subprocess.run(command, check=True, capture_output=True)
    assert "From rsegen-demo 1.2." in done("obstacles", packages=tmp_path)


def test_a_capability_brings_a_command_a_public_name_and_a_file_next_to_worlds(packages: Path, tmp_path: Path) -> None:
    assert "  tally            count the blocks of a map\n" in done("--help", packages=packages)
    assert "add the number of blocks" in done("generate", "--help", packages=packages)
    done("generate", "peak", "--tally", "-o", tmp_path / "worlds", packages=packages)
    world = tmp_path / "worlds" / "peak_0000"
    assert (world / "tally.txt").read_text() == "32\n"
    assert done("tally", world, packages=packages) == "32 blocks\n"
    assert done("tally", world, "--above", "5", packages=packages) == "0 blocks\n"
    code = (
        "import sys, rsegen; recipe = rsegen.load(sys.argv[1]);"
        "print(rsegen.tally(rsegen.build(recipe)), 'tally' in rsegen.__all__)"
    )
    assert done(world / "recipe.json", packages=packages, code=code) == "32 True\n"
