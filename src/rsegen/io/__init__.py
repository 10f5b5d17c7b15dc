"""Everything that reads or writes files: maps, exports, build sheets, series, data sets, recipes, measured heights.

Bundle --write--> files
"""
