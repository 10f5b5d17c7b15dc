"""Where there is room in a simulation, and how high a map is that stands there."""
