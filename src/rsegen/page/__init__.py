"""The page: a server on this machine, and what it lets a browser do with recipes, maps, robots and commands."""
