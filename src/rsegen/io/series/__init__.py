"""Maps of difficulty that rises evenly, in one folder: for learning step by step, and for trials in steps."""

from rsegen.io.series.plan import Plan
from rsegen.io.series.row import Row
from rsegen.io.series.run import Series, series

__all__ = ["Plan", "Row", "Series", "series"]
