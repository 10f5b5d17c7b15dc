"""The command line: parse, call, report. No arithmetic of the domain.

Exit codes: 0 done; 2 the user's mistake, and nothing was changed; 130 stopped by Ctrl-C (else 128 and the number of the
signal); 1 anything else, of `compare` also that maps differ. Each but 0 comes with one line on stderr.
"""

from rsegen.params.capabilities import Capability, Command
from rsegen.params.extras import CLUSTER

_REFERENCE, _INFORMATION = "rsegen.cli.reference", "information"

CAPABILITY = Capability(
    summary="the core: from a recipe to a Gazebo world on the disk",
    commands=(
        Command(
            "generate",
            "make worlds",
            "write worlds and models",
            "rsegen.cli.generate",
            "generate",
            title="Generate worlds",
            also=("make", "create", "new", "build", "world", "gen"),
        ),
        Command(
            "info",
            "measure",
            "print the size of a map, its obstacles and its cost",
            "rsegen.cli.info",
            also=("show", "stat", "describe"),
        ),
        Command(
            "examples",
            _INFORMATION,
            "list the recipes to start from, or copy them",
            _REFERENCE,
            also=("list", "templates", "recipes"),
        ),
        Command(
            "obstacles",
            _INFORMATION,
            "list the kinds of obstacles and their parameters",
            _REFERENCE,
            also=("kinds", "shapes"),
        ),
        Command(
            "schema",
            _INFORMATION,
            "print the JSON Schema of recipe files, or of the parameters of a command",
            _REFERENCE,
            also=("parameters", "config"),
        ),
        Command(
            "doctor",
            _INFORMATION,
            "list what is installed, what is missing and what it is needed for",
            "rsegen.cli.doctor",
            title="What is installed",
            also=("check", "status", "environment"),
        ),
        Command("completion", _INFORMATION, "print a shell completion script, for bash, zsh or fish", _REFERENCE),
        Command(
            "man",
            _INFORMATION,
            "print the manual page of rsegen or of a command",
            _REFERENCE,
            also=("manual", "docs"),
        ),
    ),
    public={
        "rsegen.cli.generate": ("generate",),
        "rsegen.errors": ("RsegenError", "UserError"),
        "rsegen.field.crossing": ("StepLimits",),
        "rsegen.obstacles": ("KINDS", "Obstacle"),
        "rsegen.obstacles.barrier": ("DiagonalBarrier", "HorizontalBarrier"),
        "rsegen.obstacles.discrete_obstacles": ("DiscreteObstacles",),
        "rsegen.obstacles.matrix": ("Matrix",),
        "rsegen.obstacles.noise": ("Noise",),
        "rsegen.obstacles.pallet": ("Pallet",),
        "rsegen.obstacles.peak": ("Peak",),
        "rsegen.obstacles.pit": ("Pit",),
        "rsegen.obstacles.platform": ("Platform",),
        "rsegen.obstacles.rails": ("Rails",),
        "rsegen.obstacles.random": ("NormalRandom", "Random"),
        "rsegen.obstacles.slope": ("Slope",),
        "rsegen.obstacles.stairs": ("Stairs",),
        "rsegen.obstacles.stones": ("Stones",),
        "rsegen.obstacles.waves": ("Waves",),
        "rsegen.field.stepfield": ("StepField",),
        "rsegen.geometry.box_merging": ("Boxes", "boxes"),
        "rsegen.geometry.mesh": ("Mesh",),
        "rsegen.geometry.mesh_kinds": ("mesh",),
        "rsegen.params.plugins": ("load_plugin",),
        "rsegen.recipe.batch": ("build_many",),
        "rsegen.recipe.building": ("build",),
        "rsegen.recipe.codec": ("schema",),
        "rsegen.recipe.from_field": ("recipe_of",),
        "rsegen.recipe.recipe": ("Recipe",),
        "rsegen.recipe.recipe_file": ("load",),
        "rsegen.writing.journal": ("Verified", "verify"),
        "rsegen.writing.recipe_files": ("save",),
        "rsegen.writing.worlds": ("Generated", "GeneratedMap"),
        "rsegen.scene.contact": ("Contact",),
        "rsegen.scene.scene": ("Scene", "compose"),
    },
    extras=(CLUSTER,),
    manual="recipes",
)
