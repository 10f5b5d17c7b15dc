"""ROS 2's own tools judge the package; where colcon or ament_cmake are not there, CMake with a stand-in for it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from math import radians
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import ExportedMap, Recipe, Scene, compose, export_maps
from rsegen.gazebo import MESH_TYPES
from rsegen.heights.base import imported
from rsegen.heights.image import OccupancyImage
from rsegen.ros2.ros2 import Ros2, package_name
from tests.formats.maps import RECIPES, SCENES
from tests.formats.maps import made as made_files
from tests.real.maps import slippery
from tests.support.complaints import exit_code, the_line
from tests.support.missing import missing
from tests.support.runs import contents

SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
SLIPPERY = compose(next(slippery()))
NAMED = compose(Recipe(name="2026.Pallet--A", seed=3, chunk_size=3))
LINTERS = ("ament_flake8", "ament_pep257", "ament_lint_cmake", "ament_xmllint")
VARIABLES = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")

AMENT = """\
function(ament_environment_hooks template)
  get_filename_component(name "${template}" NAME_WLE)
  configure_file("${template}" "${CMAKE_BINARY_DIR}/${name}" @ONLY)
  install(FILES "${CMAKE_BINARY_DIR}/${name}" DESTINATION "share/${PROJECT_NAME}/environment")
endfunction()
macro(ament_package)
  install(FILES package.xml DESTINATION "share/${PROJECT_NAME}")
endmacro()
"""
"""Commands of ament_cmake that the package uses, and no more."""


def written(scene: Scene, folder: Path, package: Ros2 | None = None) -> Path:
    """The folder of the package."""
    for path, content in made_files(package or Ros2(), scene).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
    return folder / package_name(scene.name)


def installed_by_cmake(source: Path, folder: Path) -> Path:
    """The prefix into which the package was installed, with the stand-in for ament_cmake."""
    cmake = shutil.which("cmake") or pytest.skip("no cmake here")
    (folder / "ament").mkdir()
    (folder / "ament" / "ament_cmakeConfig.cmake").write_text(AMENT)
    where = [f"-Dament_cmake_DIR={folder / 'ament'}", f"-DCMAKE_INSTALL_PREFIX={folder / 'install'}"]
    subprocess.run([cmake, "-S", source, "-B", folder / "build", *where], check=True, capture_output=True)
    subprocess.run([cmake, "--install", folder / "build"], check=True, capture_output=True)
    return folder / "install"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # catkin_pkg asks pyparsing in its old words
@SCENE
def test_catkin_pkg_takes_the_package_for_valid(scene: Scene, tmp_path: Path) -> None:
    packages = pytest.importorskip("catkin_pkg.package", reason="catkin_pkg is not installed")
    warnings: list[str] = []
    found = packages.parse_package(str(written(scene, tmp_path)), warnings=warnings)
    assert warnings == []
    assert found.name == package_name(scene.name)
    assert found.package_format == 3
    assert found.get_build_type() == "ament_cmake"
    assert [(each.file, str(each)) for each in found.licenses] == [("LICENSE", "Apache-2.0")]
    assert [each.type for each in found.urls] == ["website"]
    for distribution, classic in {"humble": {"gazebo_ros"}, "jazzy": set()}.items():
        found.evaluate_conditions({"ROS_DISTRO": distribution})
        needed = {each.name for each in found.exec_depends if each.evaluated_condition}
        assert needed == named(Path(found.filename).parent) | classic | {"launch", "launch_ros", *INDIRECT}


INDIRECT = {"nav2_costmap_2d", "sdformat_urdf"}
"""Packages that others load: the layers of Nav2's costmaps, and the parser of SDF robots."""


def named(package: Path) -> set[str]:
    """The packages whose programs, modules and plug-ins the files of a package name."""
    launched = "".join(path.read_text() for path in package.glob("launch/*.py"))
    nodes = re.findall(r"(?:package='|Share\('|: \(')([a-z]\w+)'", launched)
    nav2 = re.findall(r": '(nav2_\w+)',|f'(nav2_\w+)\{BETWEEN", launched)
    plugins = re.findall(r"plugin: (\w+)::", (package / "config" / "nav2.yaml").read_text())
    displays = {"grid_map_rviz_plugin"} & set(
        re.findall(r"Class: (\w+)/", (package / "config" / "map.rviz").read_text())
    )
    node = (package / "nodes" / "elevation.py").read_text()
    modules = set(re.findall(r"^(?:import|from) (\w+)", node, re.M)) - {"array", "json", "pathlib"}
    modules = {"python3-numpy" if module == "numpy" else module for module in modules}
    commands = {"xacro"} if "Command(['xacro " in launched else set()
    keys = re.findall(r"ros2 run (\w+)", (package / "README.md").read_text())
    found = {*nodes, *(name for pair in nav2 for name in pair if name), *plugins, *displays, *modules, *commands, *keys}
    return found - {"gazebo_ros"}


