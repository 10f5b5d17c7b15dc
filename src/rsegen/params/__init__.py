"""What a parameter may be, where an obstacle may lie, and what draws at random: the base of everything else.

`sorts` says which values a field takes, `places` the same for cells of a map, `registry` finds things by their names,
`streams` gives every obstacle of every map a random generator of its own.
"""
