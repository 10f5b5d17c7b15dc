"""Robots driven over maps in a simulator: start poses, routes, trajectories and metrics.

robot_runs(field, ...) -> runs; record_drive(installation, world, runs) -> recording;
drive_metrics(trajectory) -> metrics.
"""
