"""What a user can do to the window, each from a few random numbers; the same numbers do the same to the same window."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from random import Random

from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QAction, QDragEnterEvent, QDropEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QLineEdit, QMenu, QPlainTextEdit, QWidget

from rsegen.gui.window import Window
from tests.gui.random_actions.targets import front_dialog, is_of_a_folder, is_there, name_of, point_on, targets
from tests.gui.random_actions.texts import FILES, FOLDERS, TEXTS

Act = Callable[[Window, Random], str]
"""Does something, and says what: said before, as the widget may be gone after."""

_NEVER = {"Quit", "Open the folder"}
"""Quit is the action `close`; the folder would be shown by another program."""

_KEYS = (
    *(Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_Tab, Qt.Key.Key_Backtab),
    *(Qt.Key.Key_Return, Qt.Key.Key_Escape, Qt.Key.Key_Space, Qt.Key.Key_Delete, Qt.Key.Key_Backspace, Qt.Key.Key_Home),
    *(Qt.Key.Key_End, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown, Qt.Key.Key_F2, Qt.Key.Key_Plus, Qt.Key.Key_Minus),
    *(Qt.Key.Key_0, Qt.Key.Key_1, Qt.Key.Key_3, Qt.Key.Key_9, Qt.Key.Key_A, Qt.Key.Key_P, Qt.Key.Key_Period),
    *(Qt.Key.Key_B, Qt.Key.Key_R, Qt.Key.Key_F, Qt.Key.Key_I, Qt.Key.Key_2),
)
_MODIFIERS = (*[Qt.KeyboardModifier.NoModifier] * 6, Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.AltModifier)
_CONTROL = Qt.KeyboardModifier.ControlModifier
_LEFT = Qt.MouseButton.LeftButton
_TOOLS = ("paint", "paint_box", "paint_fill", "paint_pick")
_PRESSED = ("add", "add", "add", "remove", "clear", "reroll", *_TOOLS, "keep_seed", "default_ends")
_BUTTONS = (*[_LEFT] * 8, Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton)
_ENDS = (Qt.Key.Key_Return, Qt.Key.Key_Return, Qt.Key.Key_Tab, Qt.Key.Key_Escape, None, None)
_TYPED = 20


def click(window: Window, random: Random) -> str:
    """Click or double-click anywhere on a widget."""
    widget, button = random.choice(targets(window)), random.choice(_BUTTONS)
    where, modifier, twice = point_on(widget, random), random.choice(_MODIFIERS), random.random() < 0.2
    told = f"click{' twice' * twice} {name_of(widget)} at {where.toTuple()}"
    (QTest.mouseDClick if twice else QTest.mouseClick)(widget, button, modifier, where)
    return told


def press_button(window: Window, random: Random) -> str:
    """Click + (three times of four), -, C, Re-roll or Paint in their middle."""
    name = random.choice(_PRESSED)
    for widget in window.findChildren(QWidget, name):
        if widget in targets(window):
            QTest.mouseClick(widget, _LEFT, pos=QPoint(8, widget.height() // 2))
    return f"press {name}"


def drag(window: Window, random: Random) -> str:
    """Drag over a widget, and maybe press a shortcut or a key meanwhile, or never let go."""
    often = [] if front_dialog() else [window.views.plan] * 15 + [window.views.table.viewport()] * 5
    widget = random.choice([*often, *targets(window)])
    points = [point_on(widget, random) for _ in range(random.randint(2, 5))]
    button, told = random.choice(_BUTTONS), [f"drag {name_of(widget)} over {[point.toTuple() for point in points]}"]
    QTest.mousePress(widget, button, pos=points[0])
    for point in points[1:]:
        if not is_there(widget):
            return f"{', '.join(told)}, which is gone"
        QTest.mouseMove(widget, point)
        QApplication.processEvents()
        if random.random() < 0.2:
            told.append(shortcut(window, random))
        if random.random() < 0.1:
            told.append(wait(window, random))
    if random.random() < 0.9 and is_there(widget):
        QTest.mouseRelease(widget, button, pos=points[-1])
    return ", ".join(told)


def type_text(window: Window, random: Random) -> str:
    """Replace the text of a field, and finish it with Enter, Tab, Escape or not."""
    fields = [widget for widget in targets(window) if isinstance(widget, (QLineEdit, QAbstractSpinBox))]
    if not fields:
        return "type nowhere"
    return _typed(random.choice(fields), random)


def type_cell(window: Window, random: Random) -> str:
    """Type into a cell of the list of obstacles."""
    table = window.views.table
    if front_dialog():
        return close(window, random)
    if not table.rowCount():
        return press_button(window, random)
    row, column = random.randrange(table.rowCount()), random.randrange(1, table.columnCount())
    table.setCurrentCell(row, column)
    QTest.keyClick(table, Qt.Key.Key_F2)
    fields = [each for each in table.viewport().findChildren(QLineEdit) if each.isVisible()]
    return f"cell {row}, {column}: " + (_typed(fields[0], random) if fields else "no field")


def key(window: Window, random: Random) -> str:
    """Press keys in a widget, often the one that has the keyboard."""
    front = front_dialog() or window
    often = [front.focusWidget()] * 20 + ([] if front_dialog() else [window.views.plan] * 10)
    widget = random.choice([*often, *targets(window)]) or front
    pressed, modifier = [random.choice(_KEYS) for _ in range(random.randint(1, 4))], random.choice(_MODIFIERS)
    told = f"keys {[each.name for each in pressed]} {modifier.name} in {name_of(widget)}"
    for each in pressed:
        if is_there(widget):
            QTest.keyClick(widget, each, modifier)
            QApplication.processEvents()
    return told


def shortcut(window: Window, random: Random) -> str:
    """Choose an entry of the menus by its shortcut, or else by the menu."""
    action = random.choice([each for each in window.findChildren(QAction) if each.objectName() not in _NEVER])
    blocked = front_dialog() is not None
    if action.isEnabled() and not blocked and not action.menu():
        action.trigger()
    return f"{action.objectName() or action.text()!r}{' (not possible)' * (blocked or not action.isEnabled())}"


def change_history(window: Window, random: Random) -> str:
    """Press Ctrl+Z and Ctrl+Y a few times."""
    if front_dialog():
        return close(window, random)
    keys = [random.choice([Qt.Key.Key_Z, Qt.Key.Key_Z, Qt.Key.Key_Y]) for _ in range(random.randint(1, 5))]
    for each in keys:
        QTest.keyClick(window, each, _CONTROL)
        QApplication.processEvents()
    return f"history {[each.name for each in keys]}"


def paste(window: Window, random: Random) -> str:
    """Paste a text into what has the keyboard, or into a field."""
    fields = [each for each in targets(window) if isinstance(each, (QLineEdit, QAbstractSpinBox, QPlainTextEdit))]
    front = front_dialog() or window
    widget, text = random.choice([front.focusWidget() or front, *fields]), random.choice(TEXTS)
    if is_of_a_folder(widget):
        text = random.choice(FOLDERS)
    QApplication.clipboard().setText(text)
    told = f"paste {text!r} into {name_of(widget)}"
    QTest.keyClick(widget, Qt.Key.Key_V, _CONTROL)
    return told


def scroll(window: Window, random: Random) -> str:
    """Turn the wheel over a widget."""
    widget, turn = random.choice(targets(window)), random.choice([-480, -120, 120, 480])
    where, none = QPointF(point_on(widget, random)), Qt.MouseButton.NoButton
    event = QWheelEvent(
        where,
        widget.mapToGlobal(where),
        QPoint(),
        QPoint(0, turn),
        none,
        _MODIFIERS[0],
        Qt.ScrollPhase.NoScrollPhase,
        False,  # noqa: FBT003  # whether it is inverted; Qt takes no name
    )
    told = f"scroll {turn} over {name_of(widget)}"
    QApplication.sendEvent(widget, event)
    return told


def menu(window: Window, random: Random) -> str:
    """Open a menu, press a few keys in it, and close it."""
    if front_dialog():
        return close(window, random)
    found = random.choice(window.menuBar().findChildren(QMenu))
    found.popup(window.mapToGlobal(QPoint(20, 20)))
    keys = [random.choice([Qt.Key.Key_Down, Qt.Key.Key_Up, Qt.Key.Key_Right]) for _ in range(random.randint(0, 6))]
    for each in keys:
        QTest.keyClick(found, each)
    while popup := QApplication.activePopupWidget():
        popup.close()
    return f"menu {found.title()} {[each.name for each in keys]}"


def drop(window: Window, random: Random) -> str:
    """Drop a file on the window."""
    if front_dialog():
        return close(window, random)
    name, data = random.choice(FILES), QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(Path(name).absolute()))])
    where, copy = window.rect().center(), Qt.DropAction.CopyAction
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # from PySide6 6.12 on it is a QPointF
        entering = QDragEnterEvent(where, copy, data, _LEFT, _MODIFIERS[0])
    window.dragEnterEvent(entering)
    window.dropEvent(QDropEvent(QPointF(where), copy, data, _LEFT, _MODIFIERS[0]))
    return f"drop {name}"


def choose(window: Window, random: Random) -> str:
    """Choose an obstacle of the list, or none, or a kind in the form."""
    if front_dialog():
        return close(window, random)
    table, kinds = window.views.table, window.forms.obstacle.kind
    if random.random() < 0.4:
        kinds.setCurrentIndex(random.randrange(kinds.count()))
        return f"choose {kinds.currentText()}"
    row = random.randrange(-1, table.rowCount())
    table.selectRow(row) if row >= 0 else table.clearSelection()
    return f"choose row {row}"


def resize(window: Window, random: Random) -> str:
    """Give the window another size, or its halves."""
    if random.random() < 0.5:
        window.resize(random.randint(300, 1280), random.randint(200, 790))
    else:
        window.halves.setSizes([random.randint(0, 900), random.randint(0, 900)])
        window.views.setSizes([random.randint(0, 500), random.randint(0, 500)])
    return f"resize to {window.size().toTuple()}"


def wait(_: Window, random: Random) -> str:
    """Let the window work for a moment."""
    pause = random.choice([0, 1, 10, 30, 60])
    QTest.qWait(pause)
    return f"wait {pause} ms"


def close(window: Window, _random: Random) -> str:
    """Close what is in front: a dialog, or the window."""
    front = front_dialog() or window
    told = f"close {name_of(front)}"
    front.close()
    return told


ACTIONS: dict[str, tuple[Act, int]] = {
    "click": (click, 18),
    "press_button": (press_button, 10),
    "drag": (drag, 14),
    "type_text": (type_text, 10),
    "type_cell": (type_cell, 10),
    "key": (key, 14),
    "shortcut": (shortcut, 12),
    "change_history": (change_history, 6),
    "paste": (paste, 4),
    "scroll": (scroll, 5),
    "menu": (menu, 2),
    "drop": (drop, 3),
    "choose": (choose, 8),
    "resize": (resize, 2),
    "wait": (wait, 10),
    "close": (close, 1),
}
"""What each does, and how often it is chosen."""


def _typed(field: QWidget, random: Random) -> str:
    text = random.choice(FOLDERS if is_of_a_folder(field) else TEXTS)
    end = random.choice(_ENDS)
    told = f"type {text!r} into {name_of(field)}, {end.name if end else 'unfinished'}"
    field.setFocus()
    field.selectAll()  # type: ignore[attr-defined]  # both sorts have it
    _enter(field, text)
    if end and is_there(field):
        QTest.keyClick(field, end)
    return told


def _enter(field: QWidget, text: str) -> None:
    """Type a text letter by letter; paste one that is long, or that QTest has no keys for."""
    if len(text) > _TYPED or not all(" " <= letter <= "~" for letter in text):
        QApplication.clipboard().setText(text)
        QTest.keyClick(field, Qt.Key.Key_V, _CONTROL)
        return
    for letter in text:
        if is_there(field):
            QTest.keyClicks(field, letter)
