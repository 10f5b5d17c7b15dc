"""The legend and the scale bar as pictures."""

from __future__ import annotations

import os

import pytest

if os.environ.get("CI") != "true":
    pytest.importorskip("PySide6.QtWidgets", reason="windows need PySide6", exc_type=ImportError)

from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import QApplication

from rsegen.gui.widgets.view_camera import Inks, legend_image, scale_bar_image

INKS = Inks(QColor("white"), QColor("black"))
ROWS = [((number * 9, 100, 50), f"{number} cm") for number in range(25, 0, -1)]


def colours(image: QImage) -> set[int]:
    found = {image.pixelColor(x, y).rgb() for x in range(image.width()) for y in range(image.height())}
    return {number for number in range(1, 26) if QColor(number * 9, 100, 50).rgb() in found}


@pytest.mark.parametrize("scale", [1.0, 1.5, 4.0])
def test_a_legend_has_every_row_if_they_fit(app: QApplication, scale: float) -> None:
    assert colours(legend_image(ROWS, "", 1000, INKS, scale)) == set(range(1, 26))


@pytest.mark.parametrize("height", [60, 100, 200, 300])
def test_a_legend_is_no_higher_than_its_room_and_has_the_first_and_the_last_row(app: QApplication, height: int) -> None:
    image = legend_image(ROWS, "", height, INKS, 1)
    assert image.height() <= height
    assert {1, 25} <= colours(image)


def test_a_note_makes_the_legend_higher(app: QApplication) -> None:
    assert legend_image(ROWS, "two\nlines", 1000, INKS, 1).height() > legend_image(ROWS, "", 1000, INKS, 1).height()


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_a_scale_bar_is_as_long_as_wanted(app: QApplication, scale: float) -> None:
    image = scale_bar_image("50 cm", 120, INKS, scale)
    black = [sum(image.pixelColor(x, y).lightness() < 60 for x in range(image.width())) for y in range(image.height())]
    assert max(black) == pytest.approx(120 * scale, abs=3 * scale)
