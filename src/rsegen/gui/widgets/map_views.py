"""The right half of the window: the map in 3D, the plan, the table of obstacles and the status bar."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QShowEvent
from PySide6.QtWidgets import QComboBox, QFrame, QHBoxLayout, QLabel, QSplitter, QStatusBar, QToolButton, QWidget

from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.colours import bright
from rsegen.gui.model.document import Document
from rsegen.gui.model.obstacle_ends import cells_between
from rsegen.gui.model.preview import Costs, Preview, Share
from rsegen.gui.model.reach import Reach
from rsegen.gui.model.simulation import robot_names
from rsegen.gui.widgets.brush_bar import BrushBar
from rsegen.gui.widgets.editors import IntegerBox
from rsegen.gui.widgets.field_view import FieldView
from rsegen.gui.widgets.layouts import column_of, group_of, named
from rsegen.gui.widgets.obstacle_table import ListBar, ObstacleTable
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.gui.widgets.plan_view import PlanView
from rsegen.io.recipe_file import load
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe

SIDE = 64
"""The side of a picture in pixels."""

_SHOWN = ("mixed-course", "turtlebot", "red-diagonal-pallet")
_TEXT = """<b>This map is still flat.</b><br>
Choose an obstacle type on the left: it is shown pale where it would lie. <b>+&nbsp;Add</b> puts it into the list.<br>
Or draw one on the plan with the mouse. Or start from an example:"""


class Welcome(QFrame):
    """`chosen` gives the file of an example; `more` asks for all examples. It is empty until it is shown."""

    chosen = Signal(Path)
    more = Signal()

    def __init__(self) -> None:
        super().__init__()
        named(self, "welcome", title="how to begin")
        self.setFrameShape(QFrame.Shape.StyledPanel)

    def showEvent(self, event: QShowEvent) -> None:
        """Fill the panel: the maps of its pictures are made only for those who see them."""
        if self.layout() is None:
            self._fill()
        super().showEvent(event)

    def _fill(self) -> None:
        row = QHBoxLayout(self)
        text = QLabel(_TEXT, wordWrap=True, textFormat=Qt.TextFormat.RichText)
        row.addWidget(text, stretch=1)
        for name in _SHOWN:
            row.addWidget(self._example(name))
        more = named(QToolButton(), "more_examples", title="more examples", tip="all examples (Ctrl+Shift+N)")
        more.setText("More...")
        more.clicked.connect(self.more)
        row.addWidget(more)

    def _example(self, name: str) -> QToolButton:
        path = EXAMPLES[name]
        recipe = load(path)
        button = named(QToolButton(), f"example_{name}", title=f"example {name}", tip=recipe.description)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        button.setIcon(square_icon(compose(recipe, recipe.first_map), SIDE))
        button.setIconSize(QSize(SIDE, SIDE))
        button.setText(name)
        button.clicked.connect(lambda: self.chosen.emit(path))
        return button


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


_LISTED = 24


class LevelBar(QWidget):
    """A coloured part per level, as long as its share of blocks; the tooltip has the counts."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "levels", title="blocks of each level")
        self._shares: Sequence[Share] = ()

    def show_shares(self, shares: Sequence[Share]) -> None:
        """Show these shares, from the lowest level."""
        self._shares = shares
        more = len(shares) - _LISTED
        lines = [f"{share.name}: {share.blocks:,} blocks" for share in shares[:_LISTED]]
        self.setToolTip("\n".join([*lines, *([f"and {more} more levels"] if more > 0 else [])]))
        self.setAccessibleDescription(self.toolTip())
        self.update()

    def sizeHint(self) -> QSize:
        """Room for a few heights."""
        return QSize(200, self.fontMetrics().height() + 4)

    def minimumSizeHint(self) -> QSize:
        """The smallest legible bar."""
        return QSize(80, self.fontMetrics().height() + 4)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint each part in its level's colour, with its height if there is room."""
        painter = QPainter(self)
        for share, part in self._parts():
            painter.fillRect(part, QColor(*share.colour))
            light = bool(bright(np.array(share.colour, dtype=np.uint8)))
            painter.setPen(Qt.GlobalColor.black if light else Qt.GlobalColor.white)
            if self.fontMetrics().horizontalAdvance(share.name) + 4 <= part.width():
                painter.drawText(part, Qt.AlignmentFlag.AlignCenter, share.name)
        painter.setPen(self.palette().color(QPalette.ColorRole.Mid))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _parts(self) -> Iterator[tuple[Share, QRectF]]:
        left, a_block = 0.0, self.width() / max(sum(share.blocks for share in self._shares), 1)
        for share in self._shares:
            yield share, QRectF(left, 0, share.blocks * a_block, self.height())
            left += share.blocks * a_block


_MOST = 2**31 - 1


class MapStatusBar(QStatusBar):
    """Shows numbers of the map; `index_changed`: another map is chosen; `robot_changed`: another robot is."""

    index_changed = Signal()
    robot_changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.index = named(IntegerBox(prefix="map "), "index", tip="which of the maps is shown")
        self._first = 0
        self.levels, self.numbers = LevelBar(), named(QLabel(), "numbers")
        self.costs, self.cell = named(QLabel(indent=12), "costs"), named(QLabel(), "cell")
        self.robot = named(
            QComboBox(),
            "robot",
            tip="whether this robot can cross the map, by the steps that it mostly crosses and its width; on the plan "
            "the largest area is in colour, in which it can drive from every place to every other, lines are its ways "
            "across (dashed: it does not get across), S and G are spots for a start and a goal",
        )
        self.robot.addItems(["no robot", *robot_names()])
        self.crossing = named(QLabel(), "crossing")
        for widget in (self.index, self.levels, self.numbers, self.costs, self.robot, self.crossing):
            self.addWidget(widget)
        self.addPermanentWidget(self.cell)
        self.index.valueChanged.connect(lambda: self.index_changed.emit())
        self.robot.currentIndexChanged.connect(lambda: self.robot_changed.emit())

    def shown_index(self) -> int:
        """The index of the map that is chosen."""
        return self._first + self.index.value()

    def show_index(self, index: int) -> None:
        """Choose the map of an index, if the recipe has it."""
        self.index.setValue(index - self._first)

    @property
    def robot_name(self) -> str:
        """The robot that is chosen, empty if none is."""
        return self.robot.currentText() if self.robot.currentIndex() else ""

    def show_recipe(self, recipe: Recipe) -> None:
        """Limit the index to the maps of a recipe; indices that a spin box cannot show are counted from the first."""
        low, high = recipe.indices[0], recipe.indices[-1]
        self._first = low if high > _MOST else 0
        self.index.setPrefix(f"map {self._first} + " if self._first else "map ")
        self.index.setRange(low - self._first, min(high - self._first, _MOST))

    def show_preview(self, preview: Preview) -> None:
        """Show the numbers of a map; its costs follow."""
        self.numbers.setText(preview.numbers)
        self.levels.show_shares(preview.shares)
        self.costs.setText("")

    def show_costs(self, costs: Costs) -> None:
        """Show what a map costs, and whether the robot can cross it."""
        self.costs.setText(costs.text)
        self.crossing.setText(costs.reach.text if costs.reach else "")
