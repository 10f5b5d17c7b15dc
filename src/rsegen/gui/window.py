"""The main window: forms on the left, the map on the right; it connects them with the document."""

from __future__ import annotations

from contextlib import suppress

from PySide6.QtCore import QSettings, QSize, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import QDialog, QMainWindow, QMenu, QSplitter

from rsegen.gui.dialogs.gallery import GalleryDialog
from rsegen.gui.dialogs.manual import show_manual
from rsegen.gui.files import Files, dropped_path
from rsegen.gui.menus import fill_edit_menu, fill_file_menu, fill_run_menu, fill_view_menu
from rsegen.gui.model.document import Document
from rsegen.gui.model.obstacle_ends import fixed
from rsegen.gui.model.preview import Costs, Preview
from rsegen.gui.model.session import Entry, Session
from rsegen.gui.model.simulation import robot_shape
from rsegen.gui.outputs import Outputs
from rsegen.gui.widgets.map_views import MapStatusBar, MapViews
from rsegen.gui.widgets.recipe_forms import RecipeForms
from rsegen.gui.widgets.simulator_actions import Command, CommandMenus, SimulatorActions
from rsegen.gui.widgets.view_camera import Side
from rsegen.gui.workers import Previewer
from rsegen.params.sorts import Cell

PAUSE = 25
"""Milliseconds without a change after which the preview is computed."""


