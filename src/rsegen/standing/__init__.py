"""Robots on a field: their bodies, poses at rest, and ways across.

body --settle--> at rest --surplus--> can it push itself on --drive--> lanes --Lattice--> reach, ways. A body is made
from collision shapes by rsegen.robots, above this room.
"""
