"""The generated parts of the manual: schema, obstacle reference, parameter table, formats, figures of speed and of
difficulty, pictures; and the types that the page shares with its server.

python -m docs.generate           makes them anew
python -m docs.generate --check   exits with 1 where one of them is out of date, and names it
"""

from __future__ import annotations

import ast
import io
import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory

import rsegen
from benchmarks import (
    agreement,
    ant_on_blocks,
    asked,
    busy,
    certainty,
    crossable,
    crossings,
    datasets,
    driven_poses,
    flippers,
    go1_on_blocks,
    learning,
    many_worlds,
    rating,
    rests,
    rooms,
    scan,
    starts,
    training,
)
from benchmarks.figures import RESULTS, loaded, record_in
from benchmarks.report import filled, page, with_table
from docs import catalogue, difficulty, gallery, protocol, records, reliability
from rsegen import (
    FORMATS,
    KINDS,
    CutSettings,
    DiagonalBarrier,
    Peak,
    Random,
    Recipe,
    Scene,
    StepLimits,
    Terrain,
    compose,
    load,
    schema,
    series,
)
from rsegen.build_sheets.document import pages
from rsegen.cli.command_line import parser_of
from rsegen.experiments import report as experiments
from rsegen.experiments.run import load_summary
from rsegen.formats import MAT
from rsegen.measuring.plots import path_plot
from rsegen.obstacles.base import PLACING, own_parameters
from rsegen.params.capabilities import capabilities, commands, public_names
from rsegen.params.command import rows
from rsegen.params.registry import summary_of_class
from rsegen.params.sorts import Parameter, parameters
from rsegen.pictures.preview import encoded, preview
from rsegen.recipe.codec import decode, to_json
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.base import ROBOTS
from rsegen.standing.plots import pose_maps

DOCS = Path(__file__).parent
STUB = DOCS.parent / "src" / "rsegen" / "__init__.pyi"
ARCHITECTURE = DOCS.parent / "ARCHITECTURE.md"
README = DOCS.parent / "README.md"
CONSTRAINTS = DOCS / "constraints.md"
MEASURED = DOCS / "measured.md"
EXPERIMENT = RESULTS / "experiment.json"
PLOT = "\n![Real-time factor, speed and memory over the side of the map](pictures/experiment.png)\n"
WAYS = DOCS / "pictures" / "ways.png"
POSE_MAPS = DOCS / "pictures" / "poses.png"
SETTLED = DOCS / "pictures" / "settled.png"
TERRAIN = DOCS / "pictures" / "terrain.png"
SHEET = DOCS / "pictures" / "sheet.png"
SHEET_OF_A_PALLET = DOCS / "pictures" / "sheet-pallet.png"
ALGORITHMS: Mapping[str, Sequence[str]] = {
    "Recipes": (
        "params/streams",
        "params/arrays",
        "recipe/building",
        "recipe/batch",
        "recipe/difficulty",
        "recipe/constraints/meeting",
        "recipe/constraints/inventory",
    ),
    "Fields and their metrics": (
        "field/stepfield",
        "obstacles/rearranged",
        "field/traversability",
        "field/sweeps",
        "field/graphs",
        "measuring/roughness",
        "measuring/spectrum",
        "measuring/batch",
    ),
    "Geometry": (
        "geometry/mesh",
        "geometry/rectangles",
        "geometry/exposed_faces",
        "geometry/watertight_mesh",
        "geometry/box_merging",
        "geometry/texture",
        "formats/solid",
    ),
    "Fields in point clouds": (
        "scanning/finding",
        "scanning/ground",
        "scanning/grid",
        "scanning/levels",
        "scanning/extent",
        "scanning/evidence",
        "scanning/surroundings",
        "scanning/comparison",
    ),
    "Robots on fields": (
        "standing/body",
        "standing/settling",
        "standing/pushing",
        "standing/resting",
        "standing/lanes",
        "standing/careful_lanes",
        "standing/lattice",
        "standing/evidence",
        "standing/reach",
        "standing/planner",
        "standing/spots",
    ),
    "Ground for robots that learn": ("learning/ground", "learning/curriculum"),
    "Files and pictures": (
        "build_sheets/timber",
        "standing/posture",
        "scene/looks/images",
        "scene/looks/pine",
        "pictures/preview",
        "pictures/camera",
        "pictures/animation",
        "gazebo/obj",
        "scene/scene",
    ),
    "What is written": (
        "writing/execute",
        "writing/journal",
        "writing/store",
        "writing/swap",
        "writing/lock",
        "datasets/series_rows",
        "heights/measured",
    ),
    "Robots and simulators": (
        "robots/files/sdf_shapes",
        "robots/files/sdf_drives",
        "robots/files/wheel_joints",
        "robots/files/controllers",
        "robots/files/sdf_file",
        "robots/files/urdf",
        "robots/files/xacro_files",
        "driving/routes",
        "driving/drive_metrics",
        "rating/psychometric",
        "rating/run",
        "spawning/spawning",
        "simulators/patience",
        "simulators/connecting",
        "simulators/wire",
        "simulators/classic_transport",
        "simulators/sim_transport",
    ),
}
"""Modules of algorithms by the part of docs/algorithms.md that shows their docstrings."""


