"""Data sets: very many maps of some recipes in few files, read as one array, and checked.

DIR --Dataset--> levels (maps, n_x, n_y), metrics, any map by its place
"""
