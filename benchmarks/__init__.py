"""Measurements of what rsegen makes, each a command: `python -m benchmarks.NAME`."""
