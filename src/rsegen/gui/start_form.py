"""Start: worlds into a folder, with build sheets or without; beside it what else can be written."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox, QPushButton

from rsegen.gui.editors import named
from rsegen.gui.jobs import Worlds
from rsegen.gui.run_form import RunForm, Words
from rsegen.recipe.recipe import Recipe

_WORDS = Words("folder", "worlds", "maps", "Start", "write the maps into the folder (F5)")


class StartForm(RunForm):
    """The form of Start."""

    def __init__(self) -> None:
        tip = "add a build sheet to every map, sheet.pdf and sheet.csv: what to saw, and where each block stands"
        sheets = named(QCheckBox("Build sheets"), "sheets", tip=tip)
        tip = "write the maps for other programs: meshes, arrays, images and more (Ctrl+Shift+E)"
        export = named(QPushButton("Export..."), "export", tip=tip)
        super().__init__(_WORDS, sheets, export)
        self.sheets, self.export = sheets, export
        sheets.toggled.connect(lambda: self.complaint.say(""))

    def job(self, recipe: Recipe) -> Worlds:
        """What Start does with a recipe."""
        return Worlds(recipe=recipe, folder=self.folder, sheets=self.sheets.isChecked())
