"""Ways to build a step field for collision, ranked in a real Gazebo Classic by what robots meet on them and their cost."""
