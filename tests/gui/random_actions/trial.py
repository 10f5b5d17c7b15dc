"""Uses the window at random: `python -m tests.gui.random_actions.trial FOLDER --actions N --seed S`.

Exit code 1 and one line per mistake if anything is raised, warned of or not as it should be. FOLDER/actions.txt has
what was done, also after a crash. --replay does the actions that a failure prints, and no others.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, QUrl, Slot
from PySide6.QtGui import QDesktopServices
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.gui.random_actions.actions import ACTIONS
from tests.gui.random_actions.dialogs import Answers
from tests.gui.random_actions.guard import Guard
from tests.gui.random_actions.invariants import broken, history_broken, preview_broken
from tests.gui.random_actions.places import fill
from tests.gui.random_actions.texts import numbers
from tests.support.waiting import until

Step = tuple[str, int]
"""The name of an action, and the seed of its random numbers."""

_EVERY = 50
"""The history is tried after this many actions, and in the end."""

_MOST_CELLS = 30_000
"""A map of more cells, if it is not refused as too large, is taken back: its previews take long."""

_MOST_MEMORY = 6 * 2**30
"""In bytes; a trial takes about two thousand million, of which a third is in use."""

_MOST_MAPS = 20
"""A run of more steps is cancelled."""


class Trial:
    """A window, and what is done to it."""

    def __init__(self, guard: Guard, log: Path) -> None:
        self._guard, self._log, self._told = guard, log.open("w", encoding="utf-8", buffering=1), list[str]()
        self._answers = Answers(self._told)
        self._window = self._opened()

    def do(self, step: Step) -> list[str]:
        """Do one action; gives what is wrong then."""
        name, seed = step
        self._log.write(f"{name}:{seed} ")
        self._answers.begin(numbers(seed))
        self._told.append(ACTIONS[name][0](self._window, numbers(seed)))
        QApplication.processEvents()
        self._keep_small()
        self._answers.end()
        self._log.write(f"{'; '.join(self._told)}\n".encode("ascii", "backslashreplace").decode())
        self._told.clear()
        if not self._window.isVisible():
            self._window = self._opened()
        return [*self._guard.wrong, *broken(self._window)]

    def try_history(self) -> list[str]:
        """What is wrong with undo and redo, and with the preview once nothing changes."""
        window = self._window
        window.finish_typing()
        wrong = [*history_broken(window.session, self._first), *broken(window)]
        until(lambda: not window._pause.isActive() and not window.previewer.busy)
        return [*wrong, *preview_broken(window), *self._guard.wrong]

    def end(self) -> list[str]:
        """Close everything; gives what is wrong then."""
        for dialog in self._window.findChildren(QDialog):
            dialog.close()
        self._window.document.open(Session.new())
        self._window.close()
        QTest.qWait(50)
        return self._guard.wrong

    def _opened(self) -> Window:
        window = Window(Session.new())
        shown = window.document.opened

        def opened() -> None:
            self._first = window.session.draft
            shown()

        self._first, window.document.opened = window.session.draft, opened
        window.show()
        QTest.qWaitForWindowExposed(window)
        window.activateWindow()
        return window

    def _keep_small(self) -> None:
        """Take back what would take long: maps of many cells, runs of many steps."""
        session, form = self._window.session, self._window.forms.start_form
        while session.can_undo and _MOST_CELLS < _cells(session) < 10**10:
            session.undo()
        for run in (
            form.run,
            *(dialog.form.run for dialog in self._window.findChildren(QDialog) if hasattr(dialog, "form")),
        ):
            if run and run.isRunning() and run.job.steps > _MOST_MAPS:
                run.requestInterruption()


class _NoPrograms(QObject):
    """Opens no folder in the desktop's file manager."""

    @Slot(QUrl)
    def swallow(self, _: QUrl) -> None:
        """Do nothing."""


def _cells(session: Session) -> int:
    n_x, n_y = session.recipe.grid.shape
    return n_x * n_y


def steps(seed: int, actions: int) -> Iterator[Step]:
    """The actions of a seed."""
    random, names, weights = numbers(seed), list(ACTIONS), [often for _, often in ACTIONS.values()]
    for _ in range(actions):
        yield random.choices(names, weights)[0], random.randrange(10**6)


def replayed(text: str) -> Iterator[Step]:
    """The actions that a failure prints."""
    for word in text.split(","):
        name, _, seed = word.partition(":")
        yield name, int(seed)


def run(folder: Path, todo: Iterable[Step]) -> list[str]:
    """What goes wrong if these actions are done in a folder."""
    application = QApplication(sys.argv[:1])
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(folder / "settings"))
    handler = _NoPrograms()
    QDesktopServices.setUrlHandler("file", handler, "swallow")  # type: ignore[arg-type]  # its stub says bytes
    place = folder / "place"
    place.mkdir()
    os.chdir(place)
    fill(place)
    guard = Guard(folder)
    guard.watch()
    trial = Trial(guard, folder / "actions.txt")
    for number, step in zip(count(1), todo):
        if wrong := trial.do(step) or (trial.try_history() if number % _EVERY == 0 else []):
            return wrong
    application.processEvents()
    return trial.try_history() or trial.end()


def limit_memory() -> None:
    """Let what takes very much memory fail here, with a traceback, and nothing else on this machine."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))


def main() -> None:
    """Do the actions of the command line, and print what went wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--actions", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--replay", default="")
    given = parser.parse_args()
    limit_memory()
    todo = replayed(given.replay) if given.replay else steps(given.seed, given.actions)
    try:
        wrong = run(given.folder.resolve(), todo)
    except BaseException:  # the guard has Python's way to print it
        wrong = [traceback.format_exc()]
    sys.stdout.write("\n".join(wrong))
    sys.stdout.flush()
    os._exit(bool(wrong))


if __name__ == "__main__":
    main()
