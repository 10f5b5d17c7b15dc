"""Maps and robots spawned in a running simulation: free places, and what happens to the models that are there.

free_area(half_x, half_y, taken) -> place; spawn_map(live, sdf, new, old) -> names of the models put on top.
"""
