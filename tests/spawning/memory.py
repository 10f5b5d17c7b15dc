"""A running simulation in memory: what spawning does to a world, without a server and without physics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from xml.etree import ElementTree

from rsegen.errors import SimulatorFailed
from rsegen.robots.drives import PublishCommand
from rsegen.simulators.inbox import Inbox
from rsegen.simulators.live_world import Clock, LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Pose


class MemoryWorld(LiveWorld):
    """A world with the ground, which refuses what Gazebo refuses: two models of a name, and models that are not there.

    log: what changed it, in order
    """

    between_looks = 0.0
    is_current = True
    backend = "sim"
    name = "lab"

    def __init__(self, *, paused: bool = False) -> None:
        self.client = Inbox("memory", Patience(seconds=1.0, sign=1.0))
        self.models: dict[str, ElementTree.Element | None] = {"ground_plane": None}
        self.places = {"ground_plane": Pose(x=0, y=0, z=0)}
        self.paused = paused
        self.log: list[str] = []

    @contextmanager
    def connect(self, environment: Mapping[str, str], patience: Patience) -> Iterator[LiveWorld]:
        """Stand for the `connect` of a simulator."""
        yield self

    def poses(self) -> Mapping[str, Pose]:
        return dict(self.places)

    def movable(self) -> Set[str]:
        static = (name for name, model in self.models.items() if model is None or model.findtext("static") == "true")
        return self.models.keys() - set(static)

    def mesh_files(self) -> Mapping[str, str]:
        uris = {name: model.findtext(".//visual//mesh/uri") for name, model in self.models.items() if model is not None}
        return {name: uri for name, uri in uris.items() if uri}

    def clock(self) -> Clock:
        return Clock(simulated=0.0, real=0.0, steps=0, paused=self.paused)

    def step(self, steps: int) -> None:
        raise NotImplementedError

    def send_command(self, command: PublishCommand) -> None:
        raise NotImplementedError

    def _set_paused(self, *, paused: bool) -> None:
        self.paused = paused
        self.log.append("pause" if paused else "unpause")

    def _spawn(self, name: str, sdf: str, pose: Pose) -> None:
        if name in self.models:
            raise SimulatorFailed(f"{name} exists")
        self.models[name] = ElementTree.fromstring(sdf).find("model")
        self.places[name] = pose
        self.log.append(f"spawn {name}")

    def _delete(self, name: str) -> None:
        del self.models[name], self.places[name]
        self.log.append(f"delete {name}")

    def _move(self, name: str, pose: Pose) -> Pose:
        before = self.places[name]
        self.places[name] = pose
        self.log.append(f"move {name}")
        return before


def changes(world: MemoryWorld) -> Sequence[str]:
    """Return what changed a world since the last call."""
    log, world.log = world.log, []
    return log
