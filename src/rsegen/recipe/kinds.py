"""Several recipes whose maps go together, in a terrain or a data set: its kinds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rsegen.errors import ParameterError, shown
from rsegen.recipe.recipe import Recipe


def recipes_of(given: Recipe | Sequence[Recipe]) -> tuple[Recipe, ...]:
    """One recipe or several as a tuple; ParameterError if it is neither."""
    found = (given,) if isinstance(given, Recipe) else given
    if not isinstance(found, list | tuple) or not all(isinstance(one, Recipe) for one in found):
        raise ParameterError("recipes", f"{shown(given)} is not a recipe or a list of recipes")
    return tuple(found)


def refuse_unlike(recipes: Sequence[Recipe], names: Iterable[str]) -> None:
    """Raise a ParameterError for the first of these parameters in which a recipe differs from the first one."""
    for number, recipe in enumerate(recipes):
        for name in names:
            own, others = getattr(recipe, name), getattr(recipes[0], name)
            if own != others:
                problem = f"{shown(own)}, and {shown(others)} in the first recipe; give one for all"
                raise ParameterError(f"recipes[{number}].{name}", problem)


def kind_of_column(column: int, columns: int, kinds: int) -> int:
    """Which of the kinds a column has: each has as many neighbouring columns as the others, as far as that goes."""
    return column * kinds // columns
