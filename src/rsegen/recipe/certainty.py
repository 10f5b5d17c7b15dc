"""A robot that is to cross so surely, as in `crossable_by: crawler:0.9`, of a recipe's file or flags.

    crossable_by: crawler:0.9 --drives--> crossable_by: crawler, crossable_room: 0.4

Lanes are lowered by poses, which have no probability; drives have one, but maps are not to depend on a simulator and
its version. So drives decide once how much room to spare the lanes need, and a recipe has that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rsegen.errors import ParameterError, inside
from rsegen.params.capabilities import hooks
from rsegen.params.sorts import Float
from rsegen.recipe.recipe import Recipe

CERTAINTY = Float(0.5, 0.95, help="probability with which a robot gets across the maps of a recipe")
"""Above 0.95 no number of drives within seconds tells two probabilities apart; below 0.5 a map is not for the robot."""


def answered(make: Callable[[Any], Recipe], content: Any) -> Recipe:
    """Return the recipe that `make` makes of a content; if it asks for a certainty, with the room that this takes."""
    asked = content.get("crossable_by") if isinstance(content, Mapping) else None
    robot, colon, share = asked.partition(":") if isinstance(asked, str) else ("", "", "")
    if not colon:
        return make(content)
    with inside("crossable_by"):
        certainty = CERTAINTY.check("", CERTAINTY.parse(share))
    if "crossable_room" in content:
        raise ParameterError("crossable_room", f"cannot be set together with {asked}, which finds it")
    recipe = make({**content, "crossable_by": robot})
    for with_certainty in hooks("certainty"):
        found: Recipe = with_certainty(recipe, certainty)
        return found
    raise ParameterError("crossable_by", f"{asked}: a certainty takes drives, and nothing that drives is installed")
