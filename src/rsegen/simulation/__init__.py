"""Robots and simulators: worlds opened, maps spawned, robots driven and measured."""