def _constraints() -> str:
    """Return the page of constraints with its two tables."""
    text = filled(CONSTRAINTS.read_text("utf-8"), asked.table(record_in(asked.FILE)), asked.MARKS)
    return filled(text, crossable.table(record_in(crossable.FILE)))


def _pages_with_a_table() -> Iterator[tuple[Path, str]]:
    """Yield the pages that people write, each with the table in it made anew."""
    tables = {
        "agreement": agreement.table(agreement.loaded(), agreement.recorded_lanes()),
        "certainty": certainty.summary(certainty.loaded()),
        "datasets": datasets.table(loaded(datasets.FILE)),
        "difficulty": difficulty.table(),
        "driving": starts.table(record_in(starts.FILE)),
        "formats": _formats(),
        "gazebo": _told_apart((RESULTS / "contact.md").read_text("utf-8")),
        "learned": _learned(),
        "learning": learning.table(record_in(learning.FILE)),
        "mujoco": agreement.summary(agreement.loaded()),
        "poses": _predictions(),
        "predicted": certainty.table(certainty.loaded()),
        "rating": rating.table(record_in(rating.FILE)),
        "reliability": reliability.table(),
        "robots": _robots(),
        "scan": _scans(),
        "training": training.table(record_in(training.FILE)),
    }
    for name, table in tables.items():
        page_of_table = DOCS / f"{name}.md"
        yield page_of_table, filled(page_of_table.read_text("utf-8"), table)


def texts() -> dict[Path, str]:
    """Every generated text by its file."""
    figures = loaded(RESULTS / "speed.json")
    contact = (RESULTS / "contact.md").read_text("utf-8")
    dated = records.dates(records.today())
    return {
        **dict(_pages_with_a_table()),
        MEASURED: with_table(MEASURED.read_text("utf-8"), figures, records.in_short(dated, "speed")),
        DOCS / "records.md": "\n".join((_RECORDS, *records.table(dated))) + "\n",
        records.DATES: json.dumps(dated, indent=1) + "\n",
        DOCS / "benchmarks.md": page(figures),
        CONSTRAINTS: _constraints(),
        README: filled(README.read_text("utf-8"), rating.summary(record_in(rating.FILE))),
        DOCS / "busy.md": busy.page(record_in(busy.FILE)),
        DOCS / "contact.md": contact + "\n" + (RESULTS / "contact-sim.md").read_text("utf-8"),
        protocol.FILE: protocol.protocol(),
        DOCS / "recipe.schema.json": json.dumps(schema(), indent=2) + "\n",
        DOCS / "obstacles.md": "\n".join(_obstacles()) + "\n",
        DOCS / "algorithms.md": "\n".join(_algorithms()) + "\n",
        DOCS / "commands.md": "\n".join(_commands()) + "\n",
        STUB: "\n".join(_stub()) + "\n",
        ARCHITECTURE: filled(ARCHITECTURE.read_text("utf-8"), _capabilities()),
        DOCS / "decisions" / "index.md": "\n".join(_decisions()) + "\n",
        DOCS / "gallery.md": "\n".join(gallery.page()) + "\n",
        DOCS / "parameters.md": "\n".join(_parameters()) + "\n",
        DOCS / "examples.md": "\n".join(_examples()) + "\n",
        DOCS / "experiment.md": experiments.report_page(*load_summary(EXPERIMENT)) + PLOT,
        DOCS / "driven.md": experiments.report_page(*load_summary(RESULTS / "driven.json")),
        DOCS / "burgers.md": experiments.report_page(*load_summary(RESULTS / "burgers.json")),
        DOCS / "representations.md": experiments.report_page(*load_summary(RESULTS / "representations.json")),
    }


