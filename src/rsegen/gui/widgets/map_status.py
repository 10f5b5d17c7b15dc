"""The status bar: which map is shown, its levels, size and costs, and whether a robot can cross it."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QLabel, QStatusBar

from rsegen.gui.model.map_numbers import Costs
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.simulation import robot_names
from rsegen.gui.widgets.level_bar import LevelBar
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.number_boxes import IntegerBox
from rsegen.recipe.recipe import Recipe

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
            "across (dashed: too steep), S and G are even places for a start and a goal",
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
