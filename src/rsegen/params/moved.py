"""The modules of rsegen 0.1 under the names that they had then, for one release.

`from rsegen.robots import robot` gives what `from rsegen.simulation.robots import robot` gives, with a
DeprecationWarning. `rsegen.build`, `rsegen.experiment`, `rsegen.export`, `rsegen.metrics`, `rsegen.series` and
`rsegen.sheet` are functions and nothing else.
"""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from importlib.machinery import ModuleSpec

TYPE_CHECKING = False
if TYPE_CHECKING:  # every start of the command line waits for what is imported here
    from collections.abc import Sequence
    from types import ModuleType

NEW_NAMES = {
    "account": "exporters.map_summary",
    "chance": "params.streams",
    "chart": "exporters.pictures.paths",
    "coarse": "field.coarse",
    "codec": "recipe.codec",
    "constraints": "recipe.constraints",
    "dataset": "io.dataset",
    "difficulty": "recipe.difficulty",
    "drawing": "exporters.pictures.preview",
    "driving": "simulation.driving",
    "examples": "recipe.examples",
    "exporting": "io.exports",
    "extras": "io.sidecars",
    "formats": "exporters.formats",
    "importers": "io.importers",
    "obstacles": "field.obstacles",
    "pipeline": "io.worlds",
    "places": "params.places",
    "proof": "exporters.constraint_report",
    "recipe_file": "io.recipe_file",
    "registry": "params.registry",
    "resume": "io.existing",
    "robots": "simulation.robots",
    "room": "io.resources",
    "scene": "exporters.scene",
    "simulators": "simulation.simulators",
    "spawning": "simulation.spawning",
    "stepfield": "field.stepfield",
    "texts": "io.text_files",
    "work": "io.work",
    "workers": "io.workers",
    "writer": "io.writer",
}
"""Module or package of rsegen 0.1 -> where it is now, both below `rsegen`."""


class _Finder:
    """Finds a module by its old name, and loads the one of the new name in its place."""

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        top, _, rest = name.partition(".")
        old, _, below = rest.partition(".")
        if top != "rsegen" or old not in NEW_NAMES:
            return None
        loader = _Loader(".".join(filter(None, (top, NEW_NAMES[old], below))))
        return ModuleSpec(name, loader)  # type: ignore[arg-type]  # importlib.abc takes 50 ms to import


class _Loader:
    def __init__(self, new: str) -> None:
        self.new = new

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        warnings.warn(f"{spec.name} is now {self.new}", DeprecationWarning, stacklevel=2)
        module = import_module(self.new)
        self.own = module.__spec__, getattr(module, "__loader__", None), module.__package__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """The module is whole already; the import system has marked it with the old name."""
        module.__spec__, module.__loader__, module.__package__ = self.own


def find_old_names() -> None:
    """Let the old names be imported; asked first, as the path of a package would give its modules a second time."""
    sys.meta_path.insert(0, _Finder())
