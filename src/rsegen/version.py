"""The version of rsegen."""

__version__ = "0.1.0"
