"""Commands, flags, and what they are pointed at; outputs that exist; more than there is room for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from rsegen.params.capabilities import commands
from tests.support.complaints import (
    OBSTACLE,
    Refused,
    exit_code,
    recipe,
)

COMMAND_LINES: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "maps beyond every index": (
        ["generate", *OBSTACLE, "--maps", "9" * 400, "-o", "out"],
        ["maps: 999", "first_map 0", "9223372036854775807"],
    ),
    "a misspelt command": (
        ["genrate"],
        [
            "'genrate'",
            "did you mean 'generate'?",
            "info, man, metrics, obstacles, open, predict, preview, rate, remove, respawn, robot, scan, schema, series",
        ],
    ),
    "a command of two lines": (["a\nb"], ["'a\\nb'", "generate, gui, import, info"]),
    "a misspelt flag": (["generate", "-o", "out", "--sed", "1"], ["'--sed'", "did you mean '--seed'?"]),
    "half a flag": (["generate", "-o", "out", "--chunk", "1"], ["'--chunk'", "did you mean '--chunks'?"]),
    "another command's flag": (["info", "recipe.yaml", "--force"], ["unknown flag '--force'"]),
    "a flag for what stands without one": (
        ["rate", "--robot", "burger"],
        ["unknown flag '--robot'; ROBOT stands without a flag here"],
    ),
    "the file of a robot in a recipe": (
        ["generate", *OBSTACLE, "--crossable-by", "my/robot.urdf", "-o", "out"],
        ["--crossable-by: 'my/robot.urdf' is a file", "use a kind of robot (burger, crawler, jackal)"],
    ),
    "two recipes": (["generate", "a.yaml", "b.yaml", "-o", "out"], ["unexpected argument 'b.yaml'"]),
    "no output": (["generate"], ["-o/--output"]),
    "an output of no name": (["generate", "-o", ""], ["-o/--output", "expected a folder"]),
    "a recipe of no name": (["generate", "", "-o", "out"], ["directory"]),
    "a flag without its value": (["generate", "-o", "out", "--seed"], ["--seed", "expected one argument"]),
    "no worker": (["generate", "-o", "out", "--workers", "0"], ["--workers: 0 is not 1 or more"]),
    "workers in a word": (["generate", "-o", "out", "--workers", "all"], ["--workers: 'all' is not a whole number"]),
    "a port in a word": (["gui", "--port", "http"], ["--port: 'http' is not a whole number"]),
    "to keep maps and to replace them": (
        ["generate", "-o", "out", "--force", "--resume"],
        ["--resume and --force exclude each other"],
    ),
    "an obstacle without quotes": (
        ["generate", "--obstacle", "peak", "levels=5", "-o", "out"],
        ["put quotes around the obstacle: --obstacle 'peak levels=5' ("],
    ),
    "an obstacle of many words without quotes": (
        ["generate", "-o", "out", "--obstacle=peak", "levels=5", "first=2,2"],
        ["put quotes around the obstacle: --obstacle 'peak levels=5 first=2,2' ("],
    ),
    "a recipe that is not there": (
        ["generate", "no.yaml", "-o", "out"],
        ["no.yaml: No such file or directory in /", "/test_a_command_line"],
    ),
    "a recipe in a file": (["generate", "file/r.yaml", "-o", "out"], ["file/r.yaml: Not a directory"]),
    "a recipe of too long a name": (["generate", "n" * 300, "-o", "out"], ["nnn: File name too long"]),
    "a folder without a recipe": (
        ["generate", "folder", "-o", "out"],
        ["folder: ", "recipe.json", "use a recipe file"],
    ),
    "a link to itself": (["info", "loop"], ["loop: Too many levels of symbolic links"]),
    "a target that is not there": (["info", "no.yaml"], ["no.yaml: No such file or directory in /"]),
    "a target without maps": (["info", "folder"], ["folder: no map in it"]),
    "a target of another sort": (["info", "file"], ["file: 'not a recipe' is not a recipe"]),
    "a world that is not there": (["open", "no.world"], ["no.world: No such file or directory in /"]),
    "a world that is a recipe": (["open", "no.yaml"], ["no.yaml: No such file"]),
    "a simulator of another name": (
        ["open", "two.yaml", "--simulator", "clasic"],
        ["--simulator", "'clasic'", "did you mean 'classic'?", "(known: classic, mujoco, sim)"],
    ),
    "neither a map nor a robot": (["spawn", "burgr"], ["'burgr'", "did you mean 'burger'?"]),
    "a place of one number": (["spawn", "burger", "--at", "1"], ["--at: '1' is not X,Y or X,Y,Z or X,Y,Z,YAW"]),
    "a place in words": (["spawn", "burger", "--at", "1,here"], ["--at", "'here' is not a number"]),
    "a map of a robot": (["spawn", "burger", "--map", "1"], ["--map: burger is a robot"]),
    "a pose of no robot": (["spawn", "two.yaml", "--pose", "0,0,0"], ["--pose: is the place of a robot", "set robot"]),
    "a robot on a robot": (["spawn", "burger", "--robot", "crawler"], ["--robot: burger is a robot already"]),
    "a name with a slash": (["spawn", "burger", "--name", "../b"], ["--name: invalid value '../b'"]),
    "seconds in a word": (["open", "two.yaml", "--seconds", "few"], ["--seconds: 'few' is not a number"]),
    "an index beyond": (["info", "two.yaml", "--map", "2"], ["--map", "'2'", "two.yaml", "rse_0000..rse_0001"]),
    "an index below": (["info", "two.yaml", "--map=-1"], ["--map", "'-1'", "rse_0000..rse_0001"]),
    "an index that is a word": (["info", "two.yaml", "--map", "last"], ["--map", "'last'", "rse_0000..rse_0001"]),
    "another map's name": (["info", "two.yaml", "--map", "map_0001"], ["--map", "'map_0001'", "rse_0000..rse_0001"]),
    "an index of many digits": (["info", "two.yaml", "--map", "9" * 9000], ["--map", "'999", "rse_0000..rse_0001"]),
    "an output that is a file": (["generate", "-o", "file"], ["file: is a file; use a folder"]),
    "an output in a file": (["generate", "-o", "file/a/b"], ["file/a/b: cannot be written: Not a directory"]),
    "an output of too long a name": (["generate", "-o", "n" * 300], ["nnn: ", "File name too long"]),
    "an output on a device": (["generate", "-o", "/dev/null"], ["/dev/null: is a file"]),
    "an output where nothing can be": (["generate", "-o", "/proc/a/b"], ["/proc/a/b: cannot be written"]),
    "a picture without an ending": (["preview", "two.yaml", "-o", "picture"], ["picture: ", ".png, .svg, .pdf"]),
    "a picture of another ending": (["preview", "two.yaml", "-o", "p.bmp"], ["p.bmp: ", ".png, .svg, .pdf"]),
    "a picture of an ending only": (["preview", "two.yaml", "-o", ".png"], [".png: ", "a picture's name must end in"]),
    "a picture of no name": (["preview", "two.yaml", "-o", ""], ["a picture's name must end in"]),
    "a picture that is there": (["preview", "two.yaml", "-o", "old.png"], ["old.png: exists already", "--force"]),
    "a picture that is a folder": (
        ["preview", "two.yaml", "-o", "folder.png", "--force"],
        ["folder.png: exists already and is not a file"],
    ),
    "a picture in a file": (["preview", "two.yaml", "-o", "file/p.png"], ["file/p.png: cannot be written"]),
    "a picture of a map beyond": (["preview", "two.yaml", "-o", "p.png", "--map", "2"], ["--map", "rse_0001"]),
    "a series of one map": (["series", *OBSTACLE, "-o", "out"], ["maps: 1 map is not a series; use 2 or more"]),
    "a series of no map": (["series", *OBSTACLE, "--maps", "0", "-o", "out"], ["maps: 0 is not 1 or more"]),
    "a series without an output": (["series", "two.yaml"], ["-o/--output"]),
    "a series that falls": (
        ["series", "two.yaml", "--from", "0.9", "--to", "0.2", "-o", "out"],
        ["from: 0.9 is above to, 0.2"],
    ),
    "a series from below": (["series", "two.yaml", "--from=-0.1", "-o", "out"], ["--from: -0.1 is outside 0..1"]),
    "a series to beyond": (["series", "two.yaml", "--to", "1.5", "-o", "out"], ["--to: 1.5 is outside 0..1"]),
    "a series to a word": (["series", "two.yaml", "--to", "hard", "-o", "out"], ["--to: 'hard' is not a number"]),
    "a series of one difficulty": (
        ["series", "two.yaml", "--difficulty", "0.5", "-o", "out"],
        ["difficulty: 0.5 is for maps of one difficulty", "from and to"],
    ),
    "a series of too long a name": (
        ["series", "two.yaml", "--name", "n" * 62, "--same-field", "-o", "out"],
        ["name: invalid value 'nnn", "1..64 letters"],
    ),
    "a series in a file": (["series", "two.yaml", "-o", "file"], ["file: is a file; use a folder"]),
    "a series of more than there is room for": (
        ["series", "--maps", "2", "--chunks", "1000000", "-o", "out"],
        ["chunks: a map of", "fewer chunks"],
    ),
    "an export to nothing": (["export", "two.yaml", "-o", "out"], ["--to"]),
    "an export to another format": (
        ["export", "two.yaml", "--to", "stl,gbl", "-o", "out"],
        ["--to: unknown format 'gbl'", "did you mean 'glb'?", "known: "],
    ),
    "an export to no format": (["export", "two.yaml", "--to", "", "-o", "out"], ["--to: unknown format ''"]),
    "an export to one format twice": (["export", "two.yaml", "--to", "ply,ply", "-o", "out"], ["ply is given twice"]),
    "an export of no map": (["export", "folder", "--to", "ply", "-o", "out"], ["folder: no map in it"]),
    "an export of a map beyond": (
        ["export", "two.yaml", "--to", "ply", "-o", "out", "--map", "2"],
        ["--map", "'2'", "rse_0000..rse_0001"],
    ),
    "an export into a file": (["export", "two.yaml", "--to", "ply", "-o", "file"], ["file: is a file; use a folder"]),
    "a world with another format": (["generate", "-o", "out", "--formats", "sdf"], ["--formats: unknown format 'sdf'"]),
    "a sheet of another ending": (
        ["sheet", "two.yaml", "-o", "s.png"],
        ["s.png: a build sheet must be a .pdf or .csv file"],
    ),
    "a sheet of no name": (["sheet", "two.yaml", "-o", ""], ["a build sheet must be"]),
    "a sheet that is there": (["sheet", "two.yaml", "-o", "old.csv"], ["old.csv: exists already", "--force"]),
    "a sheet beside a table that is there": (
        ["sheet", "two.yaml", "-o", "s.pdf", "--csv", "old.csv"],
        ["old.csv: exists already", "--force"],
    ),
    "a sheet of two tables": (
        ["sheet", "two.yaml", "-o", "s.csv", "--csv", "t.csv"],
        ["--csv: t.csv with -o s.csv", "-o one in .pdf"],
    ),
    "a sheet whose table is no table": (
        ["sheet", "two.yaml", "-o", "s.pdf", "--csv", "t.pdf"],
        ["--csv: t.pdf with -o s.pdf"],
    ),
    "a sheet in a file": (["sheet", "two.yaml", "-o", "file/s.pdf"], ["file/s.pdf: cannot be written"]),
    "a sheet of a map beyond": (["sheet", "two.yaml", "-o", "s.pdf", "--map", "2"], ["--map", "rse_0001"]),
    "a sheet of no map": (["sheet", "folder", "-o", "s.pdf"], ["folder: no map in it"]),
    "a sheet for a saw in a word": (
        ["sheet", "two.yaml", "-o", "s.pdf", "--kerf-mm", "thin"],
        ["--kerf-mm: 'thin' is not a number; expected 0..100 mm"],
    ),
    "a sheet for a saw below": (["sheet", "two.yaml", "-o", "s.pdf", "--kerf-mm=-1"], ["--kerf-mm: -1.0 is outside"]),
    "a sheet for no timber": (["sheet", "two.yaml", "-o", "s.pdf", "--stock-cm", "0"], ["--stock-cm: 0.0 is outside"]),
    "a sheet for short timber": (
        ["sheet", "peak", "-o", "s.pdf", "--stock-cm", "30"],
        ["--stock-cm: 30 cm is too short for blocks of the highest level", "or more"],
    ),
    "a sheet of large pallets": (
        ["sheet", "large.yaml", "-o", "s.pdf"],
        ["chunk_size: 61 blocks per side", "use up to 60"],
    ),
    "sheets of large pallets": (
        ["generate", "large.yaml", "-o", "out", "--sheet"],
        ["chunk_size: 61 blocks per side", "use up to 60"],
    ),
    "sheets of many pallets": (
        ["generate", "--chunks", "21", "--chunk-size", "2", "-o", "out", "--sheet"],
        ["chunks: 441 pallets with 1,764 blocks", "use up to 400"],
    ),
    "metrics of a map beyond": (["metrics", "two.yaml", "--map", "2"], ["--map", "'2'", "rse_0000..rse_0001"]),
    "metrics of no map": (["metrics", "folder"], ["folder: no map in it"]),
    "metrics for a robot of another name": (["metrics", "two.yaml", "--robot", "burgr"], ["--robot", "'burger'"]),
    "metrics for a width alone": (
        ["metrics", "two.yaml", "--width-cm", "5"],
        ["--climb-cm: choose a robot", "--robot"],
    ),
    "metrics of a climb in a word": (
        ["metrics", "two.yaml", "--climb-cm", "high"],
        ["--climb-cm: 'high'", "100000 cm"],
    ),
    "metrics of a climb below": (
        ["metrics", "two.yaml", "--climb-cm=-1"],
        ["--climb-cm: -1.0 is outside 0..100000 cm"],
    ),
    "metrics of a climb of no number": (["metrics", "two.yaml", "--climb-cm", "nan"], ["--climb-cm: nan"]),
    "metrics in two forms": (["metrics", "two.yaml", "--json", "--csv"], ["--json and --csv exclude each other"]),
    "a data set nowhere": (["dataset", *OBSTACLE], ["one of the arguments -o/--output --verify is required"]),
    "a data set of no map": (["dataset", "-o", "out", "--maps", "0"], ["maps: 0 is not 1 or more"]),
    "a data set in a folder of other things": (["dataset", "-o", "."], [".: is not empty, and not a data set"]),
    "a data set in a file": (["dataset", "-o", "file"], ["file: is a file; use a folder"]),
    "metrics in another form": (["dataset", "-o", "out", "--metrics", "csv"], ["metrics: 'csv'", "npy, parquet, none"]),
    "shards of less than a map": (["dataset", "-o", "out", "--shard-maps=-1"], ["--shard-maps: -1 is outside 0.."]),
    "shards without number": (
        ["dataset", "-o", "out", "--maps", "1000000", "--shard-maps", "1"],
        ["--shard-maps: 1 would make 1000000 shards; use 10 or more"],
    ),
    "to go on and to replace": (
        ["dataset", "-o", "out", "--force", "--resume"],
        ["--resume and --force exclude each other"],
    ),
    "to check what is no data set": (["dataset", "--verify", "folder"], ["folder: has no manifest.json"]),
    "to check a recipe": (["dataset", "two.yaml", "--verify", "folder"], ["--verify: needs no recipe"]),
    "to check and to make": (
        ["dataset", "-o", "out", "--verify", "folder"],
        ["--verify: not allowed with argument -o"],
    ),
    "a map of what is no data set": (["info", "folder#1"], ["folder: has no manifest.json"]),
    "a map of nothing": (["generate", "nowhere#1", "-o", "out"], ["nowhere: has no manifest.json"]),
    "a map in a file": (["info", "two.yaml#1"], ["two.yaml: has no manifest.json"]),
    "a map of a word": (["info", "folder#first"], ["folder#first: No such file"]),
    "tracks of a kind": (["drive", "two.yaml", "--tracks", "a,b"], ["--tracks: is for the robot of a file; 'burger'"]),
    "wheels and tracks": (
        ["drive", "two.yaml", "--robot", "cart.sdf", "--wheels", "a,b", "--tracks", "c,d"],
        ["--tracks: excludes wheels"],
    ),
    "arguments of a robot without macros": (
        ["spots", "two.yaml", "--robot", "cart.sdf a:=b"],
        ["cart.sdf: a:= is for"],
    ),
    "metrics drawn without a robot": (["metrics", "two.yaml", "-o", "p.png"], ["-o/--output", "--climb-cm 10"]),
    "metrics drawn on a text": (["metrics", "two.yaml", "-o", "p.txt"], ["p.txt: ", ".png, .svg, .pdf"]),
    "metrics drawn on what is there": (
        ["metrics", "two.yaml", "--robot", "burger", "-o", "old.png"],
        ["old.png: exists already", "--force"],
    ),
}


@pytest.mark.parametrize(("arguments", "words"), COMMAND_LINES.values(), ids=COMMAND_LINES)
def test_a_command_line(refused: Refused, arguments: Sequence[str], words: Sequence[str]) -> None:
    recipe("not a recipe", "file")
    recipe("maps: 2\nseed: 7\nchunk_size: 2\n", "two.yaml")
    recipe("seed: 7\nchunk_size: 61\n", "large.yaml")
    recipe("an old picture", "old.png")
    recipe("an old table", "old.csv")
    recipe('<sdf version="1.6"><model name="cart"><link name="l"/></model></sdf>', "cart.sdf")
    Path("folder").mkdir()
    Path("folder.png").mkdir()
    Path("loop").symlink_to("loop")
    line = refused(*arguments)
    assert [word for word in words if word not in line] == []


def test_json_does_not_change_error_messages(refused: Refused) -> None:
    assert refused("generate", "-o", "out", "--json", "--maps", "0") == refused("generate", "-o", "out", "--maps", "0")


@pytest.mark.parametrize("command", commands())
def test_every_command_compares_an_unknown_flag_with_its_own(refused: Refused, command: str) -> None:
    given = {"generate": ["-o", "out"], "preview": ["a.yaml", "-o", "p.png"], "info": ["a.yaml"], "open": ["a.yaml"]}
    given |= {"import": ["a.csv", "-o", "out"], "drive": ["a.yaml"], "experiment": ["quick", "-o", "out"]}
    given |= {
        "metrics": ["a.yaml"],
        "dataset": ["-o", "out"],
        "series": ["-o", "out"],
        "terrain": ["a.yaml", "-o", "out"],
        "sheet": ["a.yaml", "-o", "s.pdf"],
        "view": ["a.yaml", "-o", "m.html"],
        "scan": ["a.xyz", "-o", "out"],
        "compare": ["a.xyz", "a.yaml"],
        "export": ["a.yaml", "--to", "stl", "-o", "out"],
    }
    given |= {"rate": ["burger"], "robot": ["burger"], "spawn": ["burger"], "respawn": ["a.yaml"], "remove": ["burger"]}
    line = refused(command, *given.get(command, []), "--hlep")
    assert "unknown flag '--hlep'; did you mean '--help'?" in line


# Outputs that exist.


def test_an_existing_map_stays_and_no_other_is_begun(refused: Refused) -> None:
    assert exit_code("generate", *OBSTACLE, "--first-map", "2", "-o", "out") == 0
    line = refused("generate", *OBSTACLE, "--maps", "5", "-o", "out")
    assert "out/rse_0002: exists already; use --force to replace it" in line


@pytest.mark.parametrize("name", ["rse_0001", "series.csv", "series.png"])
def test_a_series_that_would_overwrite_maps_is_not_begun(refused: Refused, name: str) -> None:
    Path("out").mkdir()
    recipe("years of work", f"out/{name}")
    assert f"out/{name}: exists already; use --force" in refused("series", *OBSTACLE, "--maps", "3", "-o", "out")


def test_force_spares_a_folder_in_the_place_of_a_table(refused: Refused) -> None:
    Path("out/series.csv").mkdir(parents=True)
    line = refused("series", *OBSTACLE, "--maps", "3", "--force", "-o", "out")
    assert "out/series.csv: exists already and is not a file" in line


def test_force_spares_a_folder_that_is_not_a_map(refused: Refused) -> None:
    Path("out/rse_0001").mkdir(parents=True)
    recipe("years of work", "out/rse_0001/thesis.tex")
    line = refused("generate", *OBSTACLE, "--maps", "2", "--force", "-o", "out")
    assert "out/rse_0001/thesis.tex: was not written by rsegen, and would be overwritten" in line


def test_force_spares_a_file_in_the_place_of_a_map(refused: Refused) -> None:
    Path("out").mkdir()
    recipe("years of work", "out/rse_0000")
    assert "out/rse_0000: is a file" in refused("generate", *OBSTACLE, "--force", "-o", "out")


@pytest.mark.parametrize("target", ["elsewhere", "nowhere"])
def test_force_spares_a_link(refused: Refused, target: str) -> None:
    Path("elsewhere").mkdir()
    recipe("{}", "elsewhere/recipe.json")
    Path("out").mkdir()
    Path("out/rse_0000").symlink_to(f"../{target}")
    assert "out/rse_0000: is a link" in refused("generate", *OBSTACLE, "--force", "-o", "out")


# More than there is: said before it is tried.

TOO_MUCH: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "chunks": (["--chunks", "1000000"], ["chunks: a map of", "fewer chunks"]),
    "chunks along one axis": (
        ["--chunks", "1000000000x1", "--chunk-size", "1000"],
        ["chunks: a map of", "fewer chunks"],
    ),
    "small chunks in frames": (["--chunks", "300000", "--chunk-size", "1"], ["900000 x 900000 cells"]),
    "boxes": (["--chunks", "1000000", "--mesh-type", "multi"], ["chunks: a map of", "fewer chunks"]),
    "maps": (["--maps", "1000000000000", "--chunk-size", "1"], ["maps: 1000000000000", "make fewer", "first_map"]),
}


@pytest.mark.parametrize(("flags", "words"), TOO_MUCH.values(), ids=TOO_MUCH)
def test_more_maps_than_the_memory_holds_are_refused(
    refused: Refused, flags: Sequence[str], words: Sequence[str]
) -> None:
    line = refused("generate", *OBSTACLE, *flags, "-o", "out")
    assert " GB" in line
    assert [word for word in words if word not in line] == []


@pytest.mark.parametrize(
    "command", [["info"], ["metrics"], ["preview", "-o", "p.png"], ["export", "--to", "stl", "-o", "o"]], ids=" ".join
)
def test_a_view_larger_than_the_memory_is_refused(refused: Refused, command: list[str]) -> None:
    assert "chunks: a map of" in refused(*command, recipe("chunks: 1000000\n"))
