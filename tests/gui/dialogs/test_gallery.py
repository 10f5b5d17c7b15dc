"""The grid of pictures shows every map once, in the order of any metric."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtWidgets import QApplication, QComboBox, QListWidget

from rsegen import build, make_dataset, metrics
from rsegen.errors import FileError
from rsegen.gui.dialogs import gallery
from rsegen.gui.dialogs.gallery import DatasetDialog, GalleryDialog
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.recipe.codec import decode
from tests.support.clicking import click, find, said, shown
from tests.support.waiting import until

RECIPE = decode(
    {
        "seed": 3,
        "maps": 5,
        "first_map": 10,
        "difficulty": [0, 1],
        "obstacles": [{"kind": "random", "levels": 5}, {"kind": "peak", "levels": 5}],
    }
)


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.imported(RECIPE))
    with shown(window):
        yield window


def opened(window: Window) -> GalleryDialog:
    window.show_all_maps()
    (dialog,) = window.findChildren(GalleryDialog)
    return dialog


def texts(dialog: GalleryDialog) -> list[str]:
    """What is below the pictures, once all of them are there and sorted."""
    maps = find(dialog, QListWidget, "maps")
    until(lambda: dialog._bar.isHidden() and maps.count() == len(dialog._places))
    return [maps.item(number).text() for number in range(maps.count())]


def test_maps_are_shown_in_their_order_and_in_that_of_a_metric(window: Window) -> None:
    dialog = opened(window)
    assert texts(dialog) == [f"map {place}" for place in range(5)]
    find(dialog, QComboBox, "sort_by").setCurrentText("steps.rms")
    until(lambda: "\n" in texts(dialog)[0])
    rms = {place: metrics(build(RECIPE, 10 + place)).steps.rms or 0 for place in range(5)}
    order = sorted(rms, key=lambda place: rms[place])
    assert order != list(range(5))
    assert [int(text.split()[1]) for text in texts(dialog)] == order
    assert [float(text.split()[2]) for text in texts(dialog)] == pytest.approx(
        [rms[each] * 100 for each in order], abs=0.01
    )
    dialog.close()


def test_a_map_that_is_chosen_is_shown(window: Window) -> None:
    dialog = opened(window)
    texts(dialog)
    maps = find(dialog, QListWidget, "maps")
    maps.itemActivated.emit(maps.item(3))
    assert window.status.shown_index() == 13


def test_a_metric_without_a_value_is_last(window: Window) -> None:
    window.session.set("difficulty", 0)
    dialog = opened(window)
    find(dialog, QComboBox, "sort_by").setCurrentText("scale.hurst")
    until(lambda: all(text.endswith("\n-") for text in texts(dialog)))
    dialog.close()


def test_of_very_many_maps_some_are_shown(app: QApplication, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery, "MOST", 3)
    dialog = GalleryDialog("maps", 10**6, lambda place: (RECIPE, place))
    assert texts(dialog) == ["map 0", "map 333334", "map 666668"]
    dialog.close()


def test_an_error_that_ends_the_pictures_is_shown(app: QApplication) -> None:
    def broken(place: int) -> None:
        raise FileError("the disk is gone")

    dialog = GalleryDialog("maps", 3, broken)  # type: ignore[arg-type]  # fails before it gives anything
    dialog.show()
    until(lambda: said(dialog, "gallery_error") == "the disk is gone")
    dialog.close()


def test_the_maps_of_a_data_set_are_chosen_from_pictures(app: QApplication, tmp_path: Path) -> None:
    make_dataset(RECIPE, tmp_path / "set")
    dialog = DatasetDialog(tmp_path / "set")
    dialog.show()
    click(dialog, "all_maps")
    (all_maps,) = dialog.findChildren(GalleryDialog)
    texts(all_maps)
    maps = find(all_maps, QListWidget, "maps")
    maps.itemActivated.emit(maps.item(4))
    assert dialog._number.value() == 4
    dialog.reject()
