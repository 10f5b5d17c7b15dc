"""The entries of the menus; each function gets just the objects that its entries call."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QMenu

from rsegen.gui.files import Files
from rsegen.gui.model.document import Document
from rsegen.gui.outputs import Outputs
from rsegen.gui.widgets.map_views import MapViews
from rsegen.gui.widgets.recipe_forms import StartForm
from rsegen.gui.widgets.simulator_actions import Command, CommandMenus, SimulatorActions
from rsegen.gui.widgets.view_camera import Side

_Standard = QKeySequence.StandardKey
_CLOSER = 1.25


def fill_file_menu(menus: CommandMenus, menu: QMenu, files: Files, close: Callable[[], object]) -> None:
    """File: open, save, quit."""
    menus.add(
        menu,
        Command("&New", files.new, _Standard.New),
        Command("New from &example...", files.choose_example, "Ctrl+Shift+N"),
        Command("&Open...", files.choose_file, _Standard.Open),
        Command("Open a map of a &data set...", files.choose_dataset, "Ctrl+Shift+O"),
    )
    menu.addMenu(files.recent)
    menus.add(
        menu,
        Command("Read &heights...", files.choose_heights, "Ctrl+I"),
        Command("&Save", files.save, _Standard.Save),
        Command("Save &as...", files.save_as, _Standard.SaveAs),
        Command("&Quit", close, _Standard.Quit),
    )


def fill_edit_menu(
    menus: CommandMenus, menu: QMenu, document: Document, add: Callable[[], object], paint: Callable[[], object]
) -> None:
    """Edit: undo, redo, changes of the obstacles, painting, another seed."""
    menus.add(
        menu,
        Command("&Undo", lambda: document.session.undo(), _Standard.Undo, lambda: document.session.can_undo),
        Command("&Redo", lambda: document.session.redo(), _Standard.Redo, lambda: document.session.can_redo),
    )
    menu.addSeparator()
    menus.add(
        menu,
        Command("&Add obstacle", add, "Ctrl+Return"),
        Command("&Duplicate obstacle", document.duplicate, "Ctrl+D", lambda: document.selected >= 0),
        Command("Re&move obstacle", document.remove, _Standard.Delete, lambda: document.selected >= 0),
        Command("Move obstacle u&p", lambda: document.shift(-1), "Alt+Up", lambda: document.can_shift(-1)),
        Command("Move obstacle d&own", lambda: document.shift(1), "Alt+Down", lambda: document.can_shift(1)),
        Command("&Paint cells", paint, "P"),
        Command("Re-&roll the seed", lambda: document.session.reroll(), "Ctrl+R"),
    )


def fill_view_menu(
    menus: CommandMenus, menu: QMenu, views: MapViews, outputs: Outputs, show_all: Callable[[], object]
) -> None:
    """View: the camera, and pictures of what is seen."""
    view = views.view
    menus.add(
        menu,
        Command("&Whole map", views.fit, "Ctrl+0"),
        Command("Zoom the plan &in", lambda: views.plan.zoom(_CLOSER), _Standard.ZoomIn),
        Command("Zoom the plan &out", lambda: views.plan.zoom(1 / _CLOSER), _Standard.ZoomOut),
        Command("In &perspective", lambda: view.look_from(Side.PERSPECTIVE), "Ctrl+1"),
        Command("From &above", lambda: view.look_from(Side.TOP), "Ctrl+2"),
        Command("From the &south", lambda: view.look_from(Side.SOUTH), "Ctrl+3"),
        Command("All &maps of the recipe...", show_all, "Ctrl+M", lambda: outputs.is_valid),
        Command("Save &picture...", lambda: outputs.save_picture(view)),
        Command("Save p&lan...", lambda: outputs.save_plan(views.plan)),
    )


def fill_run_menu(
    menus: CommandMenus, menu: QMenu, outputs: Outputs, form: StartForm, simulators: SimulatorActions
) -> None:
    """Run: everything that is made of the recipe."""
    menus.add(
        menu,
        Command("&Start: write the maps", outputs.start, "F5", lambda: outputs.is_possible),
        Command("&Export for other programs...", outputs.export, "Ctrl+Shift+E", lambda: outputs.is_possible),
        Command("&Build sheet...", outputs.build_sheet, "Ctrl+B", lambda: outputs.is_possible),
        Command("Open the &folder", form.open_folder, "", lambda: form.written is not None),
    )
    simulators.add_to(menu)
    menus.add(
        menu,
        Command("Spawn in the &running simulation", outputs.spawn, "F6", lambda: outputs.is_valid),
        Command("&Drive over the map...", outputs.drive, "Ctrl+Shift+D", lambda: outputs.is_valid),
        Command("E&xperiment...", outputs.experiment),
        Command("Show &command line and Python code...", outputs.show_code, "Ctrl+E", lambda: outputs.is_valid),
    )
