"""Changes a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

The repeated part only lowers blocks, and a flat field meets every constraint, so it ends. If a largest step and an
inventory lead to fewer blocks than that, the blocks in stock are arranged anew. Blocks that are left then go wherever
all constraints are met with them.
"""
