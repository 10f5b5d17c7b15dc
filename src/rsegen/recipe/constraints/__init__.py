"""Constraints of a map: a largest step, a robot that can cross, the blocks in stock."""
