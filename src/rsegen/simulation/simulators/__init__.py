"""The simulators that can open worlds; each is one file of this folder, which is imported automatically."""

from __future__ import annotations

from rsegen.simulation.simulators.base import (
    SIMULATORS,
    Installation,
    LaunchCommand,
    OpenRequest,
    Simulator,
    installations,
)

__all__ = ["SIMULATORS", "Installation", "LaunchCommand", "OpenRequest", "Simulator", "installations"]
