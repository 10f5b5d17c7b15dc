"""All formats of other programs, to be ticked, with the options of those that are."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFormLayout, QGridLayout, QLabel, QWidget

from rsegen.errors import ParameterError, UserError
from rsegen.exporters.formats import FORMATS, Format, summary
from rsegen.gui.editors import named
from rsegen.gui.notice import Notice
from rsegen.gui.options_form import OptionsForm
from rsegen.params.sorts import parameters


class FormatList(QWidget):
    """A box, a line and options for each; one that needs what is not installed says so. `changed`: a box was ticked."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._grid = QGridLayout(self)
        self._grid.setColumnStretch(1, 1)
        self._grid.setHorizontalSpacing(16)
        self._boxes: dict[str, QCheckBox] = {}
        self._options: dict[str, OptionsForm[Format]] = {}
        for name, cls in FORMATS.items():
            self._add(name, cls)
        self._grid.setRowStretch(self._grid.rowCount(), 1)

    def any_ticked(self) -> bool:
        """Whether there is anything to write."""
        return any(box.isChecked() for box in self._boxes.values())

    def formats(self) -> tuple[Format, ...]:
        """Those that are ticked, with their options; a ParameterError where an option cannot be."""
        return tuple(self._made(name) for name, box in self._boxes.items() if box.isChecked())

    def _made(self, name: str) -> Format:
        try:
            return self._options[name].made() if name in self._options else FORMATS[name]()
        except ParameterError as error:
            raise error.inside(name) from None

    def _add(self, name: str, cls: type[Format]) -> None:
        row, reason = self._grid.rowCount(), _missing(cls)
        self._boxes[name] = box = named(QCheckBox(name), f"format_{name}", title=name, tip=summary(cls))
        said = QLabel(summary(cls), wordWrap=True)
        said.setContentsMargins(0, 3, 0, 3)  # in line with the box
        for column, widget in enumerate((box, said)):
            widget.setEnabled(not reason)
            self._grid.addWidget(widget, row, column, Qt.AlignmentFlag.AlignTop)
        box.toggled.connect(self.changed)
        if reason:
            self._grid.addWidget(_told(name, reason), row + 1, 1)
        elif parameters(cls):
            self._add_options(row + 1, name, cls)

    def _add_options(self, row: int, name: str, cls: type[Format]) -> None:
        """They are there while the box is ticked."""
        self._options[name] = options = named(OptionsForm(cls), f"options_{name}", title=f"options of {name}")
        options.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        options.form.setContentsMargins(0, 0, 0, 8)
        options.setVisible(False)
        self._boxes[name].toggled.connect(options.setVisible)
        self._grid.addWidget(options, row, 1)


def _missing(cls: type[Format]) -> str:
    """What a format needs that is not installed, and how to get it; nothing where it is ready."""
    try:
        cls().refuse_missing()
    except UserError as error:
        return str(error)
    return ""


def _told(name: str, reason: str) -> Notice:
    """The reason, of which the command can be copied."""
    notice = Notice(f"missing_{name}", "warning")
    notice.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    notice.say(reason)
    return notice