_RECORDS = """\
# When, where and how

Every record of figures in the repository (`benchmarks/results`): when it was measured, by what command, and on what.
`busy before` are the cores that other work used as it began; figures of speed are CPU time, which that changes little.
Dates up to 25 November 2026 are those on which a record was committed. `code` is the state of the code that makes the
figures, in eight digits, without comments; `changed since` are figures older than that code, which their command may
give otherwise now (`python -m docs.records` says what has changed). The code of maps is not counted: their bytes are
held by tests. What came out worse elsewhere is
[on the page of claims](measured.md#where-it-came-out-worse). Each command measures its figures again, and `make docs`
shows them.
"""


def pictures() -> dict[Path, Scene]:
    """Content of every generated picture, by its file: the first map of each example, each kind alone, ways, sheets."""
    shown = {DOCS / "pictures" / f"{path.stem}.png": load(path) for path in EXAMPLES.values()}
    shown |= {DOCS / "pictures" / f"kind-{kind}.png": catalogue.recipe_of(kind) for kind in KINDS}
    shown[WAYS] = shown[POSE_MAPS] = shown[SETTLED] = load(EXAMPLES["mixed-course"])
    shown[TERRAIN] = terrain()
    shown |= {SHEET: load(EXAMPLES["five-pallet-dash"]), SHEET_OF_A_PALLET: load(EXAMPLES["red-diagonal-pallet"])}
    return {path: compose(recipe) for path, recipe in shown.items()}


def rising() -> dict[Path, bool]:
    """The pictures of series, and whether they are of one field."""
    return {DOCS / "pictures" / name: name == "one-field.png" for name in ("series.png", "one-field.png")}


def stale() -> Iterator[Path]:
    """The files that are missing or out of date; a picture is judged by what it shows."""
    for path, text in texts().items():
        if not path.exists() or path.read_text("utf-8") != text:
            yield path
    for path, scene in pictures().items():
        if not path.exists() or not shows(path, scene.alone):
            yield path
    for path, recipe in (dict.fromkeys(rising(), difficulty.EXAMPLE) | gallery.pictures()).items():
        if not path.exists() or not shows(path, recipe):
            yield path


def main(arguments: list[str]) -> int:
    """Make or check."""
    if arguments == ["--check"]:
        found = list(stale())
        for path in found:
            print(f"{path}: out of date; run: make docs")  # noqa: T201  # a command
        return 1 if found else 0
    for path, text in texts().items():
        path.write_text(text, "utf-8", newline="\n")
    for path, scene in pictures().items():
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(_DRAWN.get(path, preview)(scene))
    for path in gallery.pictures():
        path.write_bytes(gallery.picture(path))
    for path, same_field in rising().items():
        path.write_bytes(_rise(same_field=same_field))
    plan, results, *_ = load_summary(EXPERIMENT)
    (DOCS / "pictures" / "experiment.png").write_bytes(experiments.plot(plan, results))
    (DOCS / "pictures" / "flippers.png").write_bytes(flippers.plot(record_in(flippers.FILE)))
    learned = training.plot(record_in(training.FILE))
    (DOCS / "pictures" / "training.png").write_bytes(learned)
    return 0


def _learned() -> Iterator[str]:
    """Results of robots that learned in many worlds, and the cost of these."""
    yield "## A crawler and its flippers\n"
    yield "![The share of fields crossed while learning, and of unseen fields by their blocks](pictures/flippers.png)\n"
    yield from flippers.table(record_in(flippers.FILE))
    yield "\n## Many worlds\n"
    yield from many_worlds.table(record_in(many_worlds.FILE))
    yield "\n## Gymnasium's Ant\n"
    yield from ant_on_blocks.table(record_in(ant_on_blocks.FILE))
    yield "\n## mjlab's Go1\n"
    yield from go1_on_blocks.table(record_in(go1_on_blocks.FILE))


def _scans() -> Iterator[str]:
    """Accuracy of scans, of fields alone and in rooms."""
    yield from scan.table(record_in(scan.FILE))
    yield "\n### In rooms\n"
    yield from rooms.table(record_in(rooms.FILE))


