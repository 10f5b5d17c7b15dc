"""MuJoCo Warp as a batch simulator: what is installed, how many worlds fit, and worlds in it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import ClassVar

from rsegen.errors import NoSimulator, ParameterError, line_of
from rsegen.mujoco.simulator import Mujoco
from rsegen.params.extras import pip_install
from rsegen.recipe.recipe import Recipe
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.batch import BatchSimulator, BatchWorlds, register
from rsegen.simulators.embedded import PlacedRobot

_ON_GPU, _ON_CPU = 4096, 64
"""Worlds of a batch: these keep a GPU busy, and fit into it; a CPU steps one after the other."""

_BLOCKS, _MEMORY = 4000, 1_000_000
"""Blocks of a map, and of a batch, at most, were each a box: MuJoCo Warp lists all pairs of shapes, and each shape of
each world takes some 100 bytes."""


@register
class MujocoWarp(BatchSimulator):
    """MuJoCo Warp: the physics of MuJoCo in 32 bits, in thousands of worlds at once, on a GPU of CUDA or without."""

    name: ClassVar[str] = "mujoco-warp"
    title: ClassVar[str] = "MuJoCo Warp"

    def refuse_missing(self) -> None:
        """Raise a NoSimulator if MuJoCo or MuJoCo Warp is not installed, or cannot be loaded."""
        Mujoco().refuse_missing()
        if find_spec("mujoco_warp") is None:
            raise NoSimulator(f"{self.title} is not installed; to install it: {pip_install(['warp'])}")
        try:
            import warp

            warp.config.log_level = warp.LOG_ERROR  # its lines are no results
            import mujoco_warp  # noqa: F401  # whether it can be
        except (ImportError, OSError) as error:
            raise NoSimulator(f"{self.title} is installed, but not loaded: {line_of(str(error))}") from None

    def size(self, recipe: Recipe) -> int:
        """Return how many worlds make a batch; ParameterError for maps of several frictions, or of very many blocks."""
        if not recipe.is_of_one_friction:
            raise ParameterError(
                "level_friction", f"{self.name} has maps of one friction; use only `friction`, or simulator='mujoco'"
            )
        n_x, n_y = recipe.grid.shape
        if n_x * n_y > _BLOCKS:
            raise ParameterError(
                "chunks", f"{n_x} x {n_y} blocks; {self.name} has up to {_BLOCKS}; use smaller maps, or mujoco"
            )
        import warp

        return min(_ON_GPU if warp.get_device().is_cuda else _ON_CPU, _MEMORY // (n_x * n_y))

    def worlds(self, scenes: Sequence[Scene], robots: Sequence[PlacedRobot], *, motors: str = MOTORS[0]) -> BatchWorlds:
        """Return a world for each scene and its robot; ParameterError if it has more than 32 degrees of freedom."""
        self.refuse_missing()
        from rsegen.mujoco.many_maps import ManyMaps

        return ManyMaps(scenes, robots, motors)

    def __str__(self) -> str:
        from importlib.metadata import version

        import warp

        device = warp.get_device()
        return f"{self.title} {version('mujoco-warp')} on {device.name if device.is_cuda else 'the CPU'}"
