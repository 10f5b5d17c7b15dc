"""`rsegen.remove`: models deleted from the running simulation."""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.errors import ParameterError, UnknownName
from rsegen.simulation.simulators.connecting import connected


@dataclass(frozen=True, kw_only=True, slots=True)
class RemoveResult:
    """What `rsegen.remove` gives: the names of the deleted models, and the simulator's."""

    removed: tuple[str, ...]
    simulator: str


def remove(*names: str, simulator: str | None = None) -> RemoveResult:
    """Delete maps, robots and other models from the running simulation; none of them if one does not exist.

    simulator: by default whichever runs. UnknownName lists the models if one does not exist.
    """
    if not names:
        raise ParameterError("names", "nothing is given; give the names of models in the simulation")
    unique = tuple(dict.fromkeys(names))
    with connected(simulator) as (running, live):
        models = live.poses()
        for name in unique:
            if name not in models:
                raise UnknownName.among("", "model", name, models)
        for name in unique:
            live.delete(name)
    return RemoveResult(removed=unique, simulator=running.name)
