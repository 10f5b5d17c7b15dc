"""What pages draw of a map."""

from __future__ import annotations

from typing import Any

from rsegen.exporters.browser.page import ShownMap, content
from rsegen.exporters.scene import compose
from rsegen.gui.model.preview import costs
from rsegen.page.calls import call
from rsegen.page.host import Opened


@call
def scene(opened: Opened, *, index: int | None = None) -> dict[str, Any]:
    """Return a map of a document as it is drawn."""
    document = opened.document
    recipe = document.session.recipe
    made = compose(recipe, recipe.first_map if index is None else index)
    handles = [
        {"row": each.row, "first": each.first, "last": each.last} for each in document.handles(recipe.grid.shape)
    ]
    cost = costs(made)
    return content(ShownMap.of(made, "", ".yaml")) | {
        "revision": opened.revision,
        "index": made.index,
        "handles": handles,
        "warnings": list(cost.warnings),
        "cost": cost.text,
    }
