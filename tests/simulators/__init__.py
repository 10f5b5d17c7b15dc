"""Simulators: found, planned and run, with stand-ins on PATH."""
