"""Work that a click on the page asks for: as much as is shown, and no more."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import rsegen
from rsegen.gazebo.constraint_report import constraint_report, describe_constraints
from rsegen.gazebo.map_summary import costs
from rsegen.page import documents as calls
from rsegen.page.host import Host, Opened
from rsegen.page.model.session import Session
from rsegen.page.scenes import COUNTED, ghost, maps, results, scene, variants
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import compose
from rsegen.writing.resources import format_bytes

SOURCE = Path(rsegen.__file__).parent


def _ran(work: Callable[[], Any]) -> dict[str, set[str]]:
    """The functions of rsegen that some work runs, by the module that has them."""
    functions: dict[str, set[str]] = {}

    def watch(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "call" and Path(code.co_filename).is_relative_to(SOURCE):
            module = ".".join(Path(code.co_filename).relative_to(SOURCE).with_suffix("").parts)
            functions.setdefault(module, set()).add(code.co_name)

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        work()
    finally:
        sys.setprofile(before)
    return functions


@pytest.fixture
def host(tmp_path: Path) -> Host:
    return Host(folder=tmp_path)


@pytest.fixture(params=["mixed-course", "peak", "figure-7"])
def opened(request: pytest.FixtureRequest, host: Host) -> Opened:
    return host.opened(calls.open(host, what=request.param)["doc"])


def _click(opened: Opened, cell: int) -> None:
    """Paint a cell, and draw the map as the page does."""
    row = len(opened.session.draft.rows) - 1 if cell else -1
    calls.edit(opened, actions=[{"do": "paint", "row": row, "cells": [[cell, 1]], "level": 2}])
    scene(opened)


def _of_export(functions: dict[str, set[str]]) -> set[str]:
    """Those of the functions that make files or measure."""
    modules = ("gazebo.obj", "gazebo.sdf", "geometry.exposed_faces", "measuring")
    names = {name for module, names in functions.items() if module.startswith(modules) for name in names}
    return names | (functions.get("gazebo.bundle", set()) & {"export"})


def test_a_paint_click_makes_no_file_and_measures_nothing(opened: Opened) -> None:
    _click(opened, 0)
    functions = _ran(lambda: _click(opened, 1))
    assert "paint" in functions["page.model.actions"]
    assert "drawn" in functions["page.shown_map"]
    assert _of_export(functions) == set()
    assert sum(map(len, functions.values())) < 300
    # What is left out is seen where it is asked for.
    assert len(_of_export(_ran(lambda: results(opened)))) > 20


def test_a_ghost_and_small_maps_measure_nothing_that_they_do_not_show(opened: Opened, host: Host) -> None:
    entry = {"kind": "peak", "levels": 5}
    assert _of_export(_ran(lambda: ghost(opened, entry=entry))) == set()
    for pictures in (partial(variants, count=2), partial(maps, first=0, count=1)):
        made = _ran(partial(pictures, host, doc=opened.id))
        assert "_difficulty" in made["page.scenes"]
        assert not {module for module in made if module in ("gazebo.obj", "measuring.spectrum")}
        assert "export" not in made.get("gazebo.bundle", ())


@pytest.mark.parametrize("name", ["mixed-course", "peak", "five-pallet-dash"])
def test_results_are_those_of_the_map_as_it_is_written(host: Host, name: str) -> None:
    opened = host.opened(calls.open(host, what=name)["doc"])
    made = compose(load(EXAMPLES[name]), 0)
    models, _, faces, size = costs(made)
    shown = results(opened)
    assert shown["cost"] == f"{models:,} model{'s'[: models != 1]}, {faces:,} faces, {format_bytes(size)}"
    assert shown["constraints"] == list(describe_constraints(made, constraint_report(made)))
    assert {"mean height", "rms step", "TRI"} <= {name for name, _, _ in shown["metrics"]}
    before = {row[0]: row[1] for row in shown["metrics"]}
    calls.edit(opened, actions=[{"do": "paint", "row": -1, "cells": [[0, 0]], "level": 30}])
    after = {row[0]: row[1] for row in results(opened)["metrics"]}
    assert after["rms step"] != before["rms step"]


def test_files_of_a_large_map_are_not_counted(host: Host) -> None:
    recipe = rsegen.Recipe(seed=1, chunk_size=320, obstacles=[rsegen.Random(levels=3)])
    opened = host.open(Session.of(recipe))
    assert COUNTED < 320 * 320
    assert results(opened)["cost"] == ""
    assert results(opened)["metrics"]
