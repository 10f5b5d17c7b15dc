"""Ways to build a step field for collision, ranked in a real Gazebo Classic by what is felt on them and their cost."""
