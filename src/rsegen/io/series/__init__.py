"""Maps of evenly rising difficulty in one folder: for curriculum learning, and for trials of rising difficulty."""

from rsegen.io.series.plan import SeriesPlan
from rsegen.io.series.run import Series, series
from rsegen.io.series.table import SeriesRow

__all__ = ["Series", "SeriesPlan", "SeriesRow", "series"]
