"""The simulators that worlds are opened in: each is one file of this folder, and is found by being there."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from importlib import import_module

from rsegen.simulators.base import Installation, Launch, Opening, Simulator, installations, registered

for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

SIMULATORS: Mapping[str, Simulator] = registered()
"""Every simulator by its name, the newest first."""

__all__ = ["SIMULATORS", "Installation", "Launch", "Opening", "Simulator", "installations"]
