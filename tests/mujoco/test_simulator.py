"""Messages if MuJoCo is missing, too old, or taken away."""

from __future__ import annotations

import importlib.metadata
import shutil
import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from pathlib import Path
from xml.etree.ElementTree import Element

import pytest

import rsegen
from rsegen.errors import FileError, NoSimulator, UnknownName
from rsegen.mujoco.simulator import Mujoco
from rsegen.params.registry import Registry
from rsegen.robots.files.mjcf_compile import compiled
from rsegen.simulators.embedded import EMBEDDED, EmbeddedSimulator, embedded_simulator

RECIPE = rsegen.Recipe(name="course", seed=1, chunk_size=2)


def test_its_version_is_that_of_its_wheel() -> None:
    assert Mujoco().version() == importlib.metadata.version("mujoco-core")
    assert str(Mujoco()) == f"MuJoCo {importlib.metadata.version('mujoco-core')}"


@pytest.mark.parametrize("found", [None, "3.10.0"])
def test_without_it_the_message_says_how_to_get_it_and_what_else_drives(
    found: str | None, monkeypatch: pytest.MonkeyPatch, refused: Callable[..., str]
) -> None:
    monkeypatch.setattr("rsegen.mujoco.simulator.find_spec", lambda _: found and ModuleSpec("mujoco", None, origin="a"))
    monkeypatch.setattr("rsegen.mujoco.simulator.version", lambda _: found)
    line = refused("drive", "peak", "--robot", "crawler")
    old = f"mujoco-core {found} is installed, which is too old; to install MuJoCo 4: pip install -U 'mujoco-core>=4'"
    missing = "MuJoCo 4 is not installed; to install it: pip install 'mujoco-core>=4'"
    assert (old if found else missing) in line
    assert "Gazebo drives: choose the simulator sim or classic" in line
    with pytest.raises(NoSimulator, match="which is too old" if found else "many drives need MuJoCo"):
        rsegen.drive_many(RECIPE)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of packages with both that have had MuJoCo's files, the newer one whole."""
    for package, found in (("mujoco_core", "4.0.1"), ("mujoco", "3.17.0")):
        information = tmp_path / f"{package}-{found}.dist-info"
        information.mkdir()
        (information / "METADATA").write_text(f"Metadata-Version: 2.4\nName: {package}\nVersion: {found}\n")
        (information / "RECORD").write_text("mujoco/__init__.py,,3\nmujoco/__pycache__/compiled.pyc,,\n")
    (tmp_path / "mujoco").mkdir()
    (tmp_path / "mujoco" / "__init__.py").write_text("new")
    others = [path for path in sys.path if not Path(path, "mujoco").is_dir()]
    monkeypatch.setattr("sys.path", [str(tmp_path), *others])
    monkeypatch.delitem(sys.modules, "mujoco", raising=False)
    return tmp_path


def test_an_old_package_that_has_overwritten_the_library_is_refused(installed: Path) -> None:
    assert Mujoco().version() == "4.0.1"
    (installed / "mujoco" / "__init__.py").write_text("older")
    with pytest.raises(
        NoSimulator, match=r"^mujoco 3\.17\.0 has overwritten files of mujoco-core 4\.0\.1; .*uninstall"
    ):
        Mujoco().version()


def test_a_library_whose_files_went_with_another_package_is_refused(installed: Path) -> None:
    (installed / "mujoco" / "__init__.py").unlink()
    shutil.rmtree(installed / "mujoco-3.17.0.dist-info")
    with pytest.raises(NoSimulator, match=r"^files of mujoco-core 4\.0\.1 are missing; .*uninstall"):
        Mujoco().version()
    with pytest.raises(FileError, match="MJCF is read by MuJoCo, which is not installed"):
        compiled(Element("mujoco"), "robot.xml")


def test_names_are_those_of_all_simulators() -> None:
    assert embedded_simulator(None) is embedded_simulator("mujoco") is EMBEDDED["mujoco"]
    assert embedded_simulator("classic") is None
    with pytest.raises(UnknownName, match="unknown simulator 'mujocco'; did you mean 'mujoco'"):
        embedded_simulator("mujocco")


def test_without_the_capability_a_drive_asks_for_a_gazebo(monkeypatch: pytest.MonkeyPatch) -> None:
    none = Registry[EmbeddedSimulator]("embedded simulator", contract=EMBEDDED.contract)
    monkeypatch.setattr("rsegen.simulators.embedded.EMBEDDED", none)
    assert embedded_simulator(None) is None
