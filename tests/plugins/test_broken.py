"""A package that is broken is said so in one line, and is in nobody's way."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from rsegen import Recipe, build, build_many
from rsegen.errors import PluginError
from rsegen.measuring.catalogue import Metric
from tests.plugins.installed import declare, done, installed, module_of, refused, run

GOOD = '''
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen import Obstacle
from rsegen.obstacles.base import Region
from rsegen.params.sorts import Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(Region):
    """Sand."""

    kind: ClassVar[str] = "dune"

    def drawn(self, uniform):
        return (uniform * self.levels).astype("int16")
'''
NO_SORT = "is annotated with 'x', which is no sort of values; use one of rsegen.params.sorts, as in Annotated[int, "
BROKEN = {
    "ImportError: No module named 'sand'": "raise ImportError(\"No module named 'sand'\")",
    "AttributeError: module 'dunes1' has no attribute 'Dune'": "pass",
    "is not a subclass of rsegen.obstacles.base.Obstacle": "class Dune: pass",
    "does not define drawn": GOOD.replace("def drawn", "def shape"),
    "defines drawn(self, rng, shape); expected drawn(self, uniform)": GOOD.replace(
        "(self, uniform)", "(self, rng, shape)"
    ),
    "has no docstring": GOOD.replace('    """Sand."""\n', ""),
    "is named sand; its entry point must have the same name": GOOD.replace('"dune"', '"sand"'),
    "the parameter 'blend' has a reserved name": GOOD.replace(
        '"dune"\n', '"dune"\n    blend: Annotated[int, Integer(1, 2, help="x")] = 1\n'
    ),
    "the parameter 'grain' has no help": GOOD.replace(
        '"dune"\n', '"dune"\n    grain: Annotated[int, Integer(1, 2)] = 1\n'
    ),
    f"the parameter 'grain' {NO_SORT}": GOOD.replace('"dune"\n', '"dune"\n    grain: Annotated[str, "x"] = "a"\n'),
}


def test_broken_plug_ins_are_named_in_a_line_each_and_the_others_work(tmp_path: Path) -> None:
    offers = ["[rsegen.obstacles]"]
    for number, source in enumerate(BROKEN.values()):
        (tmp_path / f"dunes{number}.py").write_text(source.replace('"dune"', f'"dune{number}"'))
        offers.append(f"dune{number} = dunes{number}:Dune")
    declare(tmp_path, "sandbox", "0.3", "\n".join(offers))
    found = run("obstacles", packages=tmp_path)
    assert found.returncode == 0
    assert "peak" in found.stdout
    assert "dune" not in found.stdout
    for number, (complaint, line) in enumerate(zip(BROKEN, found.stderr.splitlines(), strict=True)):
        where = f"rsegen: warning: plug-in 'dune{number}' of sandbox 0.3 (dunes{number}:Dune): "
        assert line.startswith(where)
        assert complaint in line
        assert line.endswith("; it is left out")


def test_the_broken_package_itself_is_refused(tmp_path: Path) -> None:
    installed(tmp_path, BROKEN["does not define drawn"])
    dune = ("--seed", "1", "--obstacle", "dune levels=5")
    line = refused("generate", *dune, "-o", tmp_path / "worlds", packages=tmp_path)
    assert "plug-in 'dune' of sandbox 0.3 (dunes:Dune): does not define drawn" in line
    assert not (tmp_path / "worlds").exists()


@pytest.mark.slow
def test_commands_that_do_not_need_it_say_nothing(tmp_path: Path) -> None:
    installed(tmp_path, BROKEN["does not define drawn"])
    done("preview", "peak", "-o", tmp_path / "peak.png", packages=tmp_path)
    assert (tmp_path / "peak.png").is_file()


def test_a_name_of_rsegen_s_own_cannot_be_taken(tmp_path: Path) -> None:
    installed(tmp_path, GOOD.replace('"dune"', '"peak"'), "[rsegen.obstacles]\npeak = dunes:Dune\n")
    found = run("obstacles", packages=tmp_path)
    assert "the name 'peak' is taken by rsegen; it is left out" in found.stderr
    assert "Sand." not in found.stdout


def test_of_two_packages_the_first_by_name_has_the_kind(tmp_path: Path) -> None:
    installed(tmp_path, GOOD)
    (tmp_path / "dunes2.py").write_text(GOOD)
    declare(tmp_path, "zand", "1", "[rsegen.obstacles]\ndune = dunes2:Dune\n")
    found = run("obstacles", packages=tmp_path)
    assert "Sand. From sandbox 0.3." in found.stdout
    assert "plug-in 'dune' of zand 1 (dunes2:Dune): the name 'dune' is taken by sandbox 0.3" in found.stderr


def test_a_metric_that_fails_is_named(tmp_path: Path) -> None:
    source = 'import rsegen\n\n@rsegen.metric("m")\ndef steep(field):\n    """Steepness."""\n    return 1 / 0\n'
    installed(tmp_path, source, "[rsegen.metrics]\nsteep = dunes:steep\n")
    assert "metric steep: ZeroDivisionError: division by zero" in refused("metrics", "peak", packages=tmp_path)


def test_a_metric_without_a_docstring_has_no_help_and_is_refused(tmp_path: Path) -> None:
    source = 'import rsegen\n\n@rsegen.metric("m")\ndef steep(field):\n    return 1.0\n'
    installed(tmp_path, source, "[rsegen.metrics]\nsteep = dunes:steep\n")
    found = run("metrics", "peak", packages=tmp_path)
    assert "(dunes:steep): has no help; the function needs a docstring; it is left out" in found.stderr
    assert "steep" not in found.stdout


def test_a_metric_with_a_name_of_rsegen_s_own_is_refused_with_all_of_these(tmp_path: Path) -> None:
    source = 'import rsegen\n\n@rsegen.metric("m")\ndef spread(field):\n    """Spread."""\n    return 1.0\n'
    installed(tmp_path, source, "[rsegen.metrics]\nspread = dunes:spread\n")
    found = run("metrics", "peak", packages=tmp_path)
    names = "map, opening, plane, predictions, reach, ruggedness, scale, seed, spectrum, spread, steps"
    problem = f"(dunes:spread): a metric cannot be named 'spread', as rsegen's own are {names}; it is left out\n"
    assert (found.returncode, found.stderr) == (0, f"rsegen: warning: plug-in 'spread' of sandbox 0.3 {problem}")


FORMAT = '''
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen.formats.base import Format
from rsegen.params.sorts import Flag, Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(Format):
    """Sand."""

    name: ClassVar[str] = "dune"
    OPTION: Annotated[int, Integer(1, 2, help="x")] = 1

    def files(self, scene):
        return {}
'''


@pytest.mark.parametrize(
    ("option", "complaint"),
    [
        ("force", "the parameter 'force' has a reserved name"),
        ("values", "the parameter 'values' has a reserved name"),
        ("index", "the parameter 'index' has a reserved name"),
        ("pixels", "the parameter 'pixels' exists already, with other values"),
    ],
)
def test_an_option_that_clashes_with_a_flag_is_named(option: str, complaint: str, tmp_path: Path) -> None:
    installed(tmp_path, FORMAT.replace("OPTION", option), "[rsegen.formats]\ndune = dunes:Dune\n")
    found = run("export", "--list", packages=tmp_path)
    assert found.returncode == 0
    assert complaint in found.stderr
    assert "dune\n" not in found.stdout


IMPORTER = '''
from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen.heights.base import Importer
from rsegen.params.sorts import Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(Importer):
    """Sand."""

    name: ClassVar[str] = "dune"
    suffixes: ClassVar[tuple[str, ...]] = (".dune",)
    quiet: Annotated[int, Integer(1, 2, help="x")] = 1

    def read(self, path, unit_cm):
        raise NotImplementedError
'''


def test_an_option_of_an_importer_that_clashes_with_a_flag_of_commands_is_named(tmp_path: Path) -> None:
    installed(tmp_path, IMPORTER, "[rsegen.importers]\n.dune = dunes:Dune\n")
    found = run("import", "--help", packages=tmp_path)
    assert found.returncode == 0
    assert "the parameter 'quiet' has a reserved name; rename it; it is left out" in found.stderr


def test_reserved_names_are_the_keys_of_rows_and_of_readers() -> None:
    from rsegen.heights.base import IMPORTERS
    from rsegen.params.sorts import parameters
    from rsegen.writing.sidecars import READING

    obstacles = importlib.import_module("rsegen.obstacles.base")
    assert {"kind", "first", "last", "blend", "key", "enabled"} == obstacles.RESERVED
    assert {name for cls in IMPORTERS.own() for name in parameters(cls)} == READING


SHAPE = '''
from dataclasses import dataclass
from typing import ClassVar

from rsegen.obstacles.base import Shaped


@dataclass(frozen=True, kw_only=True, slots=True)
class Dune(Shaped):
    """Sand."""

    kind: ClassVar[str] = "dune"

    def overhang(self, grid):
        return 0.0

    def profile(self, x, y, first, last, grid):
        return 1.0 + 0 * x + 0 * y
'''
OTHER_LEVELS = {
    "levels 12..12 are not all in 0..4; a profile is 0 to 1": SHAPE.replace("1.0 +", "3.0 +"),
    "profile() is not a number (nan) somewhere; use 0 to 1": SHAPE.replace("1.0 +", 'float("nan") +'),
    "drawn() gives levels of float64; expected integers": GOOD.replace('.astype("int16")', ""),
    "are not all in 0..4; a profile is 0 to 1, and drawn() gives levels": GOOD.replace("self.levels)", "99)"),
}


@pytest.mark.parametrize("complaint", OTHER_LEVELS)
def test_levels_that_a_recipe_does_not_have_are_refused(complaint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    module = module_of(OTHER_LEVELS[complaint], monkeypatch)
    recipe = Recipe(seed=7, obstacles=[module.Dune(levels=5)])
    for make in (lambda: build(recipe), lambda: build_many(recipe, range(3))):
        with pytest.raises(PluginError, match=re.escape(complaint)):
            make()


CAPABILITY = "from rsegen.params.capabilities import Capability, Command\nDECLARED = Capability(summary='sand', {})\n"


def declaring(folder: Path, fields: str, sand: str = "") -> Path:
    """A package whose capability declares these fields; its module `dunes.sand` has this source."""
    (folder / "dunes").mkdir()
    (folder / "dunes" / "__init__.py").write_text(CAPABILITY.format(fields))
    (folder / "dunes" / "sand.py").write_text(sand)
    declare(folder, "sandbox", "0.3", "[rsegen.capabilities]\nsandy = dunes:DECLARED\n")
    return folder


FINDING = "from rsegen.params.capabilities import Finding; return Finding"
NAMED = "plug-in 'sandy' of sandbox 0.3 (dunes:DECLARED): "


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ("sidecars=('dunes.gone:Sand',)", "ModuleNotFoundError: No module named 'dunes.gone'"),
        ("sidecars=('dunes.sand:Sand',)", "AttributeError: module 'dunes.sand' has no attribute 'Sand'"),
        ("sidecars=('dunes:CAPABILITY',)", "AttributeError: module 'dunes' has no attribute 'CAPABILITY'"),
        ("sidecars=('dunes:Command',)", "dunes:Command is not a subclass of rsegen.writing.sidecars.Sidecar"),
        ("commands='zap'", "its field 'commands' is not a tuple of Command"),
    ],
)
def test_a_broken_capability_does_not_stop_commands_of_rsegen(fields: str, complaint: str, tmp_path: Path) -> None:
    found = run("generate", "peak", "-o", tmp_path / "worlds", packages=declaring(tmp_path, fields))
    assert (tmp_path / "worlds" / "peak_0000" / "peak_0000.world").is_file()
    assert found.returncode == 0
    assert found.stderr.startswith(f"rsegen: warning: {NAMED}{complaint}")
    assert found.stderr.endswith("; it is left out\n")
    assert found.stderr.count("\n") == 1


SIDECAR = '''
from typing import Annotated
from rsegen.params.command import Shell
from rsegen.params.sorts import Flag
from rsegen.writing.sidecars import Sidecar


class Sand(Sidecar):
    """Sand."""

    name = "NAME"
    parameter = ANNOTATION

    def files(self, scene):
        return {}

    def are_in(self, home):
        return True


class Mud(Sand):
    """Mud."""
'''
SWITCH = "Annotated[bool, Flag(help='add sand')]"
CLASH = "which is a parameter or a flag of rsegen; rename it"


@pytest.mark.parametrize(
    ("name", "annotation", "complaint"),
    [
        *(
            (name, SWITCH, f"has the name {name!r}, {CLASH}")
            for name in ("json", "obstacle", "preview", "seed", "beside")
        ),
        ("sand", "Annotated[bool, Flag(help='add sand'), Shell(('--quiet',))]", f"has the name 'quiet', {CLASH}"),
        ("sand", "Annotated[bool, 'x']", f"the parameter 'sand' {NO_SORT}"),
        ("sand", "bool", "has no name, or its parameter is no annotated type"),
    ],
)
def test_a_sidecar_that_clashes_with_a_flag_is_left_out(
    name: str, annotation: str, complaint: str, tmp_path: Path
) -> None:
    source = SIDECAR.replace("NAME", name).replace("ANNOTATION", annotation)
    packages = declaring(tmp_path, "sidecars=('dunes.sand:Sand',)", source)
    found = run("generate", "peak", "-o", tmp_path / "worlds", packages=packages)
    assert (found.returncode, found.stderr.count("\n")) == (0, 1), found
    assert found.stderr.startswith(f"rsegen: warning: {NAMED}")
    assert complaint in found.stderr
    assert (tmp_path / "worlds" / "peak_0000" / "peak_0000.world").is_file()


def test_of_two_sidecars_with_one_name_the_first_is_taken(tmp_path: Path) -> None:
    source = SIDECAR.replace("NAME", "sand").replace("ANNOTATION", SWITCH)
    packages = declaring(tmp_path, "sidecars=('dunes.sand:Sand', 'dunes.sand:Mud')", source)
    found = run("generate", "peak", "--sand", "-o", tmp_path / "worlds", packages=packages)
    problem = "dunes.sand:Mud has the name 'sand', which is taken by dunes.sand:Sand; it is left out"
    assert (found.returncode, found.stderr) == (0, f"rsegen: warning: {NAMED}{problem}\n")


def test_no_name_of_a_flag_is_free_for_sidecars() -> None:
    from rsegen.cli.command_line import parser_of
    from rsegen.params.capabilities import commands
    from rsegen.writing.sidecars import OF_SOME, READING, RESERVED_FLAGS

    for name in {"generate", "series", "terrain", "import", "scan"} & {*commands()}:
        actions = parser_of(name).actions
        flags = [flag.removeprefix("--") for action in actions for flag in action.option_strings if flag[:2] == "--"]
        taken = {*(action.dest for action in actions), *(flag.replace("-", "_") for flag in flags)}
        assert taken <= RESERVED_FLAGS | READING | OF_SOME, name


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ("commands=(Command('help', 'measure', 'dig', 'dunes.sand'),)", "the command 'help' is taken"),
        ("commands=(Command('scan', 'measure', 'dig', 'dunes.sand'),)", "the command 'scan' is taken"),
        ("public={'dunes.sand': ('build',)}", "the public name 'build' is taken"),
    ],
)
def test_a_name_of_a_command_or_a_function_of_rsegen_cannot_be_taken(
    fields: str, complaint: str, tmp_path: Path
) -> None:
    found = run("--help", packages=declaring(tmp_path, fields))
    assert (found.returncode, found.stderr) == (0, f"rsegen: warning: {NAMED}{complaint}; it is left out\n")


def test_a_parameter_of_a_command_without_a_sort_is_refused_in_one_line(tmp_path: Path) -> None:
    sand = "from typing import Annotated\nfrom rsegen.params.command import add_flags, command\n"
    sand += "@command\ndef dig(*, grain: Annotated[str, 'x'] = 'a'): pass\n"
    sand += "def add_dig(parser): add_flags(parser, dig)\ndef run_dig(arguments): pass\n"
    declaring(tmp_path, "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)", sand)
    assert f"the parameter 'grain' {NO_SORT}" in refused("dig", packages=tmp_path)


@pytest.mark.parametrize("command", ["--help", "doctor"])
def test_a_capability_whose_import_is_interrupted_ends_in_one_line(command: str, tmp_path: Path) -> None:
    declaring(tmp_path, "")
    (tmp_path / "dunes" / "__init__.py").write_text("raise KeyboardInterrupt\n")  # as Ctrl-C does in some libraries
    found = run(command, packages=tmp_path)
    assert (found.returncode, found.stderr) == (130, "rsegen: stopped\n")


@pytest.mark.parametrize(
    "look", ["raise RuntimeError('dust')", "return 'dust'", f"{FINDING}('dust', 'T', 5, 'a', [(1,)])"]
)
def test_doctor_goes_on_if_that_of_a_capability_fails(look: str, tmp_path: Path) -> None:
    found = run("doctor", packages=declaring(tmp_path, "doctor='dunes.sand:look'", f"def look():\n    {look}\n"))
    assert found.returncode == 0
    assert "plug-in     sandbox 0.3: sandy" in found.stdout
    assert found.stderr.startswith("rsegen: warning: plug-in dunes.sand:look: ")
    assert "dust" in found.stderr


@pytest.mark.parametrize(
    ("sand", "complaint"),
    [
        ("import gone", f"{NAMED}ModuleNotFoundError: No module named 'gone'"),
        ("def add_dig_in(parser): pass", f"{NAMED}AttributeError: module 'dunes.sand' has no attribute 'run_dig_in'"),
    ],
)
def test_a_command_that_cannot_be_imported_is_of_its_package(sand: str, complaint: str, tmp_path: Path) -> None:
    declaring(tmp_path, "commands=(Command('dig-in', 'measure', 'dig', 'dunes.sand'),)", sand)
    assert refused("dig-in", packages=tmp_path) == f"rsegen: {complaint}"


@pytest.mark.parametrize("error", ["RuntimeError", "OSError"])
def test_what_fails_in_a_package_is_not_reported_as_an_error_of_rsegen(error: str, tmp_path: Path) -> None:
    sand = f"def add_dig(parser): pass\ndef run_dig(arguments):\n    raise {error}('dust')\n"
    declaring(tmp_path, "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)", sand)
    found = run("dig", packages=tmp_path)
    assert (found.returncode, found.stderr) == (1, f"rsegen: plug-in sandbox 0.3: sand.py, line 3: {error}: dust\n")


def test_an_extra_of_a_package_is_installed_as_the_package_says(tmp_path: Path) -> None:
    extra = "from rsegen.params.extras import Extra\n"
    declaring(tmp_path, "extras=(Extra('shovel', 'shovel_of_sand', 'digging'),)")
    (tmp_path / "dunes" / "__init__.py").write_text(extra + (tmp_path / "dunes" / "__init__.py").read_text())
    said = done("doctor", packages=tmp_path)
    assert "shovel_of_sand: digging\n    the manual of the plug-in that needs it says how to install it\n" in said
    with (tmp_path / "sandbox-0.3.dist-info" / "METADATA").open("a") as metadata:
        metadata.write("Provides-Extra: shovel\nRequires-Dist: shovels>=2; extra == 'shovel'\n")
    said = done("doctor", packages=tmp_path)
    assert "shovel_of_sand: digging\n" in said
    assert "-m pip install 'shovels>=2'\n" in said


DIG = """
from rsegen.cli.report import Report


