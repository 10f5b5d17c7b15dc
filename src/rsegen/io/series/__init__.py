"""Maps of difficulty that rises evenly, in one folder: for learning step by step, and for trials in steps."""

from rsegen.io.series.plan import SeriesPlan
from rsegen.io.series.run import Series, series
from rsegen.io.series.table import SeriesRow

__all__ = ["Series", "SeriesPlan", "SeriesRow", "series"]
