"""Maps of difficulty that rises evenly, in one folder: for learning step by step, and for trials in steps."""

from rsegen.series.plan import Plan
from rsegen.series.row import Row
from rsegen.series.run import Series, series

__all__ = ["Plan", "Row", "Series", "series"]