def _ways(scene: Scene) -> bytes:
    limits = StepLimits(climb_cm=10)
    return path_plot(scene, limits.reach(scene.field), limits.in_words("cm"))


def _pose_maps(scene: Scene) -> bytes:
    return pose_maps(scene, ROBOTS["jackal"].body, 0.5, robot="jackal")


def _rise(*, same_field: bool) -> bytes:
    with TemporaryDirectory() as folder:
        return series(difficulty.EXAMPLE, folder, same_field=same_field).picture.read_bytes()


def _page(scene: Scene, number: int) -> bytes:
    return encoded(list(pages(scene, CutSettings()))[number], "png", to_json(scene.alone), is_stamped=False)


_DRAWN: Mapping[Path, Callable[[Scene], bytes]] = {
    WAYS: _ways,
    POSE_MAPS: _pose_maps,
    SETTLED: partial(preview, robot=ROBOTS["jackal"], at=(-0.9, 0.3, radians(200))),
    SHEET: partial(_page, number=0),
    SHEET_OF_A_PALLET: partial(_page, number=1),
}


def terrain() -> Recipe:
    """Ten rows and six columns of three kinds."""
    kinds = {
        "rubble": Random(levels=6),
        "ridge": DiagonalBarrier(levels=8, softness=30),
        "hill": Peak(levels=9, softness=80),
    }
    recipes = [
        Recipe(name=name, seed=7, chunk_size=20, unit_cm=5, boundary="none", obstacles=(obstacle,))
        for name, obstacle in kinds.items()
    ]
    return Terrain(recipes=recipes, rows=10, columns=6, gap=2, border=6).recipe


def shows(path: Path, recipe: Recipe) -> bool:
    """Return whether a picture shows the maps of a recipe: the one in it has the same values, whatever wrote it.

    A sheet shows the version too, which must be this one.
    """
    from PIL import Image

    with Image.open(io.BytesIO(path.read_bytes())) as found:
        carried = found.info.get("Description")
    if carried is None or (path == SHEET and json.loads(carried)["generator"] != f"rsegen {rsegen.__version__}"):
        return False
    return decode(json.loads(carried)) == recipe


SHOWN = {
    "plane": "the bare ground",
    "body-kd1000": "merged mesh, `--simulator classic`",
    "mesh-kd1000": "merged mesh, by default",
    "watertight-kd1000": "watertight mesh",
    "mesh": "merged mesh without soft contact",
    "block-mesh": "8 vertices and 6 faces per block, without soft contact",
}
"""Parts of the contact benchmark that are in the manual, and their names there."""


def _predictions() -> Iterator[str]:
    """Yield the tables of poses at rest, of poses on drives, and of crossings."""
    yield "### At rest\n"
    record = record_in(rests.FILE)
    yield from rests.table(record)
    yield f"\nSpeeds are of CPU time, on: {record['machine']}."
    yield "\n### On drives\n"
    yield from driven_poses.table(record_in(driven_poses.FILE))
    yield "\n### Across\n"
    yield from crossings.table(record_in(crossings.FILE))


