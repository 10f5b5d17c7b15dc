"""A package that is broken is said so in one line, and is in nobody's way."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from rsegen import Recipe, build, build_many
from rsegen.errors import PluginError
from tests.plugins.installed import declare, done, refused, run

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
}


def installed(folder: Path, source: str, offers: str = "[rsegen.obstacles]\ndune = dunes:Dune\n") -> Path:
    (folder / "dunes.py").write_text(source)
    declare(folder, "sandbox", "0.3", offers)
    return folder


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
        ("pixels", "the parameter 'pixels' exists already, with other values"),
    ],
)
def test_an_option_that_clashes_with_a_flag_is_named(option: str, complaint: str, tmp_path: Path) -> None:
    installed(tmp_path, FORMAT.replace("OPTION", option), "[rsegen.formats]\ndune = dunes:Dune\n")
    found = run("export", "--list", packages=tmp_path)
    assert found.returncode == 0
    assert complaint in found.stderr
    assert "dune\n" not in found.stdout


def test_reserved_names_are_the_keys_of_rows_and_of_readers() -> None:
    from rsegen.formats.base import READING
    from rsegen.heights.base import IMPORTERS
    from rsegen.params.sorts import parameters

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
    module = ModuleType("dunes")
    monkeypatch.setitem(sys.modules, "dunes", module)
    exec(OTHER_LEVELS[complaint], vars(module))  # noqa: S102  # as a plug-in is run
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


@pytest.mark.parametrize("look", ["raise RuntimeError('dust')", "return 'dust'"])
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


def test_what_fails_in_a_package_is_not_reported_as_an_error_of_rsegen(tmp_path: Path) -> None:
    sand = "def add_dig(parser): pass\ndef run_dig(arguments):\n    raise RuntimeError('dust')\n"
    declaring(tmp_path, "commands=(Command('dig', 'measure', 'dig', 'dunes.sand'),)", sand)
    found = run("dig", packages=tmp_path)
    assert (found.returncode, found.stderr) == (1, "rsegen: plug-in sandbox 0.3: sand.py, line 3: RuntimeError: dust\n")


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
