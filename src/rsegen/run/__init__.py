"""Everything that rsegen writes, by one engine: nothing is lost, whenever a run ends (docs/reliability.md).

    Product --execute: here, in workers, on a cluster--> staged files --Store: one swap each--> a folder with a Journal

product.py   what a run makes: the files of each item as bytes
execute.py   where it is made: here, in workers, on a Dask cluster; always in order
store.py     a folder that one run alone writes into: hidden staging, one swap per item, a journal
journal.py   what rsegen wrote into a folder, with checksums: nothing else is ever replaced
lease.py     which run has a folder, also where the disk has no locks
"""
