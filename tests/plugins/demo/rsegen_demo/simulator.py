"""A simulator that is nowhere installed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import ClassVar

from rsegen.simulators.base import Installation, OpenRequest, Simulator
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.writing.programs import LaunchCommand


class Paper(Simulator):
    """A simulator on paper."""

    name: ClassVar[str] = "paper"
    title: ClassVar[str] = "Pencil and Paper"
    generation: ClassVar[int] = 0
    how_to_install: ClassVar[tuple[str, ...]] = ("buy a pencil",)
    address: ClassVar[tuple[str, ...]] = ()

    def installation(self) -> Installation | None:
        """It never is."""
        return None

    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """It has no window."""
        return None

    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Nothing serves it."""
        raise NotImplementedError

    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Nothing serves it."""
        raise NotImplementedError

    def is_loaded(self, home: Path, log: str) -> bool:
        """It never is."""
        return False

    def backend(self, here: Installation) -> str:
        """That of Gazebo Sim."""
        return "sim"

    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """It is not."""
        raise NotImplementedError
