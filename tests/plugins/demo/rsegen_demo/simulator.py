"""A simulator that is nowhere installed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import ClassVar

from rsegen.simulation.simulators import Installation, Launch, Opening, Simulator
from rsegen.simulation.simulators.live import LiveWorld


class Paper(Simulator):
    """A simulator on paper."""

    name: ClassVar[str] = "paper"
    title: ClassVar[str] = "Pencil and Paper"
    generation: ClassVar[int] = 0
    remedy: ClassVar[tuple[str, ...]] = ("buy a pencil",)
    address: ClassVar[tuple[str, ...]] = ()

    def found(self) -> Installation | None:
        """It never is."""
        return None

    def windowed(self, here: Installation, opening: Opening) -> Launch | None:
        """It has no window."""
        return None

    def headless(self, here: Installation, opening: Opening) -> Launch:
        """Nothing serves it."""
        raise NotImplementedError

    def standing(self, here: Installation, opening: Opening, home: Path) -> Launch:
        """Nothing serves it."""
        raise NotImplementedError

    def is_loaded(self, home: Path, log: str) -> bool:
        """It never is."""
        return False

    def dialect(self, here: Installation) -> str:
        """That of Gazebo Sim."""
        return "sim"

    def live(self, environment: Mapping[str, str]) -> AbstractContextManager[LiveWorld]:
        """It is not."""
        raise NotImplementedError
