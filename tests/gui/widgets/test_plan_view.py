"""The plan, pressed and dragged on by a real mouse and keyboard."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

if os.environ.get("CI") != "true":
    pytest.importorskip("PySide6.QtWidgets", reason="windows need PySide6", exc_type=ImportError)

from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QMouseEvent, QWheelEvent
from PySide6.QtTest import QSignalSpy, QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QVBoxLayout, QWidget

from rsegen import Random, Recipe, Scene, compose
from rsegen.errors import UserError
from rsegen.gui.model.obstacle_ends import Handle
from rsegen.gui.model.painting import UNPAINTED, Brush, Tool, connected
from rsegen.gui.model.plan_layout import fit
from rsegen.gui.widgets.plan_painting import plan_area
from rsegen.gui.widgets.plan_view import PlanView
from rsegen.params.sorts import Cell
from tests.support.waiting import until

LEFT = Qt.MouseButton.LeftButton
SVG = "{http://www.w3.org/2000/svg}"
RECIPE = Recipe(seed=1, chunk_size=5, chunks=(2, 2), obstacles=[Random(levels=5)])
HANDLES = (Handle(row=0), Handle(row=1, first=(1, 1), last=(6, 4)), Handle(row=2, first=(8, 8), last=(8, 2)))


@pytest.fixture
def scene() -> Scene:
    return compose(RECIPE)


@pytest.fixture
def plan(app: QApplication, scene: Scene) -> Iterator[PlanView]:
    widget = PlanView()
    widget.resize(500, 460)
    widget.show()
    widget.show(scene, HANDLES, 1)
    app.processEvents()
    yield widget
    widget.close()


def at(plan: PlanView, scene: Scene, block: Cell) -> QPoint:
    layout = fit(scene.field, plan_area(plan.width(), plan.height()), plan.devicePixelRatio())
    return QPoint(*map(round, layout.middle(block)))


def drag(plan: PlanView, scene: Scene, *blocks: Cell) -> None:
    points = [at(plan, scene, block) for block in blocks]
    QTest.mousePress(plan, LEFT, pos=points[0])
    for point in points[1:]:
        QTest.mouseMove(plan, point)
    QTest.mouseRelease(plan, LEFT, pos=points[-1])


def hover(plan: PlanView, point: QPoint) -> None:
    """Straight to the widget: other windows of earlier tests may lie over it."""
    none = Qt.MouseButton.NoButton
    where, above = QPointF(point), QPointF(plan.mapToGlobal(point))
    event = QMouseEvent(QEvent.Type.MouseMove, where, above, none, none, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(plan, event)


def said(spy: QSignalSpy) -> list[list[object]]:
    return [spy.at(number) for number in range(spy.count())]


def image(plan: PlanView) -> QImage:
    return plan.grab().toImage()


def test_a_dragged_handle_tells_every_cell_it_comes_to(plan: PlanView, scene: Scene) -> None:
    moved, drawn = QSignalSpy(plan.moved), QSignalSpy(plan.drawn)
    drag(plan, scene, (6, 4), (6, 5), (7, 5), (7, 5))
    assert said(moved) == [[1, "last", 6, 5], [1, "last", 7, 5]]
    assert drawn.count() == 0


def test_the_cross_of_the_selected_obstacle_moves_both_ends_and_stays_on_the_map(plan: PlanView, scene: Scene) -> None:
    moved, drawn = QSignalSpy(plan.moved), QSignalSpy(plan.drawn)
    drag(plan, scene, (3, 2), (4, 2), (4, 9))
    assert said(moved) == [[1, "both", 4, 2], [1, "both", 4, 7]]
    assert drawn.count() == 0
    plan.show_handles(HANDLES, None)
    drag(plan, scene, (3, 2), (4, 2))
    assert (moved.count(), drawn.count()) == (2, 1)


def test_a_handle_dragged_off_the_map_stays_at_its_rim(plan: PlanView) -> None:
    moved = QSignalSpy(plan.moved)
    QTest.mousePress(plan, LEFT, pos=at(plan, compose(RECIPE), (1, 1)))
    QTest.mouseMove(plan, QPoint(-300, -300))
    QTest.mouseRelease(plan, LEFT, pos=QPoint(-300, -300))
    assert said(moved) == [[1, "first", 0, 9]]


def test_dragging_over_empty_ground_draws_an_obstacle(plan: PlanView, scene: Scene) -> None:
    drawn, moved = QSignalSpy(plan.drawn), QSignalSpy(plan.moved)
    drag(plan, scene, (3, 8), (4, 8), (5, 6))
    assert said(drawn) == [[3, 8, 5, 6]]
    assert moved.count() == 0


def test_a_click_draws_nothing(plan: PlanView, scene: Scene) -> None:
    drawn = QSignalSpy(plan.drawn)
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (3, 8)))
    assert drawn.count() == 0


def test_escape_cancels_the_drawing(plan: PlanView, scene: Scene) -> None:
    drawn, before = QSignalSpy(plan.drawn), image(plan)
    QTest.mousePress(plan, LEFT, pos=at(plan, scene, (3, 8)))
    QTest.mouseMove(plan, at(plan, scene, (5, 6)))
    assert image(plan) != before
    QTest.keyClick(plan, Qt.Key.Key_Escape)
    QTest.mouseRelease(plan, LEFT, pos=at(plan, scene, (5, 6)))
    assert drawn.count() == 0
    assert image(plan) == before


def test_pressing_on_another_obstacles_handle_chooses_it(plan: PlanView, scene: Scene) -> None:
    chosen, moved = QSignalSpy(plan.chosen), QSignalSpy(plan.moved)
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (8, 2)))
    assert said(chosen) == [[2]]
    assert moved.count() == 0


def test_pressing_on_the_selected_obstacles_handle_chooses_nothing(plan: PlanView, scene: Scene) -> None:
    chosen = QSignalSpy(plan.chosen)
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (6, 4)))
    assert chosen.count() == 0


def test_if_both_ends_share_a_cell_the_last_of_the_selected_obstacle_is_taken(plan: PlanView, scene: Scene) -> None:
    plan.show(scene, (Handle(row=0, first=(4, 4), last=(4, 4)), Handle(row=1, first=(4, 4), last=(4, 4))), 1)
    moved = QSignalSpy(plan.moved)
    drag(plan, scene, (4, 4), (5, 4))
    assert said(moved) == [[1, "last", 5, 4]]


def test_arrow_keys_move_the_end_that_was_touched_last(plan: PlanView, scene: Scene) -> None:
    moved = QSignalSpy(plan.moved)
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (6, 4)))
    for key in (Qt.Key.Key_Up, Qt.Key.Key_Right, Qt.Key.Key_Down, Qt.Key.Key_Left):
        QTest.keyClick(plan, key)
    assert said(moved) == [[1, "last", 6, 5], [1, "last", 7, 5], [1, "last", 7, 4], [1, "last", 6, 4]]


def test_arrow_keys_stop_at_the_rim_and_say_nothing_there(plan: PlanView, scene: Scene) -> None:
    plan.show(scene, (Handle(row=3, first=(0, 0)),), 3)
    moved = QSignalSpy(plan.moved)
    QTest.keyClick(plan, Qt.Key.Key_Left)
    QTest.keyClick(plan, Qt.Key.Key_Right)
    assert said(moved) == [[3, "first", 1, 0]]


def test_tab_goes_to_the_other_end_and_a_second_one_leaves(app: QApplication, scene: Scene) -> None:
    window, plan, beside = QWidget(), PlanView(), QLineEdit()
    column = QVBoxLayout(window)
    column.addWidget(plan)
    column.addWidget(beside)
    plan.show(scene, HANDLES, 1)
    window.show()
    window.activateWindow()
    plan.setFocus()
    app.processEvents()
    moved = QSignalSpy(plan.moved)
    for key in (Qt.Key.Key_Up, Qt.Key.Key_Tab, Qt.Key.Key_Up, Qt.Key.Key_Tab, Qt.Key.Key_Up):
        QTest.keyClick(plan, key)
    assert said(moved) == [[1, "first", 1, 2], [1, "last", 6, 5], [1, "first", 1, 3]]
    QTest.keyClick(plan, Qt.Key.Key_Tab)
    QTest.keyClick(plan, Qt.Key.Key_Tab)
    assert beside.hasFocus()
    window.close()


def test_the_cell_under_the_cursor_is_shown(plan: PlanView, scene: Scene) -> None:
    hovered = QSignalSpy(plan.hovered)
    level = int(scene.field.blocks[3, 2])
    hover(plan, at(plan, scene, (3, 2)))
    assert [f"block 3, 2: level {level}, {level * 10} cm"] in said(hovered)
    first, second = at(plan, scene, (0, 0)), at(plan, scene, (1, 0))
    hover(plan, first - QPoint(second.x() - first.x(), 0))
    assert ["frame: 10 cm"] in said(hovered)
    QTest.mouseMove(plan, QPoint(1, 1))
    assert said(hovered)[-1] == [""]


def test_a_plan_shows_every_level_and_the_frames(plan: PlanView, scene: Scene) -> None:
    plan.show(scene, (), None)
    found = image(plan)
    seen = {found.pixelColor(x, y).rgb() for x in range(0, found.width(), 2) for y in range(0, found.height(), 2)}
    for material in range(5):
        assert QColor(*(round(part * 255) for part in scene.colour(material))).rgb() in seen


def test_north_is_up_on_the_screen(plan: PlanView, scene: Scene) -> None:
    plan.show(scene, (), None)
    found = image(plan)
    for block in ((0, 0), (0, 9), (9, 0), (4, 7)):
        level = int(scene.field.blocks[block])
        if level:
            corner = at(plan, scene, block) - QPoint(8, 8)
            expected = QColor(*(round(part * 255) for part in scene.colour(level)))
            assert found.pixelColor(corner * found.devicePixelRatio()).rgb() == expected.rgb()


def test_the_ends_can_be_seen(plan: PlanView, scene: Scene) -> None:
    with_ends = image(plan)
    plan.show(scene, (), None)
    assert image(plan) != with_ends


@pytest.mark.parametrize("recipe", [replace(RECIPE, chunk_size=1, chunks=(1, 1)), replace(RECIPE, chunk_size=300)])
def test_the_smallest_and_large_maps_can_be_drawn(plan: PlanView, recipe: Recipe) -> None:
    plan.show(compose(recipe), HANDLES[:1], None)
    assert not image(plan).isNull()


def test_without_a_scene_nothing_happens(app: QApplication) -> None:
    bare = PlanView()
    bare.resize(200, 200)
    QTest.mouseClick(bare, LEFT, pos=QPoint(100, 100))
    QTest.keyClick(bare, Qt.Key.Key_Left)
    assert not image(bare).isNull()


def test_the_plan_introduces_itself(plan: PlanView) -> None:
    assert plan.accessibleName() == "Plan of the map"
    assert "Arrow keys" in plan.accessibleDescription()


def test_a_brush_paints_every_cell_it_comes_over_and_its_right_button_takes_paint_off(
    plan: PlanView, scene: Scene
) -> None:
    painted, moved = QSignalSpy(plan.painted), QSignalSpy(plan.moved)
    plan.set_brush(Brush(Tool.CELLS, 3))
    drag(plan, scene, (1, 1), (4, 1), (4, 2))
    assert said(painted) == [
        [((1, 1),), 3, 1],
        [((1, 1), (2, 1), (3, 1), (4, 1)), 3, 1],
        [((4, 1), (4, 2)), 3, 1],
    ]
    QTest.mouseClick(plan, Qt.MouseButton.RightButton, pos=at(plan, scene, (6, 4)))
    assert said(painted)[-1] == [((6, 4),), UNPAINTED, 2]
    assert moved.count() == 0


def test_levels_are_typed_into_cells_in_reading_order(plan: PlanView, scene: Scene) -> None:
    painted = QSignalSpy(plan.painted)
    plan.set_brush(Brush(Tool.CELLS, 7))
    plan.setFocus()
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (8, 5)))
    QTest.keyClick(plan, Qt.Key.Key_Up)
    for key in (Qt.Key.Key_4, Qt.Key.Key_0, Qt.Key.Key_2, Qt.Key.Key_Space, Qt.Key.Key_Backspace):
        QTest.keyClick(plan, key)
    assert [(row[0], row[1]) for row in said(painted)[1:]] == [
        (((8, 6),), 4),
        (((9, 6),), 0),
        (((0, 5),), 2),
        (((1, 5),), 7),
        (((1, 5),), UNPAINTED),
    ]


def wheel(plan: PlanView, point: QPoint, turns: int) -> None:
    where, none = QPointF(point), Qt.MouseButton.NoButton
    delta, keys = QPoint(0, 120 * turns), Qt.KeyboardModifier.NoModifier
    phase, inverted = Qt.ScrollPhase.NoScrollPhase, False
    QApplication.sendEvent(
        plan, QWheelEvent(where, plan.mapToGlobal(where), QPoint(), delta, none, keys, phase, inverted)
    )


def now(plan: PlanView, block: Cell) -> QPoint:
    """Where a block is at the present zoom."""
    assert plan.plan_layout
    return QPoint(*map(round, plan.plan_layout.middle(block)))


def test_the_wheel_zooms_at_the_cursor_and_handles_are_dragged_there(plan: PlanView, scene: Scene) -> None:
    moved, before = QSignalSpy(plan.moved), plan.plan_layout
    wheel(plan, at(plan, scene, (6, 4)), 4)
    assert plan.plan_layout
    assert plan.plan_layout.side > 1.9 * fit(scene.field, plan_area(plan.width(), plan.height())).side
    assert (now(plan, (6, 4)) - at(plan, scene, (6, 4))).manhattanLength() <= 2
    QTest.mousePress(plan, LEFT, pos=now(plan, (6, 4)))
    QTest.mouseMove(plan, now(plan, (6, 5)))
    QTest.mouseRelease(plan, LEFT, pos=now(plan, (6, 5)))
    assert said(moved) == [[1, "last", 6, 5]]
    wheel(plan, now(plan, (6, 4)), -9)
    assert plan.plan_layout == before


def test_keys_zoom_and_a_double_click_where_no_handle_is_shows_the_whole_map(plan: PlanView) -> None:
    whole = plan.plan_layout
    QTest.keyClick(plan, Qt.Key.Key_Plus)
    QTest.keyClick(plan, Qt.Key.Key_Plus)
    assert plan.plan_layout
    assert whole
    assert plan.plan_layout.side == pytest.approx(whole.side * 1.25**2)
    QTest.keyClick(plan, Qt.Key.Key_Minus)
    assert plan.plan_layout.side == pytest.approx(whole.side * 1.25)
    plan.zoom(0.9)
    QTest.mouseDClick(plan, LEFT, pos=now(plan, (6, 4)))
    assert plan.plan_layout != whole
    QTest.mouseDClick(plan, LEFT, pos=now(plan, (4, 7)))
    assert plan.plan_layout == whole


def test_a_double_click_paints_while_cells_are_painted(plan: PlanView, scene: Scene) -> None:
    painted = QSignalSpy(plan.painted)
    plan.set_brush(Brush(Tool.CELLS, 3))
    plan.zoom(2)
    zoomed = plan.plan_layout
    QTest.mouseDClick(plan, LEFT, pos=now(plan, (4, 5)))
    assert painted.count() > 0
    assert plan.plan_layout == zoomed


def test_space_that_is_pressed_during_a_drag_does_not_end_it(plan: PlanView, scene: Scene) -> None:
    drawn = QSignalSpy(plan.drawn)
    QTest.mousePress(plan, LEFT, pos=at(plan, scene, (3, 8)))
    QTest.mouseMove(plan, at(plan, scene, (5, 6)))
    QTest.keyPress(plan, Qt.Key.Key_Space)
    QTest.mouseRelease(plan, LEFT, pos=at(plan, scene, (5, 6)))
    QTest.keyRelease(plan, Qt.Key.Key_Space)
    assert said(drawn) == [[3, 8, 5, 6]]


@pytest.mark.parametrize("button", [Qt.MouseButton.MiddleButton, LEFT])
def test_the_middle_button_and_space_move_the_plan_and_nothing_else(plan: PlanView, button: Qt.MouseButton) -> None:
    spies = [QSignalSpy(signal) for signal in (plan.moved, plan.drawn, plan.chosen, plan.painted)]
    plan.set_brush(Brush(Tool.CELLS, 3))
    plan.setFocus()
    plan.zoom(3)
    start = now(plan, (5, 5))
    if button == LEFT:
        QTest.keyPress(plan, Qt.Key.Key_Space)
    QTest.mousePress(plan, button, pos=start)
    drag_to(plan, start + QPoint(17, -9), button)
    QTest.mouseRelease(plan, button, pos=start + QPoint(17, -9))
    QTest.keyRelease(plan, Qt.Key.Key_Space)
    assert now(plan, (5, 5)) == start + QPoint(17, -9)
    assert [spy.count() for spy in spies] == [0, 0, 0, 0]


def drag_to(plan: PlanView, point: QPoint, button: Qt.MouseButton) -> None:
    where, above = QPointF(point), QPointF(plan.mapToGlobal(point))
    none = Qt.MouseButton.NoButton
    event = QMouseEvent(QEvent.Type.MouseMove, where, above, none, button, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(plan, event)


def test_a_drag_beyond_the_edge_moves_the_plan_along(plan: PlanView) -> None:
    moved = QSignalSpy(plan.moved)
    plan.zoom(3, (now(plan, (6, 4)).x(), now(plan, (6, 4)).y()))
    QTest.mousePress(plan, LEFT, pos=now(plan, (6, 4)))
    drag_to(plan, QPoint(plan.width() - 1, now(plan, (6, 4)).y()), LEFT)
    until(lambda: moved.count() > 0 and said(moved)[-1][2] == 9)
    QTest.mouseRelease(plan, LEFT, pos=QPoint(plan.width() - 1, 100))
    assert not plan._scroll.isActive()


def test_the_plan_stays_close_by_when_the_map_changes_or_the_widget_is_resized(plan: PlanView, scene: Scene) -> None:
    plan.zoom(2)
    assert plan.plan_layout
    side = plan.plan_layout.side
    plan.show(compose(replace(RECIPE, seed=2)), HANDLES, 1)
    assert plan.plan_layout.side == side
    plan.resize(520, 400)
    assert plan.plan_layout.side == side
    plan.fit()
    plan.resize(300, 300)
    assert plan.plan_layout == fit(scene.field, plan_area(300, 300), plan.devicePixelRatio())
    plan.zoom(2)
    plan.show(compose(replace(RECIPE, chunk_size=4)), (), None)
    assert plan.plan_layout == fit(
        compose(replace(RECIPE, chunk_size=4)).field, plan_area(plan.width(), plan.height()), plan.devicePixelRatio()
    )


def test_the_label_under_a_resting_cursor_is_never_stale(plan: PlanView, scene: Scene) -> None:
    hover(plan, at(plan, scene, (3, 2)))
    hovered = QSignalSpy(plan.hovered)
    other = next(each for seed in range(2, 9) if differs(each := compose(replace(RECIPE, seed=seed)), scene))
    plan.show(other, HANDLES, 1)
    level = int(other.field.blocks[3, 2])
    assert said(hovered) == [[f"block 3, 2: level {level}, {level * 10} cm"]]
    assert plan.toolTip() == said(hovered)[0][0]


def differs(one: Scene, other: Scene) -> bool:
    return bool(one.field.blocks[3, 2] != other.field.blocks[3, 2])


def test_a_box_and_a_filling_are_one_stroke_each(plan: PlanView, scene: Scene) -> None:
    painted = QSignalSpy(plan.painted)
    plan.set_brush(Brush(Tool.RECTANGLE, 3))
    before = image(plan)
    QTest.mousePress(plan, LEFT, pos=at(plan, scene, (1, 1)))
    QTest.mouseMove(plan, at(plan, scene, (2, 3)))
    assert painted.count() == 0
    assert image(plan) != before
    QTest.mouseRelease(plan, LEFT, pos=at(plan, scene, (2, 3)))
    assert said(painted) == [[((1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)), 3, 1]]
    plan.set_brush(Brush(Tool.FILL, 2))
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (4, 4)))
    assert said(painted)[1] == [connected(scene.field.blocks, (4, 4)), 2, 2]


def test_a_level_is_picked_from_the_plan(plan: PlanView, scene: Scene) -> None:
    picked, painted = QSignalSpy(plan.picked), QSignalSpy(plan.painted)
    plan.set_brush(Brush(Tool.PICK, 2))
    QTest.mouseClick(plan, LEFT, pos=at(plan, scene, (7, 3)))
    assert said(picked) == [[int(scene.field.blocks[7, 3])]]
    assert painted.count() == 0


def test_many_frames_do_not_drown_the_heights(app: QApplication) -> None:
    bare, framed = (
        compose(replace(RECIPE, chunk_size=10, chunks=(40, 40), boundary=boundary)) for boundary in ("none", "divided")
    )
    plan, means = PlanView(), []
    plan.resize(330, 330)
    for each in (bare, framed):
        plan.show(each)
        found = image(plan).convertToFormat(QImage.Format.Format_RGB888).copy(80, 80, 150, 150)
        means.append(np.frombuffer(found.constBits(), np.uint8).reshape(150, -1)[:, :450].reshape(-1, 3).mean(axis=0))
    assert np.abs(means[0] - means[1]).max() < 30


@pytest.mark.parametrize(("suffix", "start"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_the_plan_is_saved_with_rulers_and_heights(plan: PlanView, tmp_path: Path, suffix: str, start: bytes) -> None:
    plan.zoom(3)
    plan.save(tmp_path / f"plan.{suffix}")
    content = (tmp_path / f"plan.{suffix}").read_bytes()
    assert content.startswith(start)
    if suffix == "svg":
        texts = ["".join(each.itertext()).strip() for each in ElementTree.fromstring(content).iter(f"{SVG}text")]
        heights = (compose(RECIPE).field.blocks * 10).ravel().tolist()
        assert sorted(texts) == sorted([*map(str, heights), *map(str, range(10)), *map(str, range(0, 10, 2))])
    if suffix == "png":
        assert QImage(str(tmp_path / "plan.png")).width() > 1000


def test_a_plan_of_another_suffix_or_in_no_folder_is_refused(plan: PlanView, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"unknown suffix of a plan '.bmp' \(known: .pdf, .png, .svg\)"):
        plan.save(tmp_path / "plan.bmp")
    with pytest.raises(UserError, match="No such file or directory"):
        plan.save(tmp_path / "nowhere" / "plan.svg")
    assert list(tmp_path.iterdir()) == []


def test_frames_take_no_paint_and_a_brush_laid_down_paints_nothing(plan: PlanView, scene: Scene) -> None:
    painted, drawn = QSignalSpy(plan.painted), QSignalSpy(plan.drawn)
    plan.set_brush(Brush(Tool.CELLS, 3))
    first, second = at(plan, scene, (4, 0)), at(plan, scene, (5, 0))
    QTest.mouseClick(plan, LEFT, pos=QPoint((first.x() + second.x()) // 2, first.y()))
    assert painted.count() == 0
    plan.set_brush(None)
    drag(plan, scene, (3, 8), (5, 8))
    assert (painted.count(), drawn.count()) == (0, 1)
