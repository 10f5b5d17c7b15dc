"""Ways from a grid of levels to a file; each file imports its own library, so a child loads no other's."""
