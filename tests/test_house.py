"""The house keeps its promises."""

from __future__ import annotations

import ast
import io
import json
import pkgutil
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

import rsegen
from rsegen import KINDS
from rsegen.cli.edge import main
from rsegen.errors import RsegenError
from rsegen.params.capabilities import CORE
from rsegen.recipe.codec import schema
from rsegen.recipe.examples import EXAMPLES

ROOT = Path(__file__).parents[1]
HOUSE = ROOT / "src" / "rsegen"
ENTRIES = 34

SINCE_NUMPY_2 = {
    *("acos", "acosh", "asin", "asinh", "astype", "atan", "atan2", "atanh", "bitwise_count", "bitwise_invert"),
    *("bitwise_left_shift", "bitwise_right_shift", "bool", "concat", "cumulative_prod", "cumulative_sum", "isdtype"),
    *("long", "matrix_transpose", "matvec", "permute_dims", "pow", "strings", "trapezoid", "ulong", "unique_all"),
    *("unique_counts", "unique_inverse", "unique_values", "unstack", "vecdot", "vecmat"),
}


def test_the_house_is_taken_in_at_a_glance() -> None:
    entries = {path.name for path in HOUSE.iterdir()} - {"py.typed", "__pycache__"}
    assert len(entries) <= ENTRIES, sorted(entries)


def test_no_module_imports_itself_by_way_of_others() -> None:
    """Imports inside functions count; those for type checkers do not."""
    graph = grimp.build_graph("rsegen", exclude_type_checking_imports=True, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert set(TopologicalSorter(imports).static_order()) == graph.modules  # or a CycleError that names the circle


def test_the_core_names_no_folder_beyond_it_for_type_checkers_either() -> None:
    graph = grimp.build_graph("rsegen", cache_dir=None)
    folders = {path.name for path in HOUSE.iterdir() if path.is_dir()}
    named = {
        (folder_of(module), folder_of(imported))
        for module in graph.modules
        for imported in graph.find_modules_directly_imported_by(module)
    }
    beyond = {folder: folders - {*CORE[: CORE.index(folder) + 1]} for folder in CORE}
    beyond |= {path.stem: folders - {*CORE} for path in HOUSE.glob("*.py")}  # modules that belong to no folder
    assert {(folder, imported) for folder, imported in named if imported in beyond.get(folder, ())} == set()


def test_modules_of_the_house_are_not_imported_by_name() -> None:
    """A name in a text hides an import from the tests above; `rsegen` itself imports what capabilities declare."""
    declared = {HOUSE / "__init__.py", HOUSE / "params" / "capabilities.py"}
    by_name = re.compile(r"""import_module\(f?["']rsegen\b""")
    texts = {path: path.read_text("utf-8") for path in HOUSE.rglob("*.py") if path not in declared}
    assert [str(path) for path, text in texts.items() if by_name.search(text)] == []


def folder_of(module: str) -> str:
    """Return the folder of src/rsegen in which a module is, or its own name."""
    return ".".join(module.split(".")[1:2])


def test_no_function_is_called_that_the_oldest_numpy_has_not() -> None:
    """It is 1.26. `library` is numpy, torch or jax.numpy (learning/arrays.py), so it has numpy's names."""
    called = {
        (path.name, node.attr)
        for path in HOUSE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Attribute) and node.attr in SINCE_NUMPY_2
        if ast.unparse(node.value) in {"np", "library", "self.library"}
    }
    assert called == set()


def test_public_names_are_all_there() -> None:
    public = rsegen.__all__
    assert all(hasattr(rsegen, name) for name in public)
    assert set(public) <= set(dir(rsegen))


def test_no_public_name_is_hidden_by_a_module() -> None:
    """Importing any module of rsegen leaves `rsegen.build` and the like what they are: functions and classes."""
    modules = {module.name for module in pkgutil.iter_modules(rsegen.__path__)}
    assert not modules & set(rsegen.__all__)


PACKAGES = sorted(path.parent for path in HOUSE.rglob("__init__.py"))


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.relative_to(HOUSE.parent).as_posix())
def test_no_name_of_a_package_hides_its_module(package: Path) -> None:
    """`from rsegen.geometry import boxes` gives a function whether or not a module was imported before."""
    body = ast.walk(ast.parse((package / "__init__.py").read_text("utf-8")))
    names = {name.asname or name.name for node in body if isinstance(node, ast.ImportFrom) for name in node.names}
    assert not names & {module.name for module in pkgutil.iter_modules([str(package)])}


