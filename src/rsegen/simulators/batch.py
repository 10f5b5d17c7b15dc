"""Simulators that step many worlds at once, with a robot in each: a batch, as on a GPU.

A batch simulator is one file with one class under `@register`, of this folder or of a capability. All its worlds take
the same steps; each has its own map, and its robot has its own speeds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

from rsegen.errors import UnknownName
from rsegen.field.stepfield import Array
from rsegen.params.registry import Contract, Registry
from rsegen.recipe.recipe import Recipe
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import EMBEDDED, PlacedRobot, embedded_simulator


class BatchWorlds(ABC):
    """Worlds that are stepped together, with a robot in each, in the order of their scenes."""

    step_seconds: ClassVar[float]

    @abstractmethod
    def poses(self) -> Array:
        """Return where robots are, (worlds, 6): x, y, z in metres, roll, pitch and yaw in radians."""

    @abstractmethod
    def drive(self, v: Array, w: Array) -> None:
        """Have robots drive at v, m/s forward, and w, rad/s counterclockwise, (worlds,), from now on."""

    @abstractmethod
    def step(self, steps: int) -> None:
        """Simulate this number of steps in all worlds."""

    @abstractmethod
    def problems(self) -> Mapping[int, str]:
        """Return why worlds have no result, in words such as "it sank in", by their number; asked before steps too."""


class BatchSimulator(ABC):
    """A simulator of many worlds at once.

    name: as `--simulator` takes it; title: for people
    """

    name: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def refuse_missing(self) -> None:
        """Raise a NoSimulator, with how to install it, if its library is missing."""

    @abstractmethod
    def size(self, recipe: Recipe) -> int:
        """Return how many worlds make a batch of the maps of a recipe; ParameterError for maps that it cannot hold."""

    @abstractmethod
    def worlds(self, scenes: Sequence[Scene], robots: Sequence[PlacedRobot], *, motors: str = MOTORS[0]) -> BatchWorlds:
        """Return a world for each scene and its robot, of one kind in all; ParameterError for what it cannot hold."""

    def __str__(self) -> str:
        return self.title


def _problem(cls: type[BatchSimulator]) -> str:
    return f"has the name {cls.name!r}, which a simulator of one world has" if cls.name in EMBEDDED else ""


BATCH: Registry[BatchSimulator] = Registry(
    "batch simulator",
    group="rsegen.batch_simulators",
    contract=Contract(
        base=BatchSimulator, names=lambda cls: (cls.name,), stored_object=lambda cls: cls(), check=_problem
    ),
)
"""Every simulator of many worlds at once, by its name."""

register = BATCH.register
"""Decorator of a batch simulator, one of which is known by its name then."""


def simulators_of_many_maps() -> tuple[str, ...]:
    """Return the names of the simulators that drive over many maps: the one in the box, then those of batches."""
    in_the_box = embedded_simulator(None)
    return *([in_the_box.name] if in_the_box else []), *BATCH


def batch_simulator(name: str | None) -> BatchSimulator | None:
    """Return the batch simulator of a name; None for the simulator in the box, which is the default.

    UnknownName, which lists both, for any other name.
    """
    known = simulators_of_many_maps()
    if name is not None and name not in known:
        raise UnknownName.among("simulator", "simulator of many maps", name, known)
    return None if name is None else BATCH.get(name)
