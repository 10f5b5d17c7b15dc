"""Made by `make docs` from the declarations of the core and the capabilities, for type checkers."""

from rsegen.build_sheets.cut_settings import CutSettings as CutSettings
from rsegen.build_sheets.document import sheet as sheet
from rsegen.cli.generate import generate as generate
from rsegen.datasets.commands import make_dataset as make_dataset
from rsegen.datasets.commands import series as series
from rsegen.datasets.reading import Dataset as Dataset
from rsegen.datasets.reading import Tiles as Tiles
from rsegen.datasets.series import Series as Series
from rsegen.driving.certainty import with_certainty as with_certainty
from rsegen.driving.commands import drive as drive
from rsegen.driving.commands import drive_many as drive_many
from rsegen.driving.commands import predict as predict
from rsegen.driving.drive import DriveResult as DriveResult
from rsegen.driving.many import ManyDrives as ManyDrives
from rsegen.driving.prediction import Outcome as Outcome
from rsegen.driving.prediction import Prediction as Prediction
from rsegen.errors import RsegenError as RsegenError
from rsegen.errors import UserError as UserError
from rsegen.experiments.commands import experiment as experiment
from rsegen.experiments.run import ExperimentResult as ExperimentResult
from rsegen.field.crossing import StepLimits as StepLimits
from rsegen.field.stepfield import StepField as StepField
from rsegen.formats.base import FORMATS as FORMATS
from rsegen.formats.commands import export as export
from rsegen.formats.commands import export_maps as export_maps
from rsegen.formats.exports import Exported as Exported
from rsegen.formats.exports import ExportedMap as ExportedMap
from rsegen.geometry.box_merging import Boxes as Boxes
from rsegen.geometry.box_merging import boxes as boxes
from rsegen.geometry.mesh import Mesh as Mesh
from rsegen.geometry.mesh_kinds import mesh as mesh
from rsegen.heights.base import imported as imported
from rsegen.learning.curriculum import next_rows as next_rows
from rsegen.learning.ground import Ground as Ground
from rsegen.learning.patterns import scan_points as scan_points
from rsegen.learning.scans import ScanSensor as ScanSensor
from rsegen.learning.terrain import Terrain as Terrain
from rsegen.measuring.catalogue import Metric as Metric
from rsegen.measuring.catalogue import Metrics as Metrics
from rsegen.measuring.catalogue import metric as metric
from rsegen.measuring.catalogue import metrics as metrics
from rsegen.obstacles import KINDS as KINDS
from rsegen.obstacles import Obstacle as Obstacle
from rsegen.obstacles.barrier import DiagonalBarrier as DiagonalBarrier
from rsegen.obstacles.barrier import HorizontalBarrier as HorizontalBarrier
from rsegen.obstacles.discrete_obstacles import DiscreteObstacles as DiscreteObstacles
from rsegen.obstacles.matrix import Matrix as Matrix
from rsegen.obstacles.noise import Noise as Noise
from rsegen.obstacles.pallet import Pallet as Pallet
from rsegen.obstacles.peak import Peak as Peak
from rsegen.obstacles.pit import Pit as Pit
from rsegen.obstacles.platform import Platform as Platform
from rsegen.obstacles.rails import Rails as Rails
from rsegen.obstacles.random import NormalRandom as NormalRandom
from rsegen.obstacles.random import Random as Random
from rsegen.obstacles.slope import Slope as Slope
from rsegen.obstacles.stairs import Stairs as Stairs
from rsegen.obstacles.stones import Stones as Stones
from rsegen.obstacles.waves import Waves as Waves
from rsegen.page.service import Gui as Gui
from rsegen.page.service import gui as gui
from rsegen.page.view import View as View
from rsegen.page.view import view as view
from rsegen.params.plugins import load_plugin as load_plugin
from rsegen.pictures.preview import preview as preview
from rsegen.rating.commands import rate as rate
from rsegen.rating.rating import Curve as Curve
from rsegen.rating.rating import Rating as Rating
from rsegen.rating.reliability import ReliabilityTest as ReliabilityTest
from rsegen.rating.reliability import failures_allowed as failures_allowed
from rsegen.recipe.batch import build_many as build_many
from rsegen.recipe.building import build as build
from rsegen.recipe.codec import schema as schema
from rsegen.recipe.from_field import recipe_of as recipe_of
from rsegen.recipe.recipe import Recipe as Recipe
from rsegen.recipe.recipe_file import load as load
from rsegen.robots.commands import spots as spots
from rsegen.robots.lookup import poses as poses
from rsegen.robots.lookup import robot_of as robot_of
from rsegen.robots.lookup import stable_poses as stable_poses
from rsegen.robots.robot_picture import robot_picture as robot_picture
from rsegen.scanning.scan_options import ScanOptions as ScanOptions
from rsegen.scanning.scans import ComparedMap as ComparedMap
from rsegen.scanning.scans import ScannedMap as ScannedMap
from rsegen.scanning.scans import compare as compare
from rsegen.scanning.scans import scan as scan
from rsegen.scene.contact import Contact as Contact
from rsegen.scene.scene import Scene as Scene
from rsegen.scene.scene import compose as compose
from rsegen.simulators.commands import open as open
from rsegen.simulators.open_world import OpenResult as OpenResult
from rsegen.spawning.commands import remove as remove
from rsegen.spawning.commands import respawn as respawn
from rsegen.spawning.commands import spawn as spawn
from rsegen.spawning.spawning import RemoveResult as RemoveResult
from rsegen.spawning.spawning import RespawnResult as RespawnResult
from rsegen.spawning.spawning import SpawnResult as SpawnResult
from rsegen.standing.outlines import Spot as Spot
from rsegen.standing.resting import Poses as Poses
from rsegen.standing.stable import StablePoses as StablePoses
from rsegen.writing.journal import Verified as Verified
from rsegen.writing.journal import verify as verify
from rsegen.writing.recipe_files import save as save
from rsegen.writing.worlds import Generated as Generated
from rsegen.writing.worlds import GeneratedMap as GeneratedMap

