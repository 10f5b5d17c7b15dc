"""Scans and comparisons that cannot be: one line each, and nothing is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import rsegen
from rsegen import Recipe
from tests.support.complaints import Refused

COMMANDS: Mapping[str, tuple[list[str], str]] = {
    "one point": (["scan", "few.xyz", "-o", "out"], "the cloud is 0 m wide"),
    "no file": (["scan", "none.ply", "-o", "out"], "none.ply: No such file"),
    "no cloud": (["scan", "a.yaml", "-o", "out"], "clouds are read from files named"),
    "an unknown unit": (["scan", "few.xyz", "-o", "out", "--values", "miles"], "values"),
    "too few intrinsics": (["scan", "few.xyz", "-o", "out", "--intrinsics", "1,2,3"], "intrinsics"),
    "intrinsics of points": (["scan", "few.xyz", "-o", "out", "--intrinsics", "1,2,3,4"], "not the depths of an image"),
    "no picture": (["scan", "few.xyz", "-o", "out", "--fit", "fit.docx"], "fit.docx"),
    "no map": (["compare", "few.xyz"], "only few.xyz was passed"),
    "three maps": (["compare", "a.yaml", "a.yaml", "a.yaml"], "pass clouds of one field and a map, or two maps"),
    "a map that is not there": (["compare", "few.xyz", "none.yaml"], "none.yaml"),
    "another size": (["compare", "b.yaml", "a.yaml"], "14 x 14 and 12 x 12 cells"),
    "no picture of a comparison": (["compare", "a.yaml", "a.yaml", "-o", "off.docx"], "off.docx"),
    "a picture that exists": (["compare", "a.yaml", "a.yaml", "-o", "there.png"], "exists already"),
}


@pytest.mark.parametrize("what", COMMANDS)
def test_one_line(what: str, tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "few.xyz").write_text("1 2 3\n" * 600, "utf-8")
    (tmp_path / "there.png").write_bytes(b"a picture")
    rsegen.save(Recipe(seed=1), tmp_path / "a.yaml")
    rsegen.save(Recipe(seed=1, chunk_size=12), tmp_path / "b.yaml")
    arguments, said = COMMANDS[what]
    assert said in refused(*arguments)


FACET = "facet normal {}\n outer loop\n  vertex 0 0 0\n  vertex {} 0 0\n  vertex 0 1 0\n endloop\nendfacet\n"


@pytest.mark.slow
@pytest.mark.parametrize("normal", ["0 0 1e", "0 0 1"])
@pytest.mark.parametrize("vertex", ["1e", "1x", "9" * 5000, "1"])
def test_a_damaged_stl_is_one_line_whatever_trimesh_logs(
    normal: str, vertex: str, tmp_path: Path, refused: Refused
) -> None:
    (tmp_path / "x.stl").write_text(f"solid a\n{FACET.format(normal, vertex)}endsolid a\n", "utf-8")
    refused("scan", "x.stl", "-o", "out")
