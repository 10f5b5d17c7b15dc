"""ROS 2's own tools judge the package; where colcon or ament_cmake are not there, CMake with a stand-in for it.

The launch files are run with stand-ins for ROS's modules, which write down what they are asked.
"""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Recipe, Scene, compose
from rsegen.exporters.formats.ros2 import Ros2, package_name
from rsegen.exporters.gazebo import single
from tests.exporters.formats.maps import RECIPES, SCENES, made
from tests.simulation.real.conftest import missing
from tests.simulation.real.maps import slippery
from tests.support.runs import contents

SCENE = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
SLIPPERY = compose(next(slippery()))
NAMED = compose(Recipe(name="2026.Pallet--A", seed=3, chunk_size=3))
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
"""What the package asks of ament_cmake, and no more."""


def written(scene: Scene, folder: Path) -> Path:
    """The folder of the package."""
    for path, content in made(Ros2(), scene).items():
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
    for distribution, simulators in {"humble": {"gazebo_ros", "ros_gz_sim"}, "jazzy": {"ros_gz_sim"}}.items():
        found.evaluate_conditions({"ROS_DISTRO": distribution})
        needed = {each.name for each in found.exec_depends if each.evaluated_condition}
        assert needed == simulators | {"ament_index_python", "launch"}


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


@pytest.mark.parametrize("scene", [NAMED, SCENES["nothing"]], ids=["a name that ROS refuses", "nothing"])
def test_cmake_installs_what_the_package_holds(scene: Scene, tmp_path: Path) -> None:
    source = written(scene, tmp_path / "src")
    share = installed_by_cmake(source, tmp_path) / "share" / source.name
    there, held = contents(share), contents(source)
    for part in ("launch", "models", "worlds"):
        assert {name for name in there if name.startswith(part)} == {name for name in held if name.startswith(part)}
    hook = (share / "environment" / f"{source.name}.dsv").read_text().splitlines()
    assert hook == [f"prepend-non-duplicate;{variable};share/{source.name}/models" for variable in VARIABLES]


@pytest.mark.slow
def test_colcon_builds_it_and_its_setup_says_where_the_models_are(tmp_path: Path) -> None:
    """With the real ament_cmake, which takes the python3 beside colcon."""
    colcon = shutil.which("colcon") or missing("no colcon: run scripts/ros2")
    prefixes = [*filter(None, os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)), "/usr"]
    if not any((Path(prefix) / "share" / "ament_cmake").is_dir() for prefix in prefixes):
        missing("no ament_cmake: run scripts/ros2, or name its folder in CMAKE_PREFIX_PATH")
    tools = os.environ | {"PATH": f"{Path(colcon).parent}{os.pathsep}{os.environ['PATH']}"}
    for scene in (NAMED, SCENES["frames alone"]):
        written(scene, tmp_path / "src")
    subprocess.run([colcon, "build"], cwd=tmp_path, env=tools, check=True, capture_output=True)
    shell = ["bash", "-c", ". install/setup.bash && env"]
    bare = {name: value for name, value in tools.items() if name not in VARIABLES}
    environment = subprocess.run(shell, cwd=tmp_path, env=bare, check=True, capture_output=True, text=True).stdout
    said = dict(line.split("=", 1) for line in environment.splitlines() if "=" in line)
    for variable in VARIABLES:
        folders = {Path(folder).resolve() for folder in said[variable].split(os.pathsep)}
        assert {model.name for folder in folders for model in folder.iterdir()} == {NAMED.name, "rse_0000"}


@pytest.mark.parametrize("scene", [*SCENES.values(), SLIPPERY], ids=[*SCENES, "several frictions"])
def test_the_model_is_the_one_of_a_single_world(scene: Scene, tmp_path: Path) -> None:
    package = written(scene, tmp_path)
    expected = {path: b"".join(content) for path, content in single.files(scene).items() if ".world" not in path}
    assert contents(package / "models" / scene.name) == expected
    world = ET.parse(package / "worlds" / f"{scene.name}.world").getroot()
    assert [uri.text for uri in world.iter("uri")] == [f"model://{scene.name}"]
    assert world.find("world/model[@name='ground_plane']") is not None


class Stand:
    """In place of any class of ROS's launch: what it was made of."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, {name: _plain(value) for name, value in named.items()}


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, type({}.items())) else value


@pytest.fixture
def ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Path], list[Stand]]:
    """Runs a launch file, and gives what it launches."""
    modules: Mapping[str, Mapping[str, object]] = {
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(tmp_path / "share" / name)},
        "launch": {"LaunchDescription": list},
        "launch.actions": dict.fromkeys(["DeclareLaunchArgument", "IncludeLaunchDescription"]),
        "launch.conditions": dict.fromkeys(["IfCondition"]),
        "launch.launch_description_sources": dict.fromkeys(["PythonLaunchDescriptionSource"]),
        "launch.substitutions": dict.fromkeys(["LaunchConfiguration"]),
    }
    for name, members in modules.items():
        module = ModuleType(name)
        for member, value in members.items():
            setattr(module, member, value or type(member, (Stand,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    return lambda file: runpy.run_path(str(file))["generate_launch_description"]()


def test_gazebo_classic_is_launched_with_the_world_and_a_window(
    tmp_path: Path, ros: Callable[[Path], list[Stand]]
) -> None:
    package = written(NAMED, tmp_path)
    gui, server, window = ros(package / "launch" / "gazebo_classic.launch.py")
    share = tmp_path / "share"
    assert gui.arguments == ("gui",)
    assert server.arguments[0].arguments == (str(share / "gazebo_ros" / "launch" / "gzserver.launch.py"),)
    world = share / package.name / "worlds" / f"{NAMED.name}.world"
    assert server.named["launch_arguments"] == {"world": str(world)}
    assert window.arguments[0].arguments == (str(share / "gazebo_ros" / "launch" / "gzclient.launch.py"),)
    assert window.named["condition"].arguments[0].arguments == ("gui",)


def test_gazebo_sim_is_launched_with_the_world_and_options(tmp_path: Path, ros: Callable[[Path], list[Stand]]) -> None:
    package = written(NAMED, tmp_path)
    options, gazebo = ros(package / "launch" / "gazebo_sim.launch.py")
    share = tmp_path / "share"
    assert (options.arguments, options.named["default_value"]) == (("options",), "-r")
    assert gazebo.arguments[0].arguments == (str(share / "ros_gz_sim" / "launch" / "gz_sim.launch.py"),)
    first, space, world = gazebo.named["launch_arguments"]["gz_args"]
    assert (first.arguments, space) == (("options",), " ")
    assert world == str(share / package.name / "worlds" / f"{NAMED.name}.world")


def test_maps_exported_into_a_workspace_are_packages_of_their_own_names(tmp_path: Path) -> None:
    names = [package_name(compose(recipe).name) for recipe in RECIPES.values()]
    assert set(names) == {"rse_0000"}
    files = made(Ros2(), NAMED)
    assert {path.partition("/")[0] for path in files} == {package_name(NAMED.name)}
