"""The picture of the window in the manual: `python -m docs.window [FILE]`, on a display (else below `xvfb-run -a`)."""

from __future__ import annotations

import sys
from pathlib import Path

from PySide6.QtCore import QCoreApplication, QSettings
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.recipe.examples import EXAMPLES

DOCS = Path(__file__).parent
EXAMPLE = "mixed-course"
EDITED = 2
"""The row that is taken into the form."""


def main(picture: Path) -> int:
    """Show the example, and keep what is seen."""
    application = QApplication([])
    QCoreApplication.setOrganizationName("rsegen-docs")
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    window = Window(Session.opened(EXAMPLES[EXAMPLE]))
    window.resize(1280, 720)
    window.show()
    window.document.select(EDITED)
    QTest.qWaitForWindowExposed(window)
    QTest.qWait(1000)
    while not window.status.costs.text():
        QTest.qWait(50)
    kept = window.screen().grabWindow(window.winId()).save(str(picture))
    window.close()
    application.quit()
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "pictures" / "window.png"))
