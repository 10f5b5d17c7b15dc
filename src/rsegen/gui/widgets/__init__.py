"""The parts of the window: forms, the obstacle table, the plan and the 3D view; none of them knows the window."""
