"""The room to spare that lanes need so that a robot crosses the maps of a recipe with a certainty.

    room to spare   0    0.2   0.4   0.6   0.8   1    2        the least that is sure enough, by bisection
    lanes           rough, crossed by chance .. even, level

For each room the maps are made, and the probability that the robot crosses them both ways is predicted (prediction.py);
the mean over the maps counts, for the worse of the two ways. Cost: two or three rooms, each a dozen seconds a map. What
breaks it: maps that are not crossed more surely with more room, for which the room found may not be the least.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rsegen.driving.planning import predictions, required_simulator
from rsegen.errors import ParameterError, refuse_other
from rsegen.params.watch import report_share
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import CERTAINTY
from rsegen.robots.lookup import robot_of_kind
from rsegen.scene.scene import compose

ROOMS: Sequence[float] = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 2.0)
"""Room to spare, as a share of the usual room: so far apart that maps differ; with 2 lanes are level."""

_MAPS = 8
"""Maps of a recipe that are driven, the first ones: they tell a mean within 0.1, in some minutes."""

_BAR = "a room to spare"
"""Label of the progress bar."""


def with_certainty(recipe: Recipe, certainty: float) -> Recipe:
    """Find how much room to spare lanes need so that a robot crosses the maps of a recipe as surely as asked.

    It is found by drives in MuJoCo; the maps of the returned recipe depend on its numbers alone. The same as
    `crossable_by: crawler:0.9` in a recipe file. Drives use all cores, so a script needs `if __name__ == "__main__":`.

    Parameters
    ----------
    recipe : Recipe
        The maps, with a robot in `crossable_by`.
    certainty : float
        The probability of crossing, 0.5..0.95, as the mean over the maps (the first eight of many), of the worse of
        the ways from west to east and from south to north.

    Returns
    -------
    Recipe
        The recipe with the least `crossable_room` with which the robot crosses so surely.

    Raises
    ------
    ParameterError
        If no room is enough, or the recipe names no robot.
    NoSimulator
        If MuJoCo is not installed.
    """
    refuse_other("recipe", recipe, Recipe)
    if not isinstance(recipe.crossable_by, str):
        raise ParameterError("crossable_by", "has no robot of which a certainty could be asked")
    CERTAINTY.check("certainty", certainty)
    required_simulator("a certainty of crossing needs")
    low, high, best = 0, len(ROOMS), 0.0  # below low none is sure enough, from high on all are
    while low < high:
        middle, done = (low + high) // 2, 1 - (high - low) / len(ROOMS)
        share = _certainty(replace(recipe, crossable_room=ROOMS[middle]), certainty, done)
        best = max(best, share)
        low, high = (low, middle) if share >= certainty else (middle + 1, high)
    report_share(_BAR, 1)
    if high == len(ROOMS):
        problem = f"the {recipe.crossable_by} crosses even level lanes of these maps with {best:.2f} at most"
        raise ParameterError("crossable_by", f"{problem}; ask for less, or use lower frames")
    return replace(recipe, crossable_room=ROOMS[high])


def _certainty(recipe: Recipe, asked: float, done: float) -> float:
    """Return the probability of crossing the first maps of a recipe; an upper bound once it is below `asked`.

    done: the share of the rooms that is already decided; these drives decide half of the others
    """
    robot, indices = robot_of_kind(str(recipe.crossable_by)), recipe.indices[:_MAPS]
    missed = {"west_east": 0.0, "south_north": 0.0}  # sums of the probabilities of not crossing
    for position, index in enumerate(indices):
        report_share(_BAR, done + (1 - done) / 2 * position / len(indices))
        predicted = predictions(robot, compose(recipe, index))
        for side in missed:
            missed[side] += 1 - predicted[side].probability if side in predicted else 1.0
        # Even if all other maps were crossed for sure, the mean could not become what is asked.
        if max(missed.values()) > (1 - asked) * len(indices):
            break
    return 1 - max(missed.values()) / len(indices)
