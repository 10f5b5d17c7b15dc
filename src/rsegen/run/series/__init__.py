"""Maps of evenly rising difficulty in one folder: for curriculum learning, and for trials of rising difficulty."""

from rsegen.run.series.plan import SeriesPlan
from rsegen.run.series.run import Series, series
from rsegen.run.series.table import SeriesRow

__all__ = ["Series", "SeriesPlan", "SeriesRow", "series"]
