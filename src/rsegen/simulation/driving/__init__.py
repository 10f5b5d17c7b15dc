"""Robots driven over maps in a simulator: where they start, how they go, and what comes of it.

crew(scene, ...) -> drivers; driven(installation, world, drivers) -> tracks; measured(track) -> Trip.
"""
