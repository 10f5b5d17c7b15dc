"""Random Step Environments (NIST stepfields) for robot simulators.

import rsegen

recipe = rsegen.Recipe(
    seed=7,
    obstacles=[
        rsegen.Placement(obstacle=rsegen.Random(max_height=5)),
        rsegen.Placement(obstacle=rsegen.Peak(max_height=5, softness=50), first=(2, 2), last=(7, 7)),
    ],
)
field = rsegen.build(recipe, 0)           # integer levels in cells
rsegen.generate(recipe, "worlds")         # a Gazebo world and model package
"""

from rsegen.build import build
from rsegen.codec import schema
from rsegen.dataset import Dataset, Tiles, make_dataset
from rsegen.errors import RsegenError, UserError
from rsegen.exporting import ExportedMap, export_maps
from rsegen.formats import FORMATS
from rsegen.importers import imported
from rsegen.metrics import Climber, Metrics, metrics
from rsegen.obstacles import KINDS, Obstacle
from rsegen.obstacles.diagonal import DiagonalBarrier
from rsegen.obstacles.horizontal import HorizontalBarrier
from rsegen.obstacles.matrix import Matrix
from rsegen.obstacles.normal import NormalRandom
from rsegen.obstacles.pallet import Pallet
from rsegen.obstacles.peak import Peak
from rsegen.obstacles.random import Random
from rsegen.pipeline import Generated, GeneratedMap, generate
from rsegen.recipe import Placement, Recipe
from rsegen.recipe_file import load, save
from rsegen.scene import Scene, compose
from rsegen.series import Series, series
from rsegen.sheet import Saw, sheet
from rsegen.stepfield import StepField
from rsegen.version import __version__

__all__ = [
    "FORMATS",
    "KINDS",
    "Climber",
    "Dataset",
    "DiagonalBarrier",
    "ExportedMap",
    "Generated",
    "GeneratedMap",
    "HorizontalBarrier",
    "Matrix",
    "Metrics",
    "NormalRandom",
    "Obstacle",
    "Pallet",
    "Peak",
    "Placement",
    "Random",
    "Recipe",
    "RsegenError",
    "Saw",
    "Scene",
    "Series",
    "StepField",
    "Tiles",
    "UserError",
    "__version__",
    "build",
    "compose",
    "export_maps",
    "generate",
    "imported",
    "load",
    "make_dataset",
    "metrics",
    "save",
    "schema",
    "series",
    "sheet",
]