@pytest.mark.slow
@given(name=st.from_regex(r"[A-Za-z0-9_][A-Za-z0-9_.\-]{0,63}_[0-9]{4}", fullmatch=True))
def test_any_map_s_name_gives_a_package_s(name: str) -> None:
    found = package_name(name)
    assert re.fullmatch(r"[a-z]([a-z0-9]|_(?!_))+", found)
    assert package_name(found) == found


@pytest.mark.parametrize(
    ("name", "package"), [("rse_0000", "rse_0000"), ("2026.Pallet--A_0000", "map_2026_pallet_a_0000")]
)
def test_a_package_is_named_after_its_map(name: str, package: str) -> None:
    assert package_name(name) == package


@pytest.mark.long(reason="CMake, 0.1 GB")
@pytest.mark.parametrize("scene", [NAMED, SCENES["nothing"]], ids=["a name that ROS refuses", "nothing"])
def test_cmake_installs_the_files_of_the_package(scene: Scene, tmp_path: Path) -> None:
    source = written(scene, tmp_path / "src")
    share = installed_by_cmake(source, tmp_path) / "share" / source.name
    there, held = contents(share), contents(source)
    for part in ("LICENSE", "README.md", "config", "launch", "maps", "models", "nodes", "robots", "urdf", "worlds"):
        assert {name for name in there if name.startswith(part)} == {name for name in held if name.startswith(part)}
    hook = (share / "environment" / f"{source.name}.dsv").read_text().splitlines()
    assert hook == [f"prepend-non-duplicate;{variable};share/{source.name}/models" for variable in VARIABLES]


@pytest.mark.long(reason="colcon, which scripts/ros2 installs")
@pytest.mark.slow
def test_colcon_builds_it_and_its_setup_says_where_the_models_are(tmp_path: Path) -> None:
    """With the real ament_cmake, which takes the python3 beside colcon."""
    colcon = shutil.which("colcon") or missing("no colcon: run scripts/ros2")
    prefixes = [*filter(None, os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)), "/usr"]
    if not any((Path(prefix) / "share" / "ament_cmake").is_dir() for prefix in prefixes):
        missing("no ament_cmake: run scripts/ros2, or name its folder in CMAKE_PREFIX_PATH")
    tools = os.environ | {"PATH": f"{Path(colcon).parent}{os.pathsep}{os.environ['PATH']}"}
    tools.pop("VIRTUAL_ENV", None)  # CMake would take the python3 in it
    for scene in (NAMED, SCENES["frames alone"]):
        written(scene, tmp_path / "src")
    subprocess.run([colcon, "build"], cwd=tmp_path, env=tools, check=True, capture_output=True)
    _test_with_linters(colcon, tmp_path, tools)
    shell = ["bash", "-c", ". install/setup.bash && env"]
    bare = {name: value for name, value in tools.items() if name not in VARIABLES}
    environment = subprocess.run(shell, cwd=tmp_path, env=bare, check=True, capture_output=True, text=True).stdout
    said = dict(line.split("=", 1) for line in environment.splitlines() if "=" in line)
    for variable in VARIABLES:
        folders = {Path(folder).resolve() for folder in said[variable].split(os.pathsep)}
        assert {model.name for folder in folders for model in folder.iterdir()} == {NAMED.name, "rse_0000"}


def _test_with_linters(colcon: str, workspace: Path, tools: Mapping[str, str]) -> None:
    """The package's own tests: ament's linters, as many as CMake found."""
    if not all(map(shutil.which, LINTERS)):
        return
    subprocess.run([colcon, "test"], cwd=workspace, env=tools, check=True, capture_output=True)
    said = subprocess.run(
        [colcon, "test-result", "--all"], cwd=workspace, env=tools, check=False, capture_output=True, text=True
    )
    assert said.returncode == 0, said.stdout
    for linter in ("flake8", "lint_cmake", "pep257", "xmllint"):
        assert re.search(rf"rse_0000/test_results/rse_0000/{linter}.xunit.xml: [1-9]", said.stdout), said.stdout


