"""Looks at scenes on a real display and keeps pictures: `python viewed.py FOLDER` prints what it found as JSON."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from rsegen import Random, Recipe, compose
from rsegen.errors import FileError
from rsegen.gui.model.simulation import reach, robot_shape
from rsegen.gui.widgets.field_view import FieldView
from rsegen.gui.widgets.opengl import unavailable
from rsegen.gui.widgets.view_camera import Side

RECIPE = Recipe(seed=1, chunk_size=6, obstacles=[Random(levels=5)])
LARGE = replace(RECIPE, chunk_size=40, boundary="none")
WINDOW = (slice(1, 4), slice(2, 6))


def main(folder: Path) -> None:
    app = QApplication([])
    found: dict[str, object] = {"unavailable": unavailable()}
    view = FieldView()
    view.resize(640, 480)
    view.show(compose(RECIPE))
    view.show()
    app.processEvents()
    view.save_picture(folder / "plain.png")
    if not found["unavailable"]:
        found |= looked(app, view, folder)
    view.close()
    print(json.dumps(found))  # noqa: T201


def looked(app: QApplication, view: FieldView, folder: Path) -> dict[str, object]:
    """Pictures of everything that a view shows, and what cannot be seen in them."""
    view.show(compose(RECIPE), WINDOW)
    view.save_picture(folder / "highlighted.png")
    view.show(compose(replace(RECIPE, boundary="none", obstacles=())))
    view.save_picture(folder / "flat.png")
    view.show(compose(replace(LARGE, chunk_size=900)), WINDOW)
    view.save_picture(folder / "coarse.png")
    view.show(compose(LARGE))
    view.save_picture(folder / "large.png")
    camera = view._plotter.camera
    before, focus = camera.position, camera.focal_point
    dragged(view)
    turned = camera.position != before and camera.focal_point == focus and tuple(camera.up) == (0.0, 0.0, 1.0)
    view.save_picture(folder / "before-robot.png")
    view.show_robot(robot_shape("jackal"))
    view.save_picture(folder / "robot.png")
    view.show_robot(None)
    view.save_picture(folder / "no-robot.png")
    view.save_picture(folder / "before-reach.png")
    view.show(compose(replace(LARGE, unit_cm=1)))
    view.show_reach(reach(compose(replace(LARGE, unit_cm=1)).field, "crawler", 1))
    view.save_picture(folder / "reach.png")
    view.save_picture(folder / "reach-saved.png", view.pixels)
    view.show_reach(None)
    view.show(compose(LARGE))
    view.save_picture(folder / "no-reach.png")
    clicks = clicked(view)
    found_by_keys, (sides, scales) = keyed(view), seen_from_sides(view, folder)
    camera.position = (9.0, 9.0, 9.0)
    view.show(compose(replace(LARGE, seed=9)))
    kept = tuple(camera.position) == (9.0, 9.0, 9.0)
    view.look_along((1.0, -2.0, 1.5))
    direction = np.array(view.direction)
    along = bool(np.allclose(direction / direction[0], (1.0, -2.0, 1.5)))
    view.look_from(Side.PERSPECTIVE)
    dark = QPalette()
    dark.setColor(QPalette.ColorRole.Base, QColor(20, 20, 20))
    dark.setColor(QPalette.ColorRole.Text, QColor(230, 230, 230))
    app.setPalette(dark)
    app.processEvents()
    view.show(compose(RECIPE))
    view.save_picture(folder / "dark.png")
    return {
        "turned": turned,
        "along": along,
        "keys": found_by_keys,
        "camera kept": kept,
        "clicks": clicks,
        "sides": sides,
        "metres per pixel": scales,
        "picture": saved(view, folder / "wide.png"),
        "camera reset": tuple(camera.position) != (9.0, 9.0, 9.0),
        "refused": refused(view, folder / "nowhere" / "x.png"),
    }


def dragged(view: FieldView) -> None:
    """The left button pressed on the view, and the mouse moved."""
    plotter, left = view._plotter, Qt.MouseButton.LeftButton
    QTest.mousePress(plotter, left, pos=QPoint(200, 200))
    for x in (220, 240):
        QTest.mouseMove(plotter, QPoint(x, 210))
        QTest.qWait(20)
    QTest.mouseRelease(plotter, left, pos=QPoint(240, 210))


def clicked(view: FieldView) -> list[object]:
    """The cells of clicks in the middle from above and beside the map; a drag and the right button give none."""
    cells: list[object] = []
    view.clicked.connect(cells.append)
    view.look_from(Side.TOP)
    view._plotter.render_window.Render()
    middle = view._plotter.rect().center()
    for point in (middle + QPoint(3, 3), QPoint(5, 5)):
        QTest.mouseClick(view._plotter, Qt.MouseButton.LeftButton, pos=point)
    QTest.mouseClick(view._plotter, Qt.MouseButton.RightButton, pos=middle)
    dragged(view)
    return cells


def saved(view: FieldView, path: Path) -> tuple[float, float]:
    """How long a pixel of the view is, and one of a picture that is twice as large; the picture is kept."""
    view.save_picture(path, view.pixels * 2)
    return view.width() * view.devicePixelRatioF(), view.height() * view.devicePixelRatioF()


def keyed(view: FieldView) -> dict[str, list[float]]:
    """Where the camera stands after each key: degrees round, degrees up, metres away."""
    keys = {"": 0, "left": Qt.Key.Key_Left, "up": Qt.Key.Key_Up, "plus": Qt.Key.Key_Plus, "minus": Qt.Key.Key_Minus}
    keys |= {"right": Qt.Key.Key_Right, "down": Qt.Key.Key_Down}
    view.look_from(Side.PERSPECTIVE)
    found = {}
    for name, key in keys.items():
        if key:
            QTest.keyClick(view, Qt.Key(key))
        x, y, z = np.subtract(view._plotter.camera.position, view._plotter.camera.focal_point)
        found[name] = [float(np.degrees(np.arctan2(y, x))), float(np.degrees(np.arctan2(z, np.hypot(x, y))))]
        found[name].append(float(np.linalg.norm((x, y, z))))
    for _ in range(20):
        QTest.keyClick(view, Qt.Key.Key_Up)
    found["top"] = [float(value) for value in view._plotter.camera.up]
    QTest.keyClick(view, Qt.Key.Key_0)
    return found


def seen_from_sides(view: FieldView, folder: Path) -> tuple[list[list[float]], list[float]]:
    """The direction to the camera, and how long a pixel is, after the key of each side, and of 2 after a turn."""
    directions, scales = [], list[float]()
    view.setFocus()
    for key in (Qt.Key.Key_1, Qt.Key.Key_2, Qt.Key.Key_3, Qt.Key.Key_Left, Qt.Key.Key_2, Qt.Key.Key_Plus):
        QTest.keyClick(view, key)
        camera = view._plotter.camera
        away = np.subtract(camera.position, camera.focal_point)
        directions.append([*np.round(away / np.linalg.norm(away), 6).tolist(), camera.GetParallelProjection()])
        view.save_picture(folder / f"side-{len(scales)}.png")
        assert view._actors
        scales.append(view._actors.camera.metres_per_pixel())
    dragged(view)
    directions.append([view._plotter.camera.GetParallelProjection(), *view._plotter.camera.up])
    return directions, scales


def refused(view: FieldView, path: Path) -> str:
    """What is said of a path that cannot be written to."""
    try:
        view.save_picture(path)
    except FileError as error:
        return str(error)
    return ""


if __name__ == "__main__":
    main(Path(sys.argv[1]))