class Window(QMainWindow):
    """Shows a document; every change goes through it, and it tells the window to show itself again."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self.document = Document(session)
        self.forms, self.views, self.status = RecipeForms(), MapViews(), MapStatusBar()
        self.previewer, self.simulators = Previewer(self), SimulatorActions(self)
        self.files = Files(self.document, self)
        self.outputs = Outputs(self.document, self.forms.start_form, self.status, self.forms.note, self)
        self._pause = QTimer(self, singleShot=True, interval=PAUSE)
        self._lay_out()
        self._connect_forms()
        self._connect_views()
        self._connect_workers()
        self._add_menus()
        self.setAcceptDrops(True)
        self._restore_geometry()
        self.document.changed, self.document.opened = self._show_document, self._show_opened
        self.document.open(session)
        self._restore_camera()

    @property
    def session(self) -> Session:
        """The session of the document."""
        return self.document.session

    def finish_typing(self) -> None:
        """Take over a text that was typed into a field or a cell and not yet finished with Enter."""
        self.views.table.finish_typing()
        self.forms.finish_typing()

    def add_obstacle(self) -> None:
        """Add the obstacle of the form at the end of the list."""
        self.document.add(self.forms.obstacle.entry())

    def show_all_maps(self) -> None:
        """Open the dialog with pictures of all maps of the recipe; the one that is chosen there is shown."""
        recipe = self.session.recipe
        dialog = GalleryDialog(
            f"Maps of {recipe.name}", recipe.maps, lambda place: (recipe, recipe.indices[place]), self
        )
        dialog.chosen.connect(lambda place: self.status.show_index(recipe.indices[place]))
        dialog.open()

    def _lay_out(self) -> None:
        self.halves = QSplitter()
        for widget, stretch in ((self.forms, 0), (self.views, 1)):
            self.halves.addWidget(widget)
            self.halves.setStretchFactor(self.halves.count() - 1, stretch)
        self.setCentralWidget(self.halves)
        self.setStatusBar(self.status)

    def _connect_forms(self) -> None:
        forms, document = self.forms, self.document
        forms.edited.connect(lambda name, value: document.session.set(name, value, gesture=name))
        forms.reroll.connect(lambda: document.session.reroll())
        forms.basic.keep.toggled.connect(self._keep_seed)
        forms.obstacle.edited.connect(lambda: document.edit(forms.obstacle.entry()))
        forms.obstacle.fixed = self._fixed
        forms.another.clicked.connect(lambda: document.select(-1))
        for button, run in ((forms.start, self.outputs.start), (forms.start_form.export, self.outputs.export)):
            button.pressed.connect(self.finish_typing)  # some desktops leave the keyboard with the field
            button.clicked.connect(lambda _=False, run=run: run())
        forms.start_form.changed.connect(lambda: self._menus.refresh())
        forms.start_form.spawn.clicked.connect(lambda: self.outputs.spawn())
        self._simulators = QMenu(self)
        self.simulators.add_to(self._simulators)
        button = forms.start_form.open_in
        button.clicked.connect(lambda: self._simulators.popup(button.mapToGlobal(button.rect().topLeft())))

    def _connect_views(self) -> None:
        table, plan, document = self.views.table, self.views.plan, self.document
        bar, welcome = self.views.list_bar, self.views.welcome
        bar.add.clicked.connect(lambda: self.add_obstacle())
        bar.remove.clicked.connect(lambda: document.remove_selected_or_last())
        bar.clear.clicked.connect(lambda: document.session.clear())
        welcome.chosen.connect(self.files.open_example)
        welcome.more.connect(self.files.choose_example)
        table.chosen.connect(document.select)
        table.switched.connect(lambda row, on: document.session.enable(row, enabled=on))
        table.edited.connect(lambda row, entry: document.session.change(row, entry))
        table.shifted.connect(document.move)
        plan.chosen.connect(document.select)
        plan.moved.connect(lambda row, end, x, y: document.move_end(row, end, (x, y)))
        plan.drawn.connect(lambda x1, y1, x2, y2: document.draw(self.forms.obstacle.entry(), (x1, y1), (x2, y2)))
        plan.painted.connect(document.paint)
        plan.hovered.connect(self.status.cell.setText)
        self.views.view.clicked.connect(self._select_at)

    def _select_at(self, cell: Cell | None) -> None:
        if self.previewer.scene:
            self.document.select_at(cell, self.previewer.scene.field)

    def _connect_workers(self) -> None:
        self._pause.timeout.connect(self._preview)
        self.previewer.previewed.connect(self._show_preview)
        self.previewer.counted.connect(self._show_costs)
        self.previewer.failed.connect(self.forms.show_failure)
        self.status.index_changed.connect(self._pause.start)
        self.status.robot_changed.connect(self._show_robot)
        self.simulators.requested.connect(
            lambda name: self.simulators.open(name, self.session.recipe, self.status.shown_index())
        )
        self.simulators.message.connect(self.forms.note.show_message)

    def _add_menus(self) -> None:
        self._menus, bar, views = CommandMenus(self, self.finish_typing), self.menuBar(), self.views
        fill_file_menu(self._menus, bar.addMenu("&File"), self.files, self.close)
        fill_edit_menu(self._menus, bar.addMenu("&Edit"), self.document, self.add_obstacle, views.brushes.paint.toggle)
        fill_view_menu(self._menus, bar.addMenu("&View"), views, self.outputs, self.show_all_maps)
        fill_run_menu(self._menus, bar.addMenu("&Run"), self.outputs, self.forms.start_form, self.simulators)
        self._menus.add(bar.addMenu("&Help"), Command("&Manual", lambda: show_manual(self), "F1"))

    def _show_opened(self) -> None:
        """Show another session at once, the whole map in view."""
        self.forms.basic.keep.setChecked(self.session.seed_kept)
        self.forms.start_form.forget()
        self.forms.obstacle.reset()
        self._show_document()
        self._preview()
        self.views.view.look_from(Side.PERSPECTIVE)

    def _show_document(self) -> None:
        """Show the document; its preview follows when nothing has changed for a moment."""
        session = self.session
        self.forms.show_document(self.document)
        self.views.show_document(self.document)
        self.status.show_recipe(session.recipe)
        self.simulators.show_recipe(session.recipe, is_valid=session.problem is None)
        self.setWindowTitle(f"{session.title}[*] - rsegen")
        self.setWindowModified(session.unsaved)
        self._menus.refresh()
        self._pause.start()

    def _preview(self) -> None:
        proposed = self.document.keyed(self.forms.obstacle.entry()) if self.document.is_proposing else None
        self.previewer.preview(self.session.recipe, self.status.shown_index(), proposed)

    def _show_preview(self, preview: Preview) -> None:
        self.forms.show_failure("")
        self.views.show_preview(preview, self.document)
        self.status.show_preview(preview)
        self._count()

    def _count(self) -> None:
        self.status.crossing.setText("")
        self.views.show_reach(None)
        self.previewer.count(self.status.robot_name)

    def _show_robot(self) -> None:
        self.views.view.show_robot(robot_shape(name) if (name := self.status.robot_name) else None)
        self._count()

    def _show_costs(self, costs: Costs) -> None:
        self.status.show_costs(costs)
        self.views.show_reach(costs.reach)
        self.forms.show_warnings(costs.warnings)

    def _fixed(self, entry: Entry) -> Entry:
        """An entry with its ends fixed where they are in the map that is shown."""
        return fixed(self.document.keyed(entry), self.session.recipe, self.status.shown_index())

    def _keep_seed(self, kept: bool) -> None:  # noqa: FBT001  # a signal's
        self.session.seed_kept = kept

    def _splitters(self) -> dict[str, QSplitter]:
        return {"halves": self.halves, "views": self.views, "below": self.views.below}

    def _restore_geometry(self) -> None:
        """The size and the parts as they were last, or by default; never larger than the screen."""
        settings, room = QSettings("rsegen", "rsegen"), self.screen().availableSize()
        self.resize(QSize(1280, 720).boundedTo(room * 0.95))
        self.halves.setSizes([430, 850])
        if settings.contains("geometry"):
            self.restoreGeometry(settings.value("geometry"))
        for name, splitter in self._splitters().items():
            if settings.contains(name):
                splitter.restoreState(settings.value(name))
        self.forms.tabs.setCurrentIndex(int(str(settings.value("tab", 0))))

    def _restore_camera(self) -> None:
        """Look from where the window looked last."""
        with suppress(ValueError):  # nothing was kept, or it is no direction
            x, y, z = map(float, str(QSettings("rsegen", "rsegen").value("camera", "")).split())
            self.views.view.look_along((x, y, z))

    def _keep_geometry(self) -> None:
        settings = QSettings("rsegen", "rsegen")
        settings.setValue("geometry", self.saveGeometry())
        for name, splitter in self._splitters().items():
            settings.setValue(name, splitter.saveState())
        settings.setValue("tab", self.forms.tabs.currentIndex())
        if direction := self.views.view.direction:
            settings.setValue("camera", " ".join(map(str, direction)))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Escape selects no obstacle, so that the form is for a new one."""
        if event.key() == Qt.Key.Key_Escape:
            self.document.select(-1)
        else:
            super().keyPressEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept recipes, data sets and files of heights."""
        if dropped_path(event):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open what is dropped."""
        if path := dropped_path(event):
            self.files.open_dropped(path)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask if the recipe is not saved; then stop what is running, and wait for it."""
        self.finish_typing()
        if not self.files.may_leave():
            event.ignore()
            return
        self._pause.stop()
        for dialog in self.findChildren(QDialog):
            dialog.close()
        for work in (self.outputs, self.previewer, self.simulators):
            work.stop()
        self._keep_geometry()
        self.views.view.close()
        super().closeEvent(event)
