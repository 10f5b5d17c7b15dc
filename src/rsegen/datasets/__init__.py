"""Very many maps: series of rising difficulty, and data sets in few files, read as one array, and checked.

DIR --Dataset--> levels (maps, n_x, n_y), metrics, any map by its place
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import Extra

DATASET = Extra("dataset", "pyarrow", "rsegen dataset --metrics parquet: metrics of a data set as Parquet")

CAPABILITY = Capability(
    summary="series of rising difficulty, and data sets of very many maps",
    needs=("measuring", "pictures"),
    commands=(
        Command(
            "series",
            "make worlds",
            "write maps whose difficulty rises evenly",
            "rsegen.datasets.commands",
            "series",
            title="Series of rising difficulty",
            also=("curriculum", "difficulty"),
        ),
        Command(
            "dataset",
            "for learning",
            "write very many maps into few files, for machine learning",
            "rsegen.datasets.commands",
            "make_dataset",
            title="Data set of very many maps",
            also=("data", "samples"),
        ),
    ),
    public={
        "rsegen.datasets.commands": ("make_dataset", "series"),
        "rsegen.datasets.reading": ("Dataset", "Tiles"),
        "rsegen.datasets.series": ("Series",),
    },
    extras=(DATASET,),
    targets="rsegen.datasets.layout:recipe_of_place",
    manual="datasets",
)
