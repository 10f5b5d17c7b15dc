"""The simulators that worlds are opened in: each is one file of this folder, and is found by being there."""

from __future__ import annotations

from rsegen.simulation.simulators.base import SIMULATORS, Installation, Launch, Opening, Simulator, installations

__all__ = ["SIMULATORS", "Installation", "Launch", "Opening", "Simulator", "installations"]