@pytest.mark.parametrize("scene", [*SCENES.values(), SLIPPERY], ids=[*SCENES, "several frictions"])
def test_the_model_is_the_one_of_a_single_world(scene: Scene, tmp_path: Path) -> None:
    package = written(scene, tmp_path)
    files = MESH_TYPES["single"].files(scene)
    expected = {path: b"".join(content) for path, content in files.items() if ".world" not in path}
    assert contents(package / "models" / scene.name) == expected
    world = ET.parse(package / "worlds" / f"{scene.name}.world").getroot()
    assert [uri.text for uri in world.iter("uri")] == [f"model://{scene.name}"]
    assert world.find("world/model[@name='ground_plane']") is not None


@SCENE
def test_the_occupancy_grid_has_free_ground_around_the_map_and_the_start_pose_on_it(
    scene: Scene, tmp_path: Path
) -> None:
    folder = written(scene, tmp_path) / "maps" / scene.name
    grid, field = imported(folder / "map.yaml", OccupancyImage()), scene.field
    levels = rsegen.build(grid).levels
    margin = round(2 / field.block_width + 0.499)
    inside = levels[margin:-margin, margin:-margin]
    assert (inside == (field.heights > field.unit)).all()
    assert levels.sum() == inside.sum()
    start = json.loads((folder / "start_poses.json").read_text())["ground"]
    corner = yaml.safe_load((folder / "map.yaml").read_text())["origin"]
    assert corner[0] < start["x"] < -field.extent[0] / 2
    assert start["y"] == start["yaw"] == 0


@SCENE
def test_elevation_and_friction_are_those_of_every_cell_with_ground_around(scene: Scene, tmp_path: Path) -> None:
    folder, field = written(scene, tmp_path) / "maps" / scene.name, scene.field
    about = json.loads((folder / "elevation.json").read_text())
    elevation, friction = (np.load(folder / f"{layer}.npy") for layer in about["layers"])
    margin = round(2 / field.block_width + 0.499)
    inside = (slice(margin, -margin),) * 2
    assert elevation.shape == friction.shape == tuple(side + 2 * margin for side in field.shape)
    assert (elevation[inside] == field.heights.astype(np.float32)).all()
    assert np.count_nonzero(elevation) == np.count_nonzero(field.heights)
    assert (friction == np.float32(scene.friction)).all()
    assert about["cell_size"] == field.block_width


def test_a_map_of_tiny_blocks_has_500_cells_of_ground_around(tmp_path: Path) -> None:
    scene = compose(Recipe(chunk_size=2, boundary="none", block_width_cm=0.1, unit_cm=0.1))
    folder = written(scene, tmp_path) / "maps" / scene.name
    assert np.load(folder / "elevation.npy").shape == (1002, 1002)
    assert (folder / "map.pgm").read_bytes().startswith(b"P5\n1002 1002\n")


FRAMED = Recipe(seed=3, chunk_size=4, level_friction=(0.3, 1.0, 0.6), obstacles=[rsegen.Random(levels=3)])


@pytest.mark.parametrize("scene", [SLIPPERY, compose(FRAMED)], ids=["bare", "framed"])
def test_friction_is_that_of_the_level_of_each_block_and_of_the_frame(scene: Scene, tmp_path: Path) -> None:
    folder, field = written(scene, tmp_path) / "maps" / scene.name, scene.field
    margin = round(2 / field.block_width + 0.499)
    friction = np.load(folder / "friction.npy")[margin:-margin, margin:-margin]
    for i, j in np.ndindex(field.shape):
        level = 0 if field.frame[i, j] else int(field.levels[i, j])
        on_ground = level == 0 and not field.frame[i, j]
        expected = scene.friction if on_ground else scene.friction_of(level)
        assert friction[i, j] == np.float32(expected)
    assert len(np.unique(friction)) > 1


