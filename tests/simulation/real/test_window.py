"""Gazebo Classic's own window on a virtual screen: what is seen there is the map."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import ImageGrab

import rsegen
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.trial import run_trial
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.server import ATTEMPTS
from tests.simulation.real.conftest import missing
from tests.support.patience import until
from tests.support.runs import started
from tests.support.screen import ON_SCREEN, xvfb

pytestmark = pytest.mark.long(reason="a window without a graphics card")

MUCH = 0.0003
"""A share of the screen that is more than a letter: the map is about a hundred pixels wide."""


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    for number in xvfb():
        for name, value in {**ON_SCREEN, "DISPLAY": number}.items():
            monkeypatch.setenv(name, value)
        yield number


@pytest.fixture
def windowed(gazebo_classic: Installation) -> Installation:
    """A Gazebo Classic with its window."""
    return (
        gazebo_classic if "gzclient" in gazebo_classic.commands else missing("no gzclient: run scripts/gazebo-classic")
    )


def seen(screen: str) -> set[str]:
    """Which colours of the example's blocks are on the screen; none while the screen starts."""
    try:
        pixels = np.asarray(ImageGrab.grab(xdisplay=screen).convert("RGB")).astype(int)
    except OSError:
        return set()
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    shares = {
        "red": ((red > 90) & (green < 0.3 * red) & (blue < 0.3 * red)).mean(),
        "yellow": ((red > 90) & (green > 0.75 * red) & (blue < 0.75 * red)).mean(),
    }
    return {name for name, share in shares.items() if share > MUCH}


def rest() -> None:
    """A picture of a screen takes time that its programs need."""
    time.sleep(0.5)


def shown(process: subprocess.Popen[str], screen: str) -> bool:
    """Whether a window shows the map before it ends."""
    try:
        until(lambda: process.poll() is not None or seen(screen) == {"red", "yellow"}, rest=rest)
        return process.poll() is None
    finally:
        process.terminate()
        process.communicate()  # which closes its pipes too


@pytest.mark.slow
def test_open_shows_the_map_in_its_colours_in_the_window(windowed: Installation, screen: str, tmp_path: Path) -> None:
    """On a busy machine Gazebo's window now and then gives up before its server answers."""
    variables = {"PYTHONPATH": str(Path(rsegen.__file__).parents[1]), "HOME": str(Path.home())}
    words = ("open", "diagonal-barrier", "--simulator", "classic")
    opened = (started(*words, stdout=subprocess.DEVNULL, **variables) for _ in range(ATTEMPTS))
    assert any(shown(process, screen) for process in opened)
    until(lambda: not seen(screen), rest=rest)


@pytest.mark.slow
@pytest.mark.parametrize("pace", ["camera", "window"])
def test_a_trial_counts_the_frames_that_are_drawn(pace: str, windowed: Installation, screen: str) -> None:
    row = TableRow(robots=1, sizes=(10,), unit_cm=0.5, levels=3)
    plan = ExperimentPlan(name="frames", rows=(row,), paces=(pace,), seconds=3)
    found = run_trial(plan, Cell(row=0, size=10, pace=pace), 0, windowed).outcome
    assert found.fps is not None
    assert 0 < found.fps < 1000
    assert found.rtf is not None
    assert found.driven is not None