__version__: str

__all__ = [
    "FORMATS",
    "KINDS",
    "Boxes",
    "ComparedMap",
    "Contact",
    "Curve",
    "CutSettings",
    "Dataset",
    "DiagonalBarrier",
    "DiscreteObstacles",
    "DriveResult",
    "ExperimentResult",
    "Exported",
    "ExportedMap",
    "Generated",
    "GeneratedMap",
    "Ground",
    "Gui",
    "HorizontalBarrier",
    "ManyDrives",
    "Matrix",
    "Mesh",
    "Metric",
    "Metrics",
    "Noise",
    "NormalRandom",
    "Obstacle",
    "OpenResult",
    "Outcome",
    "Pallet",
    "Peak",
    "Pit",
    "Platform",
    "Poses",
    "Prediction",
    "Rails",
    "Random",
    "Rating",
    "Recipe",
    "ReliabilityTest",
    "RemoveResult",
    "RespawnResult",
    "RsegenError",
    "ScanOptions",
    "ScanSensor",
    "ScannedMap",
    "Scene",
    "Series",
    "Slope",
    "SpawnResult",
    "Spot",
    "StablePoses",
    "Stairs",
    "StepField",
    "StepLimits",
    "Stones",
    "Terrain",
    "Tiles",
    "UserError",
    "Verified",
    "View",
    "Waves",
    "__version__",
    "boxes",
    "build",
    "build_many",
    "compare",
    "compose",
    "drive",
    "drive_many",
    "experiment",
    "export",
    "export_maps",
    "failures_allowed",
    "generate",
    "gui",
    "imported",
    "load",
    "load_plugin",
    "make_dataset",
    "mesh",
    "metric",
    "metrics",
    "next_rows",
    "open",
    "poses",
    "predict",
    "preview",
    "rate",
    "recipe_of",
    "remove",
    "respawn",
    "robot_of",
    "robot_picture",
    "save",
    "scan",
    "scan_points",
    "schema",
    "series",
    "sheet",
    "spawn",
    "spots",
    "stable_poses",
    "verify",
    "view",
    "with_certainty",
]
