"""A list of the included plans of experiments, and of files with others; below it what the chosen one measures."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QComboBox, QFileDialog, QLabel, QToolButton, QVBoxLayout, QWidget

from rsegen.gui.model.simulation import experiment_plans
from rsegen.gui.widgets.layouts import row_of
from rsegen.gui.widgets.named import named

_FIRST = "quick"
"""The plan that is chosen at first: the shortest."""


class PlanBox(QWidget):
    """Chooses a plan; `changed` is emitted when it is another one."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._texts = experiment_plans()
        self.box = named(QComboBox(), "plan", tip="an included plan, or a YAML file like these")
        self.box.setMinimumContentsLength(24)
        self.box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.box.addItems(list(self._texts))
        self.box.setCurrentText(_FIRST)
        self.box.currentIndexChanged.connect(self._show)
        choose = named(
            QToolButton(), "choose_plan", title="choose a file", tip="choose a plan of your own, a YAML file"
        )
        choose.setText("...")
        choose.clicked.connect(self._choose_file)
        self._about = named(QLabel(wordWrap=True, textFormat=Qt.TextFormat.PlainText), "about_plan")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        row = row_of(self.box, choose)
        row.setStretch(0, 1)
        column.addLayout(row)
        column.addWidget(self._about)
        self._about.setText(self._texts[_FIRST])

    def plan(self) -> str:
        """The name of the plan, or the path of its file."""
        return self.box.currentText()

    def show_file(self, path: str) -> None:
        """Choose a file, which is then in the list."""
        with QSignalBlocker(self.box):
            if self.box.findText(path) < 0:
                self.box.addItem(path)
            self.box.setCurrentText(path)
        self._show()

    def _choose_file(self) -> None:
        path, _ = QFileDialog.getOpenFileName(self, "Choose a plan", "", "Plans (*.yaml *.yml);;All files (*)")
        if path:
            self.show_file(path)

    def _show(self) -> None:
        self._about.setText(self._texts.get(self.plan(), "A plan of your own."))
        self.changed.emit()
