"""Maps as pictures: previews, and the paths of a robot."""
