"""Importers of heights from files; every module of this folder is an importer for some file names.

file --Importer.read--> Heights --imported--> Recipe of one matrix
"""

from rsegen.io.importers.base import IMPORTERS, Heights, Importer, heights_in, imported, importer_for, recipe_of

__all__ = ["IMPORTERS", "Heights", "Importer", "heights_in", "imported", "importer_for", "recipe_of"]
