"""The fixtures of simulators, on a machine on which none is, until a test puts stand-ins on its PATH."""

from tests.simulators.conftest import classic_world, programs, pytest_itemcollected, sim_address, world

__all__ = ["classic_world", "programs", "pytest_itemcollected", "sim_address", "world"]
