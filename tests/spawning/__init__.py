"""Tests of free places in a simulation, and of the heights of its maps."""
