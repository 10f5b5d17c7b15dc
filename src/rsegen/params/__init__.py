"""The types of parameters, the places of obstacles, random generators and registries: the base of everything else.

`sorts` says which values a field takes, `places` the same for cells of a map, `registry` finds things by their names,
`streams` gives every obstacle of every map a random generator of its own.
"""
