"""What is put into a running simulation: where there is room, and what becomes of whatever stands there.

free(half, taken) -> place; put(live, ...); replaced(live, old, new).
"""
