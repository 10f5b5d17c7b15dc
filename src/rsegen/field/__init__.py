"""A map as integer levels in cells (`StepField`), the obstacles that shape it and its metrics."""