def _told_apart(contact: str) -> Iterator[str]:
    """A few rows and columns of the contact benchmark's table."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in contact.splitlines() if line[:1] == "|"]
    columns = [rows[0].index(name) for name in ("soft: lane", "soft: scattered", "light wheels", "sphere wheels")]
    yield "| mm off course in 2.2 m, mean (max) | lane in a random field | plain with others | light wheels | spheres |"
    yield "|---|---|---|---|---|"
    for row in (row for name in SHOWN for row in rows if row[0] == name):
        yield "| " + " | ".join([SHOWN[row[0]], *(row[column].split(" /")[0] for column in columns)]) + " |"


def _obstacles() -> Iterator[str]:
    yield "# Obstacles\n\nMade by `make docs` from the obstacle classes; `rsegen obstacles` prints the same."
    yield "The [gallery](gallery.md) has every kind at three values of softness."
    for kind, cls in KINDS.items():
        yield f"\n## `{kind}`\n\n{summary_of_class(cls)}\n"
        yield from _table(own_parameters(cls))
        yield f"\n![{kind}](pictures/kind-{kind}.png)\n"
        yield f"    {catalogue.command(kind)}"
    yield "\n## Every kind\n"
    yield from _table(PLACING)


def _decisions() -> Iterator[str]:
    yield "# Decisions\n\nWhat was decided and would be costly to change, with the reasons.\n"
    for path in sorted((DOCS / "decisions").glob("0*.md")):
        title = path.read_text("utf-8").partition("\n")[0].removeprefix("# ")
        yield f"- [{title}]({path.name})"


def _algorithms() -> Iterator[str]:
    yield "# Algorithms\n\nFor developers: idea, source, cost and limits of each algorithm. Made by `make docs` from"
    yield "the docstrings of the modules in `src/rsegen`, where the reasons of their numbers are too."
    for part, modules in ALGORITHMS.items():
        yield f"\n## {part}"
        for module in modules:
            text = (DOCS.parent / "src" / "rsegen" / f"{module}.py").read_text("utf-8")
            yield f"\n### `{module}.py`\n\n{_as_markdown(ast.get_docstring(ast.parse(text)) or '')}"


def _as_markdown(docstring: str) -> str:
    """Return a docstring with links to the manual, and with drawings, which are indented by four spaces, as code."""
    parts: list[tuple[bool, str]] = []
    for paragraph in docstring.split("\n\n"):
        is_drawn = all(line.startswith("    ") for line in paragraph.splitlines() if line)
        if is_drawn and parts and parts[-1][0]:  # a drawing with an empty line in it
            parts[-1] = (True, f"{parts[-1][1]}\n\n{paragraph}")
        else:
            parts.append((is_drawn, paragraph if is_drawn else re.sub(r"docs/(\w+)\.md", r"[\1](\1.md)", paragraph)))
    return "\n\n".join(f"```text\n{text}\n```" if is_drawn else text for is_drawn, text in parts)


_SHARED = """\
# Commands

Made by `make docs` from the signatures of the functions, which are the same in Python and in a shell:
`rsegen drive mixed-course --robots 3` is `rsegen.drive(recipe, robots=3)`. `rsegen COMMAND -h` prints all flags.

Every command has

- `--json`: it prints its result as JSON, with lengths in metres;
- `-q`, `--quiet`: it prints no report and no progress;
- `--progress bar`, `json` or `none`: it shows its progress as a bar if stderr is a terminal, which is the default; as
  lines such as `{"done": 2, "total": 7, "unit": "map", "step": ""}` on stderr, for programs, which with `--json` also
  get the report for people there, as `{"report": ["..."]}`; or not at all;
- `--dry-run`, if it writes files: it prints which files it would write, replace, remove and keep, and changes nothing;
- `--plugin FILE`: it loads [obstacles, formats, ... of your own](plugins.md);
- exit codes: 0 done; 2 invalid input, and nothing was changed; 1 if something failed later, of `compare` if maps
  differ, and of `--verify` if files do; 130 after Ctrl-C. An error is one line on stderr.

`rsegen` alone prints a short overview, `rsegen --help` all commands, `rsegen -V` the version. `rsegen schema` prints
the JSON Schema of recipe files, `rsegen schema COMMAND` that of the parameters of a command below, for forms.

The Tab key completes commands, flags and their words if `~/.bashrc` has this line, or `~/.zshrc` this line with `zsh`
for `bash`, after `compinit`:

    eval "$(rsegen completion bash)"

For fish: `rsegen completion fish > ~/.config/fish/completions/rsegen.fish`.

