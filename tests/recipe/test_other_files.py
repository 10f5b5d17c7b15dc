"""A file that is no recipe is named by what it is, with the command that reads it."""

from __future__ import annotations

from pathlib import Path

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import FileError
from rsegen.params.capabilities import commands

PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"
FILES: dict[str, tuple[bytes, str, tuple[str, ...]]] = {
    "photo.png": (PNG, "a PNG image", ("import", "scan")),
    "photo": (PNG, "a PNG image", ()),
    "recipe.yaml": (PNG, "a PNG image", ()),
    "photo.JPG": (b"\xff\xd8\xff\xe0", "a JPEG image", ("import",)),
    "depth.tif": (b"II*\0\x08", "a TIFF image", ("import", "scan")),
    "map.pgm": (b"P5\n2 2\n255\n\xff\xff\0\0", "a PGM image", ("import", "scan")),
    "map.yaml": (b"image: map.pgm\nresolution: 0.1\n", "a .yaml file", ("import",)),
    "heights.csv": (b"1,2\n3,4\n", "a .csv file", ("import", "scan")),
    "heights.npy": (b"\x93NUMPY\x01\0", "a numpy array", ("import", "scan")),
    "cloud.ply": (b"ply\nformat ascii 1.0\n", "a PLY file", ("scan",)),
    "cloud.pcd": (b"# .PCD v0.7\n", "a PCD file", ("scan",)),
    "cloud.laz": (b"LASF\0\xff", "a LAS or LAZ file", ("scan",)),
    "mesh.obj": (b"v 0 0 0\nf 1 1 1\n", "a .obj file", ("scan",)),
    "mesh.glb": (b"glTF\x02\0\0\0\xff", "a GLB file", ("scan",)),
    "run.mcap": (b"\x89MCAP0\r\n", "a .mcap file", ("import", "scan")),
    "robot.urdf": (b'<?xml version="1.0"?>\n<!-- of us -->\n<robot name="r"/>\n', "a robot in URDF", ("robot",)),
    "robot.sdf": (b'<sdf version="1.6"><model name="m"/></sdf>', "an SDF file", ("robot",)),
    "robot.xml": (b"<mujoco/>", "a model in MJCF", ("robot",)),
    "field.world": (b'<sdf version="1.6"><world name="w"/></sdf>', "an SDF file", ("open",)),
    "sheet.pdf": (b"%PDF-1.4\n\xff", "a PDF file", ()),
}


@pytest.mark.parametrize("name", FILES)
def test_what_a_file_is_and_what_reads_it(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content, what, readers = FILES[name]
    file = tmp_path / name
    file.write_bytes(content)
    for words in (["generate", str(file), "-o", str(tmp_path / "out")], ["info", str(file)]):
        assert main(words) == 2
        (line,) = capsys.readouterr().err.splitlines()
        is_here = any(reader in commands() for reader in readers)
        if what.startswith("a .") and not is_here:
            continue  # known by its ending alone, and by nobody
        assert line.startswith(f"rsegen: {file}: {what}, and not a recipe" + ("; use rsegen " if is_here else ""))
        assert [f"rsegen {reader}" in line for reader in readers] == [reader in commands() for reader in readers]
        assert line.count("rsegen ") == sum(reader in commands() for reader in readers)


def test_a_file_of_a_map_leads_to_the_recipe_in_its_folder(tmp_path: Path) -> None:
    (made,) = rsegen.generate(rsegen.Recipe(seed=1), tmp_path).maps
    with pytest.raises(FileError) as error:
        rsegen.load(made.world)
    assert str(error.value).endswith(f"an SDF file, and not a recipe; use its folder, which has one: {made.folder}")


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("recipe.yaml", b"unit_cm: x\n", "unit_cm: 'x' is not a number"),
        ("recipe.txt", b"unit_cm: [\n", "not YAML"),
        ("recipe.json", b"{", "not JSON"),
        ("recipe.yaml", b"\xff\xfe\0", "not a text in UTF-8"),
    ],
)
def test_a_recipe_with_a_mistake_is_a_recipe(name: str, content: bytes, problem: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(rsegen.UserError, match=problem):
        rsegen.load(tmp_path / name)
    with pytest.raises(FileError, match="No such file"):
        rsegen.load(tmp_path / "none.png")


def test_a_recipe_may_have_any_ending(tmp_path: Path) -> None:
    (tmp_path / "recipe.csv").write_text("seed: 4\n")
    assert rsegen.load(tmp_path / "recipe.csv") == rsegen.Recipe(seed=4)
