"""Random Step Environments (NIST stepfields) for robot simulators.

import rsegen

recipe = rsegen.Recipe(
    seed=7,
    obstacles=[
        rsegen.Random(levels=5),
        rsegen.Peak(levels=5, softness=50, first=(2, 2), last=(7, 7)),
    ],
)
field = rsegen.build(recipe, 0)           # integer levels in cells
rsegen.generate(recipe, "worlds")         # a Gazebo world and model package

A name is imported when it is first used (PEP 562), so `import rsegen` takes no time.
"""

import sys
from importlib import import_module

TYPE_CHECKING = False
"""As in `typing`, which takes longer to import than all of this."""

if TYPE_CHECKING:
    from rsegen.commands.maps import export as export
    from rsegen.commands.maps import export_maps as export_maps
    from rsegen.commands.maps import generate as generate
    from rsegen.commands.maps import make_dataset as make_dataset
    from rsegen.commands.maps import series as series
    from rsegen.commands.simulation import drive as drive
    from rsegen.commands.simulation import experiment as experiment
    from rsegen.commands.simulation import open as open
    from rsegen.commands.simulation import remove as remove
    from rsegen.commands.simulation import respawn as respawn
    from rsegen.commands.simulation import spawn as spawn
    from rsegen.commands.simulation import spots as spots
    from rsegen.errors import RsegenError as RsegenError
    from rsegen.errors import UserError as UserError
    from rsegen.exporters.cut_settings import CutSettings as CutSettings
    from rsegen.exporters.formats import FORMATS as FORMATS
    from rsegen.exporters.pictures.preview import preview as preview
    from rsegen.exporters.scene import Scene as Scene
    from rsegen.exporters.scene import compose as compose
    from rsegen.exporters.sheet import sheet as sheet
    from rsegen.field.metrics import Metrics as Metrics
    from rsegen.field.metrics import StepLimits as StepLimits
    from rsegen.field.metrics import metrics as metrics
    from rsegen.field.metrics.catalogue import Metric as Metric
    from rsegen.field.metrics.catalogue import metric as metric
    from rsegen.field.obstacles import KINDS as KINDS
    from rsegen.field.obstacles import Obstacle as Obstacle
    from rsegen.field.obstacles.barrier import DiagonalBarrier as DiagonalBarrier
    from rsegen.field.obstacles.barrier import HorizontalBarrier as HorizontalBarrier
    from rsegen.field.obstacles.matrix import Matrix as Matrix
    from rsegen.field.obstacles.pallet import Pallet as Pallet
    from rsegen.field.obstacles.peak import Peak as Peak
    from rsegen.field.obstacles.pit import Pit as Pit
    from rsegen.field.obstacles.platform import Platform as Platform
    from rsegen.field.obstacles.rails import Rails as Rails
    from rsegen.field.obstacles.random import NormalRandom as NormalRandom
    from rsegen.field.obstacles.random import Random as Random
    from rsegen.field.obstacles.stairs import Stairs as Stairs
    from rsegen.field.obstacles.stones import Stones as Stones
    from rsegen.field.stepfield import StepField as StepField
    from rsegen.geometry.box_merging import Boxes as Boxes
    from rsegen.geometry.box_merging import boxes as boxes
    from rsegen.geometry.mesh import Mesh as Mesh
    from rsegen.geometry.mesh_kinds import mesh as mesh
    from rsegen.io.dataset.reading import Dataset as Dataset
    from rsegen.io.dataset.tiles import Tiles as Tiles
    from rsegen.io.importers import imported as imported
    from rsegen.io.recipe_file import load as load
    from rsegen.io.scan_options import ScanOptions as ScanOptions
    from rsegen.io.scans import ComparedMap as ComparedMap
    from rsegen.io.scans import ScannedMap as ScannedMap
    from rsegen.io.scans import compare as compare
    from rsegen.io.scans import scan as scan
    from rsegen.learning.ground import Ground as Ground
    from rsegen.learning.ground import next_rows as next_rows
    from rsegen.learning.ground import scan_points as scan_points
    from rsegen.page.service import Gui as Gui
    from rsegen.page.service import gui as gui
    from rsegen.params.plugins import load_plugin as load_plugin
    from rsegen.recipe.batch import build_many as build_many
    from rsegen.recipe.building import build as build
    from rsegen.recipe.codec import schema as schema
    from rsegen.recipe.recipe import Recipe as Recipe
    from rsegen.recipe.terrain import Terrain as Terrain
    from rsegen.robots.lookup import poses as poses
    from rsegen.robots.lookup import robot_of as robot_of
    from rsegen.run.exports import Exported as Exported
    from rsegen.run.exports import ExportedMap as ExportedMap
    from rsegen.run.journal import Verified as Verified
    from rsegen.run.journal import verify as verify
    from rsegen.run.series import Series as Series
    from rsegen.run.single_files import View as View
    from rsegen.run.single_files import save as save
    from rsegen.run.single_files import view as view
    from rsegen.run.worlds import Generated as Generated
    from rsegen.run.worlds import GeneratedMap as GeneratedMap
    from rsegen.simulation.driving.drive import DriveResult as DriveResult
    from rsegen.simulation.experiment.run import ExperimentResult as ExperimentResult
    from rsegen.simulation.open_world import OpenResult as OpenResult
    from rsegen.simulation.spawning import RemoveResult as RemoveResult
    from rsegen.simulation.spawning import RespawnResult as RespawnResult
    from rsegen.simulation.spawning import SpawnResult as SpawnResult
    from rsegen.standing.resting import Poses as Poses
    from rsegen.standing.spots import Spot as Spot