def test_the_default_robot_starts_on_a_spot_of_the_map_and_the_others_on_the_ground(tmp_path: Path) -> None:
    scene = compose(Recipe(seed=3, chunk_size=8, boundary="none"))
    package = written(scene, tmp_path, Ros2(robot="burger"))
    poses = json.loads((package / "maps" / "rse_0000" / "start_poses.json").read_text())
    assert poses.keys() == {"ground", "burger"}
    spot = poses["burger"]
    rest = rsegen.poses(scene.field, "burger", spot["x"], spot["y"], spot["yaw"])
    assert rest.pushes.all()
    assert float(rest.tilt[0]) < radians(3)
    assert 0 < spot["z"] - float(rest.z[0]) < 0.01
    assert max(abs(spot["x"]), abs(spot["y"])) < scene.field.extent[0] / 2
    assert "default_value='burger'" in (package / "launch" / "spawn_robot.launch.py").read_text()


def test_a_map_without_a_spot_has_the_pose_on_the_ground_alone(tmp_path: Path) -> None:
    scene = compose(Recipe(seed=3, chunk_size=2, boundary="none"))
    poses = json.loads(made_files(Ros2(robot="crawler"), scene)["rse_0000/maps/rse_0000/start_poses.json"])
    assert poses.keys() == {"ground"}


def test_an_unknown_robot_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("export", "peak", "--to", "ros2 robot=berger", "-o", str(tmp_path / "out")) == 2
    assert "unknown robot 'berger'; did you mean 'burger'?" in the_line(capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


def test_a_joined_package_is_kept_or_replaced_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    to = ["--to", "ros2 package=fields", "-o", str(tmp_path)]
    assert exit_code("export", "peak", "--seed", "3", "--maps", "2", *to) == 0
    before = contents(tmp_path)
    assert exit_code("export", "peak", "--seed", "3", "--maps", "2", *to, "--resume") == 0
    assert contents(tmp_path) == before
    capsys.readouterr()
    for flags, problem in (
        (["--maps", "2"], "exists already; use --force"),
        (["--maps", "3", "--resume"], "exists already and contains other maps, or not all of these"),
        (["--maps", "1", "--resume"], "exists already and contains other maps, or not all of these"),
        (["--maps", "2", "--to", "stl"], "puts all maps into one folder, fields, and stl each into its own"),
    ):
        assert exit_code("export", "peak", "--seed", "3", *flags, *to) == 2
        assert problem in the_line(capsys.readouterr().err)
        assert contents(tmp_path) == before
    assert exit_code("export", "peak", "--seed", "4", *to, "--force") == 0
    assert sorted(path.name for path in (tmp_path / "fields" / "models").iterdir()) == ["peak_0000"]
    (tmp_path / "fields" / "package.xml").write_text("mine")
    assert exit_code("export", "peak", "--seed", "4", *to, "--force") == 2
    assert "was changed after rsegen wrote it" in the_line(capsys.readouterr().err)


def test_progress_of_a_joined_package_is_that_of_its_maps(tmp_path: Path) -> None:
    told: list[ExportedMap] = []
    maps = [Recipe(name=name, chunk_size=2, boundary="none") for name in ("one", "two")]
    made = export_maps(maps, tmp_path, [Ros2(package="fields")], progress=told.append)
    assert tuple(told) == made
    assert [f"recipes/{name}_0000.json" in each.names for name, each in zip(("one", "two"), told, strict=True)] == [
        True
    ] * 2


def test_worlds_have_no_joined_package_next_to_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("generate", "peak", "--formats", "ros2 package=fields", "-o", tmp_path / "worlds") == 2
    assert "only rsegen export writes that" in the_line(capsys.readouterr().err)
    assert not list(tmp_path.iterdir())


@pytest.mark.long(reason="linters, which scripts/ros2 installs")
@pytest.mark.slow
@pytest.mark.parametrize("linter", LINTERS)
def test_ament_s_linters_find_nothing(linter: str, tmp_path: Path) -> None:
    program = shutil.which(linter) or missing(f"no {linter}: run scripts/ros2")
    found = subprocess.run([program, "."], cwd=written(NAMED, tmp_path), capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_licence_is_that_of_rsegen(tmp_path: Path) -> None:
    assert (written(NAMED, tmp_path) / "LICENSE").read_bytes() == (Path(__file__).parents[2] / "LICENSE").read_bytes()


def test_maps_exported_into_a_workspace_are_packages_of_their_own_names(tmp_path: Path) -> None:
    names = [package_name(compose(recipe).name) for recipe in RECIPES.values()]
    assert set(names) == {"rse_0000"}
    files = made_files(Ros2(), NAMED)
    assert {path.partition("/")[0] for path in files} == {package_name(NAMED.name)}
