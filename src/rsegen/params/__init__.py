"""The types of parameters, the places of obstacles, random generators and registries: the base of everything else.

`sorts` says which values a field takes, `registry` finds things by their names, `plugins` and `extras` where they come
from, `streams` gives every obstacle of every map a random generator of its own.
"""