__version__ = "1.0.0"

_HOMES = {
    "rsegen.commands.maps": ("export", "export_maps", "generate", "make_dataset", "series"),
    "rsegen.commands.simulation": ("drive", "experiment", "open", "remove", "respawn", "spawn", "spots"),
    "rsegen.errors": ("RsegenError", "UserError"),
    "rsegen.exporters.formats": ("FORMATS",),
    "rsegen.exporters.pictures.preview": ("preview",),
    "rsegen.exporters.scene": ("Scene", "compose"),
    "rsegen.exporters.sheet": ("sheet",),
    "rsegen.exporters.cut_settings": ("CutSettings",),
    "rsegen.field.metrics": ("Metrics", "StepLimits", "metrics"),
    "rsegen.field.metrics.catalogue": ("Metric", "metric"),
    "rsegen.field.obstacles": ("KINDS", "Obstacle"),
    "rsegen.field.obstacles.barrier": ("DiagonalBarrier", "HorizontalBarrier"),
    "rsegen.field.obstacles.matrix": ("Matrix",),
    "rsegen.field.obstacles.pallet": ("Pallet",),
    "rsegen.field.obstacles.peak": ("Peak",),
    "rsegen.field.obstacles.pit": ("Pit",),
    "rsegen.field.obstacles.platform": ("Platform",),
    "rsegen.field.obstacles.rails": ("Rails",),
    "rsegen.field.obstacles.random": ("NormalRandom", "Random"),
    "rsegen.field.obstacles.stairs": ("Stairs",),
    "rsegen.field.obstacles.stones": ("Stones",),
    "rsegen.field.stepfield": ("StepField",),
    "rsegen.standing.spots": ("Spot",),
    "rsegen.geometry.box_merging": ("Boxes", "boxes"),
    "rsegen.geometry.mesh": ("Mesh",),
    "rsegen.geometry.mesh_kinds": ("mesh",),
    "rsegen.io.dataset.reading": ("Dataset",),
    "rsegen.io.dataset.tiles": ("Tiles",),
    "rsegen.io.importers": ("imported",),
    "rsegen.io.recipe_file": ("load",),
    "rsegen.io.scan_options": ("ScanOptions",),
    "rsegen.io.scans": ("ComparedMap", "ScannedMap", "compare", "scan"),
    "rsegen.learning.ground": ("Ground", "next_rows", "scan_points"),
    "rsegen.page.service": ("Gui", "gui"),
    "rsegen.params.plugins": ("load_plugin",),
    "rsegen.recipe.batch": ("build_many",),
    "rsegen.recipe.building": ("build",),
    "rsegen.recipe.codec": ("schema",),
    "rsegen.recipe.recipe": ("Recipe",),
    "rsegen.recipe.terrain": ("Terrain",),
    "rsegen.standing.resting": ("Poses",),
    "rsegen.robots.lookup": ("poses", "robot_of"),
    "rsegen.run.exports": ("Exported", "ExportedMap"),
    "rsegen.run.journal": ("Verified", "verify"),
    "rsegen.run.series": ("Series",),
    "rsegen.run.single_files": ("View", "save", "view"),
    "rsegen.run.worlds": ("Generated", "GeneratedMap"),
    "rsegen.simulation.driving.drive": ("DriveResult",),
    "rsegen.simulation.experiment.run": ("ExperimentResult",),
    "rsegen.simulation.open_world": ("OpenResult",),
    "rsegen.simulation.spawning": ("RemoveResult", "RespawnResult", "SpawnResult"),
}
"""Where each public name is; the imports above say the same to type checkers, and a test holds both together."""

_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

if not TYPE_CHECKING:  # type checkers take what the block above imports, and know of no other name
    __all__ = ["__version__", *sorted(_HOME_OF)]  # noqa: PLE0604  # they are texts

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used, and describe it as `help` shows it."""
        if name not in _HOME_OF:
            raise AttributeError(f"module 'rsegen' has no attribute {name!r}")
        value = getattr(import_module(_HOME_OF[name]), name)
        globals()[name] = value = import_module("rsegen.params.docstrings").described(value)
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *_HOME_OF})


if "IPython" in sys.modules:  # a notebook, perhaps: fields and scenes are shown as small plans
    import_module("rsegen.exporters.pictures.notebook").register_formatters()
