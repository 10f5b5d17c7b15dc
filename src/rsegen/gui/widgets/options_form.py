"""A form generated from the parameters of a dataclass, such as the options of a format."""

from __future__ import annotations

from dataclasses import fields
from typing import Generic, TypeVar

from PySide6.QtWidgets import QFormLayout, QLabel, QWidget

from rsegen.gui.widgets.editors import Editor, editor
from rsegen.params.sorts import parameters

Owner = TypeVar("Owner")


class OptionsForm(QWidget, Generic[Owner]):
    """An editor for each parameter; `editors` are they by name, `form` is the layout."""

    def __init__(self, owner: type[Owner], initial: Owner | None = None) -> None:
        """The editors have the values of `initial` at first, by default the defaults."""
        super().__init__()
        self._owner, self._initial = owner, initial
        self.form = QFormLayout(self)
        self.form.setContentsMargins(0, 0, 0, 0)
        self.editors = {name: self._field(name) for name in parameters(owner)}

    def value(self) -> Owner:
        """An instance with the values in the form; a ParameterError if one is invalid."""
        return self._owner(**{name: each.value() for name, each in self.editors.items()})

    def add(self, each: Editor, title: str) -> None:
        """Add a row."""
        label = QLabel(title)
        label.setToolTip(each.fields[0].toolTip())
        label.setBuddy(each)
        self.form.addRow(label, each)

    def _field(self, name: str) -> Editor:
        each = editor(self._owner, name)
        default = next(field.default for field in fields(self._owner) if field.name == name)  # type: ignore[arg-type]  # a dataclass
        each.show_value(getattr(self._initial, name, default))
        plain = name.removesuffix("_cm").removesuffix("_mm")
        self.add(each, plain.replace("_", " ").capitalize())
        return each
