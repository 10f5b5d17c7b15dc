"""The parts of the window know each other one way only, also where imports are for type checkers."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import rsegen

ROOT = Path(rsegen.__file__).parents[1]
GUI = Path(rsegen.__file__).parent / "gui"


def module(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def imported(path: Path) -> set[str]:
    """The modules of the window that one imports, wherever the import stands."""
    nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
    found = {name.name for node in nodes if isinstance(node, ast.Import) for name in node.names}
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return {name for name in found if name.startswith("rsegen.gui.")}


MODULES = {module(path): imported(path) for path in GUI.rglob("*.py")}


def test_no_import_leads_back_to_where_it_came_from() -> None:
    known = {name: {each for each in imports if each in MODULES} for name, imports in MODULES.items()}
    assert set(TopologicalSorter(known).static_order()) == set(MODULES)


def test_only_the_application_knows_the_window() -> None:
    assert [name for name, imports in MODULES.items() if "rsegen.gui.window" in imports] == ["rsegen.gui.application"]


def test_one_module_alone_calls_the_simulators_and_robots() -> None:
    callers = [path.name for path in GUI.rglob("*.py") if "rsegen.simulation" in path.read_text("utf-8")]
    assert callers == ["simulation.py"]
