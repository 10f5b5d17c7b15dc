"""The right half of the window: the map in 3D, below it the plan and the table of obstacles."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QSplitter

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.document import Document
from rsegen.gui.model.handles import cells_between
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.reach import Reach
from rsegen.gui.widgets.brush_bar import BrushBar
from rsegen.gui.widgets.field_view import FieldView
from rsegen.gui.widgets.layouts import column_of, group_of
from rsegen.gui.widgets.list_bar import ListBar
from rsegen.gui.widgets.obstacle_table import ObstacleTable
from rsegen.gui.widgets.plan_view import PlanView
from rsegen.gui.widgets.welcome import Welcome


class MapViews(QSplitter):
    """Shows a document and the preview of its map; the views have signals of their own."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Vertical)
        self.table, self.view, self.plan, self.brushes = ObstacleTable(), FieldView(), PlanView(), BrushBar()
        self.list_bar, self.welcome = ListBar(), Welcome()
        self.brushes.chosen.connect(self.plan.set_brush)
        self.plan.picked.connect(self.brushes.pick)
        self.below = QSplitter()
        self.below.addWidget(column_of(self.brushes, self.plan))
        self.below.addWidget(group_of("Obstacles, imposed from the first to the last", self.list_bar, self.table))
        self.below.setStretchFactor(0, 1)
        self.below.setSizes([330, 520])
        self.addWidget(column_of(self.welcome, self.view))
        self.addWidget(self.below)
        self.setSizes([380, 320])

    def fit(self) -> None:
        """Show the whole map in both views."""
        self.view.fit()
        self.plan.fit()

    def show_document(self, document: Document) -> None:
        """Show the obstacles of a document and their ends; the cells of plan and view follow with the preview."""
        session = document.session
        if self.plan.cells:
            self.plan.show_handles(document.handles(self.plan.cells), _selected(document))
        self.welcome.setVisible(not session.draft.rows)
        self.list_bar.show_rows(len(session.draft.rows), is_selected=document.selected >= 0)
        self.table.show_grid(session.recipe.grid)
        self.table.show_rows(session.draft.rows, document.selected, session.problem)
        self.brushes.show_unit(session.recipe.unit_cm)

    def show_reach(self, reach: Reach | None) -> None:
        """Show what a robot can do on the map, on both views."""
        self.plan.show_reach(reach)
        self.view.show_reach(reach)

    def show_preview(self, preview: Preview, document: Document) -> None:
        """Show a preview, the handles of the obstacles, and the cells of the selected one."""
        self.view.show_preview(preview, _selected_cells(preview.scene, document))
        self.brushes.show_scene(preview.scene)
        self.plan.show(preview.scene, document.handles(preview.scene.field.blocks.shape), _selected(document))
        self.plan.show_ghost(preview.ghost)


def _selected(document: Document) -> int | None:
    return document.selected if document.selected >= 0 else None


def _selected_cells(scene: Scene, document: Document) -> CellWindow | None:
    """The cells, frames included, between the ends of the selected obstacle."""
    handles = document.handles(scene.field.blocks.shape)
    handle = next((each for each in handles if each.row == document.selected), None)
    return cells_between(handle, scene.field) if handle else None
