"""How a robot stands on a field, and how it gets across: a body, at rest, along ways.

body --settle--> at rest --surplus--> can it push itself on --drive--> lanes --Lattice--> reach, ways. A body is made
from collision shapes by rsegen.robots, above this room.
"""