CLAUSES = "Because|How|If|Since|So|Than|There|Unless|Until|What|When|Where|Whether|While|Who|Whose|Why"
CODE = ("src", "tests", "benchmarks", "docs", "scripts", "examples")


def test_docstrings_begin_with_a_noun_or_a_verb() -> None:
    """As STYLE.md has it: a clause alone is no sentence."""
    clauses = [
        f"{path.relative_to(ROOT)}: {found[0].strip()}"
        for folder in CODE
        for path in sorted((ROOT / folder).rglob("*.py"))
        for found in re.finditer(rf'^ *"""({CLAUSES})\b.*', path.read_text("utf-8"), re.MULTILINE)
    ]
    assert not clauses, clauses


LONG = 20
"""Lines of a function's body, without its docstring, from which on a comment says where they stand in the idea."""


def test_long_functions_have_a_comment() -> None:
    written = HOUSE / "ros2" / "package_files"  # files of users' packages, whose bytes stay
    paths = [path for path in HOUSE.rglob("*.py") if written not in path.parents]
    assert [place for path in paths for place in bare_functions(path)] == []


def bare_functions(path: Path) -> Iterator[str]:
    """Yield the long functions of a module that have no comment."""
    text = path.read_text("utf-8")
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    about_checkers = ("# type:", "# noqa", "# pragma")
    commented = {
        token.start[0]
        for token in tokens
        if token.type == tokenize.COMMENT and not token.string.startswith(about_checkers)
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            body = node.body[1:] if ast.get_docstring(node) else node.body
            lines = range(node.lineno, (node.end_lineno or 0) + 1)
            if body and lines.stop - body[0].lineno >= LONG and commented.isdisjoint(lines):
                yield f"{path.relative_to(HOUSE)}:{node.lineno} {node.name}"


def test_every_obstacle_class_is_public_by_name() -> None:
    assert {cls.__name__ for cls in KINDS.values()} <= set(dir(rsegen))


def test_error_tree_in_the_docstring_is_the_error_tree() -> None:
    def tree(cls: type) -> set[str]:
        below: list[type] = cls.__subclasses__()
        return {cls.__name__}.union(*map(tree, below))

    drawn = (sys.modules["rsegen.errors"].__doc__ or "").split()
    assert tree(RsegenError) <= set(drawn)


HEAVY = [
    "matplotlib",
    "tqdm",
    "psutil",
    "yaml",
    "starlette",
    "PIL",
    "scipy",
    "trimesh",
    "pxr",
    "pyarrow",
    "distributed",
]


def test_import_is_light() -> None:
    code = f"import rsegen.cli, sys; print(sorted(set({HEAVY}) & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout == "[]\n"


def test_python_m_runs_the_command() -> None:
    found = subprocess.run([sys.executable, "-m", "rsegen", "--version"], capture_output=True, text=True, check=True)
    assert found.stdout == f"rsegen {rsegen.__version__}\n"


@pytest.mark.parametrize("path", EXAMPLES.values(), ids=lambda path: path.stem)
def test_an_example_is_named_after_its_file_described_and_seeded(path: Path) -> None:
    recipe = rsegen.load(path)
    assert recipe.name == path.stem
    assert recipe.description
    assert "seed:" in path.read_text("utf-8")


def test_the_examples_use_every_kind() -> None:
    used = {obstacle.kind for path in EXAMPLES.values() for obstacle in rsegen.load(path).obstacles}
    assert used == set(KINDS) - {"platform"}  # the examples are those of the paper and of NIST, which have none


def test_published_schema_is_current() -> None:
    assert json.loads((ROOT / "docs" / "recipe.schema.json").read_text("utf-8")) == schema()


GOLDEN = sorted((ROOT / "tests" / "golden").glob("*.yaml"))


@pytest.mark.parametrize("recipe", GOLDEN, ids=lambda path: path.stem)
def test_golden_maps(tmp_path: Path, recipe: Path) -> None:
    """Byte for byte; CONTRIBUTING.md says how to write them anew."""
    assert main(["generate", str(recipe), "-o", str(tmp_path)]) == 0
    (made,) = tmp_path.iterdir()
    expected = recipe.parent / made.name
    names = {str(path.relative_to(made)) for path in made.rglob("*") if path.is_file()}
    assert names == {str(path.relative_to(expected)) for path in expected.rglob("*") if path.is_file()}
    for name in names:
        assert (made / name).read_text("utf-8") == (expected / name).read_text("utf-8"), name
