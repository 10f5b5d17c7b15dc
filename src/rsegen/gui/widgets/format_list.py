"""A list of all export formats with check boxes, and the options of those that are ticked."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFormLayout, QGridLayout, QLabel, QWidget

from rsegen.errors import ParameterError, UserError
from rsegen.exporters.formats import FORMATS, Format
from rsegen.gui.widgets.message_label import MessageLabel
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.options_form import OptionsForm
from rsegen.params.registry import summary
from rsegen.params.sorts import parameters


class FormatList(QWidget):
    """A box, a summary and options per format, or what must be installed for it; `changed`: a box was toggled."""

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
        """Whether any format is ticked."""
        return any(box.isChecked() for box in self._boxes.values())

    def formats(self) -> tuple[Format, ...]:
        """The formats that are ticked, with their options; a ParameterError if an option is invalid."""
        return tuple(self._format(name) for name, box in self._boxes.items() if box.isChecked())

    def _format(self, name: str) -> Format:
        try:
            return self._options[name].value() if name in self._options else FORMATS[name]()
        except ParameterError as error:
            raise error.inside(name) from None

    def _add(self, name: str, cls: type[Format]) -> None:
        row, reason = self._grid.rowCount(), _missing(cls)
        self._boxes[name] = box = named(QCheckBox(name), f"format_{name}", title=name, tip=summary(cls))
        about = QLabel(summary(cls), wordWrap=True)
        about.setContentsMargins(0, 3, 0, 3)  # in line with the box
        for column, widget in enumerate((box, about)):
            widget.setEnabled(not reason)
            self._grid.addWidget(widget, row, column, Qt.AlignmentFlag.AlignTop)
        box.toggled.connect(self.changed)
        if reason:
            self._grid.addWidget(_missing_label(name, reason), row + 1, 1)
        elif parameters(cls):
            self._add_options(row + 1, name, cls)

    def _add_options(self, row: int, name: str, cls: type[Format]) -> None:
        """Add the options of a format, visible while its box is ticked."""
        self._options[name] = options = named(OptionsForm(cls), f"options_{name}", title=f"options of {name}")
        options.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        options.form.setContentsMargins(0, 0, 0, 8)
        options.setVisible(False)
        self._boxes[name].toggled.connect(options.setVisible)
        self._grid.addWidget(options, row, 1)


def _missing(cls: type[Format]) -> str:
    """What must be installed for a format, with the command; empty if nothing is missing."""
    try:
        cls().refuse_missing()
    except UserError as error:
        return str(error)
    return ""


def _missing_label(name: str, reason: str) -> MessageLabel:
    """A warning with the reason, whose text can be selected and copied."""
    label = MessageLabel(f"missing_{name}", "warning")
    label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    label.show_message(reason)
    return label
