"""The commands as functions: `rsegen.drive` in Python and `rsegen drive` in a shell are one, declared by its signature.

The annotated parameters of a function are the only place for their names, bounds, units, help and defaults
(`params/command.py`); what does the work is imported in its body.
"""