def add_dig(parser):
    pass


def run_dig(arguments):
    RESULT
"""


@pytest.mark.parametrize(
    ("result", "code", "line"),
    [
        ("import sys; sys.exit(0)", 1, "plug-in sandbox 0.3: sand.py, line 10: SystemExit: 0"),
        ("import sys; sys.exit('enough')", 1, "plug-in sandbox 0.3: sand.py, line 10: SystemExit: enough"),
        ("return 3", 2, "plug-in sandbox 0.3: the command dig gave 3; expected a rsegen.cli.report.Report"),
        ("return Report(lines=['a'], content=None, code='0')", 2, "plug-in sandbox 0.3: the command dig gave Report("),
        ("return Report(lines=[1], content=1)", 1, "error in rsegen, or in what a plug-in gave it (sandbox 0.3): "),
    ],
)
def test_a_command_that_ends_python_or_gives_no_report_is_of_its_package(
    result: str, code: int, line: str, tmp_path: Path
) -> None:
    command = "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)"
    found = run("dig", packages=declaring(tmp_path, command, DIG.replace("RESULT", result)))
    assert (found.returncode, found.stdout, found.stderr.count("\n")) == (code, "", 1)
    assert found.stderr.startswith(f"rsegen: {line}")


def test_an_internal_error_names_packages_that_are_used_alone(tmp_path: Path) -> None:
    declaring(
        tmp_path, "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)", "def add_dig(): pass\nrun_dig = 3\n"
    )
    failing = "import sys, rsegen.cli.doctor as doctor; from rsegen.cli.edge import main; doctor.hooks = None"
    found = run(packages=tmp_path, code=f"{failing}; sys.exit(main(['doctor']))")
    assert (found.returncode, found.stderr.count("\n")) == (1, 1)
    assert found.stderr.startswith("rsegen: internal error, please report it: TypeError: ")


@pytest.mark.parametrize(
    ("add", "problem"),
    [
        ("()", "TypeError: add_dig() takes 0 positional arguments but 1 was given"),
        ("(parser, *, more)", "TypeError: add_dig() missing 1 required keyword-only argument: 'more'"),
        ("(parser): raise ValueError('dust')", "ValueError: dust"),
    ],
)
def test_a_command_that_cannot_add_its_flags_is_left_out_of_the_page(add: str, problem: str, tmp_path: Path) -> None:
    sand = f"def add_dig{add if ':' in add else f'{add}: pass'}\ndef run_dig(arguments): pass\n"
    declaring(tmp_path, "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)", sand)
    assert refused("dig", packages=tmp_path) == f"rsegen: {NAMED}{problem}"
    listed = run(packages=tmp_path, code=FORMS)
    assert listed.stdout.split() == ["True", "False", "True", "False"]
    assert listed.stderr.count(f"{NAMED}{problem}; it is left out") == 1


FORMS = """
from rsegen.page.command_forms import command_forms
from rsegen.page.manual import manual_page

print("drive" in command_forms(), "dig" in command_forms())
print('id="drive"' in manual_page(), 'id="dig"' in manual_page())
"""


def test_a_metric_may_be_an_integer_beyond_all_floats() -> None:
    assert Metric.of(lambda field: 10**400)(build(Recipe(seed=1))) == float("inf")
