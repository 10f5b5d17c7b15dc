"""Readers of files: recipes, heights, point clouds, data sets, checksums; and the memory and disk that a run needs.

Files come from strangers: nothing in them is trusted, and what is wrong is a FileError of one line.
"""
