"""In the window no text, click or key raises, and what it shows is what it makes, whatever is done to it at random.

    python -m pytest tests/gui/test_random_actions.py --window-actions=2000 --seed=7

does one long trial. Each trial is a process of its own on a screen of its own, in a folder of its own.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path
from subprocess import PIPE, STDOUT, CompletedProcess

import pytest

from tests.support.patience import run

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from tests.support.long import long_unless
from tests.support.screen import ON_SCREEN

SEEDS = range(1, 4)
ROOT = Path(__file__).parents[2]
SHORTENINGS = 25
"""So many shorter lists of actions are tried after a failure."""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "seed" in metafunc.fixturenames:
        given = metafunc.config.getoption("seed")
        seeds = long_unless(SEEDS[0].__eq__, SEEDS, reason="10 s per seed")
        metafunc.parametrize("seed", seeds if given is None else [given])


@pytest.mark.slow
def test_random_actions_raise_nothing_and_the_window_shows_the_session(
    request: pytest.FixtureRequest, tmp_path: Path, display: str, seed: int
) -> None:
    actions = request.config.getoption("--window-actions")
    folder = tmp_path / "all"
    found = trial(folder, display, "--actions", actions, "--seed", seed)
    if found.returncode:
        again = f"python -m pytest {Path(__file__).relative_to(ROOT)} --window-actions={actions} --seed={seed}"
        pytest.fail(f"{found.stdout}\n{again}\n{shortened(folder, tmp_path, display)}", pytrace=False)


def trial(folder: Path, display: str, *arguments: object) -> CompletedProcess[str]:
    """A process that uses the window, and knows no simulators, no other settings and no other folders."""
    for name in ("home", "tmp"):
        (folder / name).mkdir(parents=True)
    home, tmp = str(folder / "home"), str(folder / "tmp")
    own = {"HOME": home, "TMPDIR": tmp, "XDG_RUNTIME_DIR": tmp, "PATH": tmp}
    own |= {"GAZEBO_MASTER_URI": "http://127.0.0.1:9", "GZ_PARTITION": "nobody", "PYTHONDONTWRITEBYTECODE": "1"}
    others = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "GZ_", "GAZEBO_"))}
    command = [sys.executable, "-X", "faulthandler", "-m", "tests.gui.random_actions.trial", folder, *arguments]
    environment = others | ON_SCREEN | {"DISPLAY": display} | own
    found: CompletedProcess[str] = run(command, cwd=ROOT, env=environment, stdout=PIPE, stderr=STDOUT, text=True)
    return found


def shortened(folder: Path, tmp_path: Path, display: str) -> str:
    """The command that does the last actions before a failure again: as few as a few tries leave."""
    if not (folder / "actions.txt").exists():
        return "It failed before the first action."
    log = (folder / "actions.txt").read_text("utf-8").splitlines()
    folders = (tmp_path / f"again-{number}" for number in count())

    def fails(steps: Sequence[str]) -> bool:
        return trial(next(folders), display, "--replay", ",".join(steps)).returncode != 0

    few = shortest_failing([line.partition(" ")[0] for line in log], fails)
    told = [line for line in log if line.partition(" ")[0] in few] or log[-10:]
    command = f"python -m tests.gui.random_actions.trial $(mktemp -d) --replay {','.join(few)}"
    return "\n".join([*told, f"With DISPLAY and QT_QPA_PLATFORM=xcb: {command}"])


def shortest_failing(steps: Sequence[str], fails: Callable[[Sequence[str]], bool]) -> Sequence[str]:
    """A short list of steps that fails: of the last 5, 10, 20, ..., without what it can spare in a few tries."""
    lengths = (5 * 2**power for power in count())
    few = next(steps[-length:] for length in lengths if length >= len(steps) or fails(steps[-length:]))
    tries, part = SHORTENINGS, len(few) // 2
    while part:
        for start in range(len(few) - part, -1, -part):
            shorter = [*few[:start], *few[start + part :]]
            tries -= 1
            if tries >= 0 and shorter and fails(shorter):
                few = shorter
        part //= 2
    return few


@pytest.mark.parametrize(
    ("steps", "wrong"), [("abcdefghijklmnop", "kp"), ("abc", "a"), ("abcdefghijklmnop", "bp"), ("x", "x")]
)
def test_a_failure_is_reduced_to_the_actions_that_cause_it(steps: str, wrong: str) -> None:
    found = shortest_failing(list(steps), lambda some: set(wrong) <= set(some))
    assert "".join(found) == wrong