Commands that take a recipe also have a flag for each [global parameter](parameters.md). A flag that begins with `--no-`
switches off what its row says."""


def _commands() -> Iterator[str]:
    yield _SHARED
    for name, function in ((known.name, known.function) for known in commands().values() if known.function):
        owner = getattr(rsegen, function)
        what = (owner.__doc__ or "").partition("\n")[0]
        yield f"\n## {name}\n\n{what} In Python: [`rsegen.{function}`](api.md).\n"
        yield f"    {_usage(name)}\n"
        yield "| in Python | flag | values | default | meaning |\n|---|---|---|---|---|"
        for parameter, flag, values, default, meaning in rows(owner):
            texts = (cell.replace("|", "\\|") for cell in (values, default, meaning))
            yield f"| `{parameter}` | {_code_in_table(flag)} | {' | '.join(texts)} |"
    yield "\n## Other commands\n\n| command | what it does |\n|---|---|"
    for known in (known for known in commands().values() if not known.function):
        yield f"| `{known.name}` | {known.help} |"


def _stub() -> Iterator[str]:
    """Yield the stub of `rsegen/__init__.py`, from which type checkers know the public names."""
    yield '"""Made by `make docs` from the declarations of the core and the capabilities, for type checkers."""\n'
    for module, name in sorted((module, name) for name, module in public_names().items()):
        yield f"from {module} import {name} as {name}"
    yield "\n__version__: str\n"
    yield "__all__ = ["
    yield from (f'    "{name}",' for name in sorted(["__version__", *public_names()], key=_constants_classes_functions))
    yield "]"


def _constants_classes_functions(name: str) -> tuple[int, str]:
    """Return the key by which ruff has public names sorted."""
    return 2 - name[:1].isupper() - name.isupper(), name


def _capabilities() -> Iterator[str]:
    """Yield a table of the capabilities."""
    yield "| folder | what it is | commands | needs | extras |\n|---|---|---|---|---|"
    for folder, known in capabilities().items():
        own = ", ".join(f"`{command.name}`" for command in known.commands)
        needs = ", ".join(f"`{name}`" for name in known.needs)
        wanted = ", ".join(f"`{extra.name}`" for extra in known.extras)
        yield f"| {f'`{folder}/`' if folder != 'core' else 'core'} | {known.summary} | {own} | {needs} | {wanted} |"


def _code_in_table(text: str) -> str:
    """Return a text as code: MkDocs shows the backslash of an escaped | in backticks, GitHub does not."""
    return f"<code>{text.replace('|', '&#124;')}</code>" if "|" in text else f"`{text}`"


def _usage(name: str) -> str:
    """Return the first line of a command's help: what must be given."""
    return " ".join(parser_of(name).format_help().partition("\n\n")[0].split()).removeprefix("usage: ")


def _parameters() -> Iterator[str]:
    yield "# Global parameters\n\nMade by `make docs` from `rsegen.Recipe`; each is a key of a recipe and a flag.\n"
    yield from _table(parameters(Recipe))


def _examples() -> Iterator[str]:
    yield "# Examples\n\nMade by `make docs` from `src/rsegen/recipe/examples/`; `rsegen examples` lists the same, and"
    yield "with `-o DIR` copies them."
    for name, path in EXAMPLES.items():
        yield f"\n## {name}\n\n{load(path).description}: `rsegen generate {name} -o worlds`\n"
        yield f"![{name}](pictures/{name}.png)"


def _robots() -> Iterator[str]:
    yield (
        "| robot | L x W x H m | kg | wheels or tracks m | top v, w | clearance m | climbs m | sources |\n"
        + "|---" * 8
        + "|"
    )
    for kind, robot in ROBOTS.items():
        drive = robot.drive
        size = " x ".join(f"{side:.3f}" for side in robot.size)
        apart = f"radius {drive.radius}, {drive.separation} apart"
        most = f"{drive.speed} m/s, {drive.turn} rad/s"
        yield (
            f"| `{kind}`, {robot.title} | {size} | {robot.mass:.1f} | {apart} | {most} | {robot.clearance} "
            f"| {robot.climbs} | {robot.source} |"
        )


def _formats() -> Iterator[str]:
    yield "| format | what it is | options | needs |\n|---|---|---|---|"
    for name, cls in FORMATS.items():
        known = parameters(cls).items()
        options = "; ".join(f"`{key}` {one.help} ({one.describe()})" for key, one in known)
        extra = f"`rsegen[{cls.extra.name if cls.extra else MAT.name}]`"
        needs = extra if cls.extra else f"{extra} for `{cls.mat_file}`" if cls.mat_file else ""
        yield f"| [`{name}`](#{_SECTIONS.get(name, name)}) | {summary_of_class(cls)} | {options} | {needs} |"


_SECTIONS = dict.fromkeys(("stl", "ply", "glb"), "stl-ply-glb")
"""Headings of the page of formats that are not a format's name."""


def _table(known: Mapping[str, Parameter]) -> Iterator[str]:
    yield "| parameter | values | meaning |\n|---|---|---|"
    for name, parameter in known.items():
        values = parameter.describe().replace("|", "\\|")
        yield f"| `{name}` | {values} | {parameter.help} |"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
