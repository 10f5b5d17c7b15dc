"""The one engine that writes whatever rsegen writes: nothing is lost, whenever a run ends (docs/engine.md).

    product --execute: here, in workers, on a cluster--> staged files --Store: one swap each--> a folder with a Journal

plan.py      what a run makes, checked once: products, items, and those that exist already
execute.py   where it is made: here, in workers, on a Dask cluster; always in order
store.py     a folder that one run alone writes into: hidden staging, one swap per item, a journal
undo.py      swaps that belong together, taken back if one fails
swap.py      the swap of a staged file or folder with what is in its place
journal.py   what rsegen wrote into a folder, with checksums: nothing else is ever replaced
lock.py      which run has a folder, also where the disk has no locks
stop.py      signals that stop a run, held back where they would leave something half done
"""
