"""Ways to build a step field for collision, ranked in a real Gazebo Classic by their cost and what robots meet."""
