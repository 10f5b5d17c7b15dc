"""MuJoCo as an embedded simulator: what is installed, and worlds in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from importlib.metadata import PackageNotFoundError, files, version
from importlib.util import find_spec
from math import inf
from pathlib import Path
from platform import machine, system
from typing import ClassVar

from rsegen.errors import NoSimulator, line_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AS_DRAWN, AsBuilt, EmbeddedSimulator, EmbeddedWorld, PlacedRobot, register

_FIRST = 4
"""The first version in which the surface of a shape can move (`surfacevel`), of which belts are made."""

_PACKAGES = ("mujoco-core", "mujoco")
"""Packages of the library: from version 4 on, and before. Both install the same files."""


@register
class Mujoco(EmbeddedSimulator):
    """MuJoCo: rigid bodies, joints, motors and contacts in one library, which simulates many times faster than life."""

    name: ClassVar[str] = "mujoco"
    title: ClassVar[str] = "MuJoCo"
    how_to_install: ClassVar[tuple[str, ...]] = (
        f"pip install 'mujoco-core>={_FIRST}' (wheels: Linux x86_64 and aarch64, macOS arm64, Windows x86_64)",
        f"this is {system()} {machine()}; where there is no wheel, Gazebo drives: choose the simulator sim or classic",
    )

    def version(self) -> str | None:
        """Return the version of the library; None if it is not installed, NoSimulator if it is too old or broken."""
        spec = find_spec("mujoco")
        if spec is None:
            return None
        packages = _packages()
        if not packages:
            return None
        package, installed = next(iter(packages.items()))
        if _is_old(installed):
            how = f"to install {self.title} {_FIRST}: pip install -U '{package}>={_FIRST}'"
            raise NoSimulator(f"{package} {installed} is installed, which is too old; {how}; {self.how_to_install[1]}")
        _refuse_broken(packages, has_code=spec.origin is not None)
        return installed

    def world(
        self,
        scene: Scene,
        robots: Sequence[PlacedRobot],
        *,
        motors: str = MOTORS[0],
        period: float = 0.05,
        built: AsBuilt = AS_DRAWN,
    ) -> EmbeddedWorld:
        """Return the world of a scene with robots at their starts; period: seconds between two rows of the record."""
        self.refuse_missing()
        from rsegen.mujoco.turning import turn_gain
        from rsegen.mujoco.world import MujocoWorld

        gains = [turn_gain(placed.robot) for placed in robots]
        return MujocoWorld(scene, robots, motors=motors, period=period, gains=gains, built=built)

    def show(
        self,
        scene: Scene,
        robots: Sequence[PlacedRobot],
        seconds: float | None,
        *,
        headless: bool,
        on_start: Callable[[], None],
    ) -> None:
        """Simulate a scene with robots that stand in real time, in MuJoCo's own window unless `headless`."""
        self.refuse_missing()
        from rsegen.mujoco.window import simulate, window_on
        from rsegen.mujoco.world import MujocoWorld
        from rsegen.pictures.camera import south_west_of

        # It keeps no record, and goes on if somebody presses a robot into the ground.
        world = MujocoWorld(scene, robots, period=inf, seen=not headless)
        camera = south_west_of(scene.field.extent)
        with nullcontext() if headless else window_on(world, camera) as window:
            on_start()
            simulate(world, seconds, window)

    def refuse_missing(self) -> None:
        """Raise a NoSimulator if the library is not installed, or cannot be loaded."""
        if self.version() is None:
            raise NoSimulator(
                f"{self.title} {_FIRST} is not installed; to install it: {'; '.join(self.how_to_install)}"
            )
        try:
            import mujoco  # noqa: F401  # whether it can be
        except (ImportError, OSError) as error:  # such as a wheel for another machine
            raise NoSimulator(f"{self.title} is installed, but not loaded: {line_of(str(error))}") from None


def _packages() -> dict[str, str]:
    """Return the versions of the packages of MuJoCo that are installed, by their names."""
    versions = {}
    for package in _PACKAGES:
        with suppress(PackageNotFoundError):
            versions[package] = version(package)
    return versions


def _is_old(installed: str) -> bool:
    return int(installed.partition(".")[0]) < _FIRST


def _refuse_broken(packages: Mapping[str, str], *, has_code: bool) -> None:
    """Raise a NoSimulator if another package has overwritten files of the library, or taken them along.

    Installers do so silently if something wants a MuJoCo before version 4: a mixture of both may load, and its version
    is not the one that is installed. Without its code, Python takes what is left of a package for an empty one.
    """
    new, old = _PACKAGES
    is_mixed = new in packages and old in packages and _is_old(packages[old]) and not _is_whole(new)
    if is_mixed or not has_code:
        name = f"{new} {packages[new]}" if new in packages else f"{old} {packages[old]}"
        damage = (
            f"{old} {packages[old]} has overwritten files of {name}" if is_mixed else f"files of {name} are missing"
        )
        how = f"pip uninstall {old} {new}, then pip install '{new}>={_FIRST}'"
        raise NoSimulator(f"{damage}; to have MuJoCo {_FIRST} again: {how}")


def _is_whole(package: str) -> bool:
    """Return whether the files of a package have the sizes with which they were installed."""
    installed = [(Path(file.locate()), file.size) for file in files(package) or () if file.size is not None]
    return all(path.is_file() and path.stat().st_size == size for path, size in installed)
