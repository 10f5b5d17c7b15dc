"""The form of Start, which writes worlds: output folder, build sheets, and the button of the export dialog."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox, QPushButton

from rsegen.gui.model.jobs import WorldsJob
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.run_form import FormTexts, RunForm
from rsegen.recipe.recipe import Recipe

_TEXTS = FormTexts("folder", "worlds", "maps", "Start", "write the maps into the folder (F5)")


class StartForm(RunForm):
    """Writes worlds, with build sheets if their box is ticked."""

    def __init__(self) -> None:
        tip = "add a build sheet to every map, sheet.pdf and sheet.csv: the cutting list, and the place of each block"
        sheets = named(QCheckBox("Build sheets"), "sheets", tip=tip)
        tip = "write the maps for other programs: meshes, arrays, images and more (Ctrl+Shift+E)"
        export = named(QPushButton("Export..."), "export", tip=tip)
        tip = "open the map that is shown in a simulator"
        self.open_in = named(QPushButton("Open in Gazebo..."), "open_in", title="open in Gazebo", tip=tip)
        tip = "spawn the map that is shown in the running simulation (F6)"
        self.spawn = named(QPushButton("Send"), "spawn", title="send to the running simulation", tip=tip)
        super().__init__(_TEXTS, sheets, export, afterwards=(self.open_in, self.spawn))
        self.sheets, self.export = sheets, export
        sheets.toggled.connect(lambda: self.error_label.show_message(""))

    def job(self, recipe: Recipe) -> WorldsJob:
        """The job that Start runs for a recipe."""
        return WorldsJob(recipe=recipe, folder=self.folder, sheets=self.sheets.isChecked())
