"""The window: forms on the left, the field on the right; every change goes through the session."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSettings, QTimer, Slot
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QLabel,
    QMainWindow,
    QMessageBox,
    QPushButton,
    QSpinBox,
)

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow
from rsegen.gui.brushes import Brushes
from rsegen.gui.editors import named
from rsegen.gui.files import dropped, take_dropped
from rsegen.gui.gazebo import InGazebo
from rsegen.gui.handles import Handle, handles_of, spanned
from rsegen.gui.layout import lay_out
from rsegen.gui.level_bar import LevelBar
from rsegen.gui.look import Look, is_quick, look_at
from rsegen.gui.map_form import OFTEN, SELDOM, MapForm
from rsegen.gui.menus import add_menus, enable_actions, show_export
from rsegen.gui.newest import Newest
from rsegen.gui.notice import Notice
from rsegen.gui.numbers import Costs, costs
from rsegen.gui.obstacle_form import ObstacleForm
from rsegen.gui.painting import BARE, paintable, painted
from rsegen.gui.plan import PlanView
from rsegen.gui.rows import Rows
from rsegen.gui.sending import Sending
from rsegen.gui.session import Session, straightened
from rsegen.gui.start_form import StartForm
from rsegen.gui.view import FieldView
from rsegen.params.places import Cell
from rsegen.simulation.robots import ROBOTS

PAUSE = 25
"""Milliseconds without a change after which the field is made anew."""


class Window(QMainWindow):
    """A session, seen."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.session = session
        self.scene: Scene | None = None
        self.selected = -1
        self._make_widgets()
        self.halves = lay_out(self)
        self._connect()
        add_menus(self)
        self.setAcceptDrops(True)
        self._remember()
        self.take(session)

    def take(self, session: Session) -> None:
        """Another session, such as that of a file."""
        self.session, self.selected = session, -1
        self.often.keep.setChecked(session.seed_kept)
        session.changed = self.refresh
        self.refresh()
        self._look()
        self.view.reset_camera()

    def refresh(self) -> None:
        """Show the draft; the field follows when nothing has changed for a moment."""
        draft, problem = self.session.draft, self.session.problem
        self.selected = min(self.selected, len(draft.rows) - 1)
        for form in (self.often, self.seldom):
            form.show_values(draft.values, problem)
        self.rows.show_rows(draft.rows, self.selected, problem)
        self._show_obstacle()
        self.complaint.say(str(problem) if problem else "")
        for button in (self.start, self.start_form.export):
            button.setEnabled(problem is None)
        self.index.setRange(self.session.recipe.indices[0], min(self.session.recipe.indices[-1], 2**31 - 1))
        self.setWindowTitle(f"{self.session.path.name if self.session.path else 'untitled'}[*] - rsegen")
        self.setWindowModified(self.session.unsaved)
        for button in (self.drop, self.clear):
            button.setEnabled(bool(draft.rows))
        enable_actions(self)
        self.gazebo.show_recipe(self.session.recipe)
        self._pause.start()

    def choose(self, row: int) -> None:
        """Take a row into the form."""
        self.selected = row
        self.refresh()

    def _make_widgets(self) -> None:
        self.often, self.seldom, self.obstacle, self.rows = MapForm(OFTEN), MapForm(SELDOM), ObstacleForm(), Rows()
        self.view, self.plan, self.brushes = FieldView(), PlanView(), Brushes()
        self.index = named(QSpinBox(prefix="map "), "index", tip="which of the maps is shown")
        self.add = named(QPushButton("+"), "add", title="add obstacle", tip="add this obstacle (Ctrl+Return)")
        self.drop = named(QPushButton("-"), "drop", title="remove last obstacle", tip="remove the last obstacle")
        self.clear = named(QPushButton("C"), "clear", title="clear all obstacles", tip="remove all obstacles")
        self.start_form = StartForm()
        self.start = self.start_form.start
        self.complaint = Notice("complaint")
        self.numbers = named(QLabel(), "numbers")
        self.costs, self.cell, self.levels = named(QLabel(indent=12), "costs"), named(QLabel(), "cell"), LevelBar()
        self.robot = named(QComboBox(), "robot", tip="whether this robot gets across, by what it climbs and its width")
        self.robot.addItems(["no robot", *ROBOTS])
        self.crossing = named(QLabel(), "crossing")
        self.warning = Notice("warning", "warning")
        self.looking, self.counting = Newest(self), Newest(self)
        self.gazebo, self.sending = InGazebo(self), Sending(self)
        self._pause = QTimer(self, singleShot=True, interval=PAUSE)

    def _connect(self) -> None:
        for form in (self.often, self.seldom):
            form.edited.connect(lambda name, value: self.session.set(name, value, gesture=name))
            form.reroll.connect(lambda: self.session.reroll())
        self.often.keep.toggled.connect(self._keep_seed)
        self.obstacle.edited.connect(self._obstacle_edited)
        self.rows.chosen.connect(self.choose)
        self.rows.switched.connect(lambda row, on: self.session.enable(row, enabled=on))
        self.rows.edited.connect(lambda row, entry: self.session.change(row, entry))
        self.rows.shifted.connect(self.move_obstacle)
        self.add.clicked.connect(self.add_obstacle)
        self.drop.clicked.connect(self._drop_last)
        self.clear.clicked.connect(lambda: self.session.clear())
        self.start.clicked.connect(self.generate)
        self.start_form.export.clicked.connect(lambda: show_export(self))
        self.start_form.changed.connect(lambda: enable_actions(self))
        self.index.valueChanged.connect(self._pause.start)
        self._pause.timeout.connect(self._look)
        self.looking.came.connect(self._looked)
        self.counting.came.connect(self._counted)
        self.robot.currentIndexChanged.connect(self._count)
        self.plan.chosen.connect(self.choose)
        self.plan.moved.connect(self._end_moved)
        self.plan.drawn.connect(self._drawn)
        self.plan.hovered.connect(self.cell.setText)
        self.plan.painted.connect(self._painted)
        self.brushes.chosen.connect(self.plan.take_brush)
        self.gazebo.asked.connect(lambda name: self.gazebo.open(name, self.session.recipe, self.index.value()))
        for each in (self.gazebo, self.sending):
            each.told.connect(self.statusBar().showMessage)

    @Slot()
    def add_obstacle(self) -> None:
        """The obstacle of the form, as a row of its own at the end."""
        self.selected = len(self.session.draft.rows)
        self.session.add(self.obstacle.entry())

    def move_obstacle(self, row: int, to: int) -> None:
        """Put a row elsewhere in the list, and keep it chosen."""
        self.selected = to
        self.session.move(row, to)

    def _drop_last(self) -> None:
        if self.session.draft.rows:
            self.session.remove(len(self.session.draft.rows) - 1)

    def _keep_seed(self, kept: bool) -> None:  # noqa: FBT001  # a signal's
        self.session.seed_kept = kept

    def _obstacle_edited(self) -> None:
        if self.selected >= 0:
            self.session.change(self.selected, self.obstacle.entry(), gesture=("form", self.selected))

    def _end_moved(self, row: int, end: str, x: int, y: int) -> None:
        entry = {**self.session.draft.rows[row].entry, end: [x, y]}
        self.selected = row
        other = "first" if end == "last" else "last"
        self.session.change(row, straightened(entry, other), gesture=("drag", row, end))

    def _drawn(self, x1: int, y1: int, x2: int, y2: int) -> None:
        self.selected = len(self.session.draft.rows)
        self.session.add(straightened({**self.obstacle.entry(), "first": [x1, y1], "last": [x2, y2]}, "last"))

    def _painted(self, cells: Sequence[Cell], level: int, stroke: int) -> None:
        """Into the matrix that is chosen, else into a new one."""
        rows, gesture = self.session.draft.rows, ("paint", stroke)
        if self.selected >= 0 and paintable(rows[self.selected].entry):
            entry = painted(rows[self.selected].entry, cells, level)
            self.session.change(self.selected, entry, gesture=gesture)
        elif level != BARE:
            self.selected = len(rows)
            self.session.add(painted(None, cells, level), gesture=gesture)

    def _show_obstacle(self) -> None:
        recipe, rows = self.session.recipe, self.session.draft.rows
        entry = rows[self.selected].entry if self.selected >= 0 else self.obstacle.entry()
        self.obstacle.show_entry(entry, recipe.grid, recipe.unit_cm)
        self.brushes.show_unit(recipe.unit_cm)

    def _look(self) -> None:
        """Make the field: a large one behind the window."""
        recipe = self.session.recipe
        self.looking.order(partial(look_at, recipe, self.index.value()), at_once=is_quick(recipe))

    def _looked(self, look: object) -> None:
        """Show it from both sides, and count what it costs when there is time."""
        if not isinstance(look, Look):
            self.complaint.say(str(look))
            return
        self.scene = look.scene
        self.view.show_look(look, self._highlighted())
        self.plan.show(look.scene, self._handles(), self.selected if self.selected >= 0 else None)
        self.numbers.setText(look.numbers)
        self.levels.show_shares(look.shares)
        self.costs.setText("")
        self._count()

    def _count(self) -> None:
        """What the map costs, and what the chosen robot makes of it."""
        self.crossing.setText("")
        if self.scene:
            kind = self.robot.currentText() if self.robot.currentIndex() else ""
            self.counting.order(partial(costs, self.scene, kind))

    def _counted(self, found: object) -> None:
        if isinstance(found, Costs):
            self.costs.setText(found.text)
            self.crossing.setText(found.crossing)
            self.warning.say("\n".join(f"Warning: {text}" for text in found.warnings))

    def _handles(self) -> list[Handle]:
        return handles_of(self.session.draft.rows, self.scene.field.blocks.shape) if self.scene else []

    def _highlighted(self) -> CellWindow | None:
        """The cells, frames counted, of the obstacle that is edited."""
        handle = next((each for each in self._handles() if each.row == self.selected), None)
        return spanned(handle, self.scene.field) if handle and self.scene else None

    @Slot()
    def generate(self) -> None:
        """Write the maps into the folder of the form; first draw another seed, unless this one is kept."""
        ready = self.start.isEnabled() and not self.start_form.busy
        if ready and self.start_form.is_free_for(self.start_form.job(self.session.recipe)):
            if not self.session.seed_kept:
                self.session.reroll()
            self.start_form.write(self.start_form.job(self.session.recipe))

    def generate_into(self, folder: Path) -> None:
        """Write the maps into another folder."""
        self.start_form.folder = folder
        self.generate()

    def _remember(self) -> None:
        settings = QSettings("rsegen", "rsegen")
        self.resize(1280, 720)
        if settings.contains("geometry"):
            self.restoreGeometry(settings.value("geometry"))
            self.halves.restoreState(settings.value("halves"))
        else:
            self.halves.setSizes([430, 850])

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Recipes, data sets and heights may be dropped."""
        if dropped(event):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open what is dropped."""
        if path := dropped(event):
            take_dropped(self, path)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask where something is not saved; wait for what is being written."""
        question = "The recipe is not saved. Leave it?"
        buttons = QMessageBox.StandardButton.Discard | QMessageBox.StandardButton.Cancel
        if self.session.unsaved and (
            QMessageBox.question(self, "rsegen", question, buttons) != QMessageBox.StandardButton.Discard
        ):
            event.ignore()
            return
        for dialog in self.findChildren(QDialog):
            dialog.close()
        for work in (self.start_form, self.looking, self.counting, self.gazebo, self.sending):
            work.end()
        settings = QSettings("rsegen", "rsegen")
        settings.setValue("geometry", self.saveGeometry())
        settings.setValue("halves", self.halves.saveState())
        self.view.close()
        super().closeEvent(event)
