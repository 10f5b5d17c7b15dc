"""The command line as people and programs use it; what they do wrong is in test_bad_input.py."""

from __future__ import annotations

import io
import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

import rsegen
from rsegen import KINDS, Recipe
from rsegen.cli.edge import main
from rsegen.input_files import JOURNAL
from rsegen.obstacles.base import Obstacle, own_parameters
from rsegen.params.capabilities import commands
from rsegen.params.sorts import Flag, parameters
from rsegen.recipe.codec import decode
from rsegen.recipe.examples import EXAMPLES
from tests.support.complaints import the_line
from tests.support.samples import sample

COURSE = EXAMPLES["mixed-course"]
SMALL = ["--obstacle", "random levels=5", "--chunk-size", "4", "--seed", "7"]


@pytest.fixture
def recipe_file(tmp_path: Path) -> Path:
    path = tmp_path / "recipe.yaml"
    path.write_text("maps: 2\nchunk_size: 4\nseed: 7\nobstacles:\n  - {kind: peak, levels: 3}\n")
    return path


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def generated(*arguments: str | Path) -> int:
    return main(["generate", *map(str, arguments)])


def printed(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """Output of a command that succeeds; it says nothing on stderr."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def read(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> Any:
    return json.loads(printed(capsys, *arguments, "--json"))


def helped(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as end:
        main([*arguments, "--help"])
    assert end.value.code == 0
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("name", [name for name in parameters(Recipe) if name != "maps"])
def test_a_flag_overrides_the_file(tmp_path: Path, recipe_file: Path, name: str) -> None:
    parameter, default = parameters(Recipe)[name], getattr(Recipe(seed=7), name)
    value = sample(parameter, default)
    flag = f"--{name.replace('_', '-')}"
    assert generated(recipe_file, flag, parameter.format(value), "--maps", "1", "-o", tmp_path / "out") == 0
    (made,) = (tmp_path / "out").iterdir()
    content = json.loads((made / "recipe.json").read_text("utf-8"))
    assert content[name] == value
    assert [row["kind"] for row in content["obstacles"]] == ["peak"]
    assert content["seed"] == (value if name == "seed" else 7)


def test_obstacles_of_flags_come_after_obstacles_of_the_file(tmp_path: Path, recipe_file: Path) -> None:
    added = ["random levels=4 weights=1,0,0,2", "horizontal_barrier levels=5 softness=30 first=0,2 last=3,2"]
    flags = [part for text in added for part in ("--obstacle", text)]
    assert generated(recipe_file, *flags, "-o", tmp_path / "out") == 0
    rows = rsegen.load(tmp_path / "out" / "rse_0001" / "recipe.json").obstacles
    assert [row.kind for row in rows] == ["peak", "random", "horizontal_barrier"]
    assert rows[1] == rsegen.Random(levels=4, weights=(1, 0, 0, 2), key=rows[1].key)
    assert (rows[2].first, rows[2].last) == ((0, 2), (3, 2))


def test_every_map_is_a_folder_of_its_own(tmp_path: Path) -> None:
    assert generated(*SMALL, "--maps", "3", "-o", tmp_path / "a" / "b") == 0
    folders = sorted((tmp_path / "a" / "b").iterdir())
    assert [folder.name for folder in folders] == ["rse_0000", "rse_0001", "rse_0002"]
    levels = {(folder / "levels.csv").read_bytes() for folder in folders}
    assert len(levels) == 3


def test_the_report_names_every_world_and_the_seed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "generate", *SMALL, "--maps", "2", "-o", tmp_path)
    assert "2 maps of 4 x 4 blocks (6 x 6 cells with frames), seed 7" in out
    for name in ("rse_0000", "rse_0001"):
        assert str(tmp_path / name / f"{name}.world") in out


def test_an_obstacle_of_nothing_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "warning: every block is at level 0" in printed(capsys, "generate", "-o", tmp_path)


def test_force_replaces_a_map(tmp_path: Path) -> None:
    assert generated(*SMALL, "-o", tmp_path) == 0
    before = contents(tmp_path)
    assert generated(*SMALL, "-o", tmp_path, "--force", "--seed", "8") == 0
    after = contents(tmp_path)
    assert after.keys() == before.keys()
    assert after["rse_0000/levels.csv"] != before["rse_0000/levels.csv"]


def test_force_leaves_other_maps_alone(tmp_path: Path) -> None:
    assert generated(*SMALL, "--maps", "2", "-o", tmp_path) == 0
    before = contents(tmp_path / "rse_0001")
    assert generated(*SMALL, "--force", "--seed", "8", "-o", tmp_path) == 0
    assert contents(tmp_path / "rse_0001") == before


@pytest.mark.slow
def test_a_preview_is_the_picture_that_the_preview_command_draws(tmp_path: Path) -> None:
    assert generated(*SMALL, "--preview", "-o", tmp_path / "out") == 0
    made = tmp_path / "out" / "rse_0000" / "preview.png"
    assert made.read_bytes().startswith(b"\x89PNG\r\n")
    assert main(["preview", str(made.parent), "-o", str(tmp_path / "again.png")]) == 0
    assert (tmp_path / "again.png").read_bytes() == made.read_bytes()


@pytest.mark.parametrize(("boundary", "side"), [("none", 20), ("divided", 24), ("outer", 22)])
def test_json_lists_the_written_maps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], boundary: str, side: int
) -> None:
    flags = ["--obstacle", "random levels=3", "--chunks", "2", "--boundary", boundary, "--seed", "7"]
    told = read(capsys, "generate", *flags, "-o", tmp_path)
    assert set(told) == {"folder", "seed", "maps"}
    assert (told["folder"], told["seed"]) == (str(tmp_path), 7)
    (one,) = told["maps"]
    assert one["size"] == [side, side]
    assert one["size_m"] == [side / 10, side / 10]
    assert one["levels"] == [0, 1, 2]
    assert sum(one["level_counts"].values()) == 400
    assert one["warnings"] == []
    assert sorted(one["files"]) == sorted(str(path) for path in tmp_path.rglob("[!.]*") if path.is_file())
    assert Path(one["world"]).is_file()
    assert Path(one["folder"]).name == one["name"] == "rse_0000"
    assert one["index"] == 0


def test_json_is_all_that_is_printed_even_with_warnings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = read(capsys, "generate", "--chunk-size", "2", "--maps", "2", "-o", tmp_path)
    assert all("level 0" in one["warnings"][0] for one in told["maps"])


def test_a_map_of_very_many_models_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--obstacle", "random levels=2 weights=0,1", "--chunk-size", "32", "--mesh-type", "multi"]
    (one,) = read(capsys, "generate", *flags, "-o", tmp_path)["maps"]
    assert "models: Gazebo Classic needs about" in one["warnings"][0]


def test_the_recipe_of_a_map_makes_its_bytes_again(tmp_path: Path) -> None:
    assert generated(COURSE, "-o", tmp_path / "all") == 0
    for made in sorted((tmp_path / "all").iterdir()):
        assert generated(made / "recipe.json", "-o", tmp_path / "file") == 0
        assert generated(made, "-o", tmp_path / "folder") == 0
        assert contents(tmp_path / "file" / made.name) == contents(made)
        assert contents(tmp_path / "folder" / made.name) == contents(made)


def test_one_map_alone_is_the_same_as_among_all(tmp_path: Path) -> None:
    assert generated(COURSE, "-o", tmp_path / "all") == 0
    assert generated(COURSE, "--first-map", "2", "--maps", "1", "-o", tmp_path / "one") == 0
    (alone,) = (tmp_path / "one").iterdir()
    assert alone.name == "mixed-course_0002"
    assert contents(alone) == contents(tmp_path / "all" / alone.name)


def test_a_seed_that_was_drawn_is_shown_and_makes_the_same_map(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--obstacle", "random levels=5"]
    first, second = (read(capsys, "generate", *flags, "-o", tmp_path / each)["seed"] for each in "ab")
    assert first != second
    assert generated(*flags, "--seed", str(first), "-o", tmp_path / "c") == 0
    assert contents(tmp_path / "c") == contents(tmp_path / "a")


@pytest.mark.parametrize("path", EXAMPLES.values(), ids=lambda path: path.stem)
def test_the_schema_accepts_every_example(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jsonschema.validate(yaml.safe_load(path.read_text("utf-8")), json.loads(printed(capsys, "schema")))


@pytest.mark.parametrize(
    "content",
    [
        {"sneed": 1},
        {"obstacles": [{"kind": "peak", "levels": 5, "weights": [1, 2]}]},
        {"obstacles": [{"kind": "peek", "levels": 5}]},
        {"obstacles": [{"kind": "peak"}]},
        {"obstacles": {"kind": "peak", "levels": 5}},
        {"chunk_size": 1001},
        {"chunks": 0},
        {"boundary": None},
        {"name": "../x"},
        [],
    ],
    ids=str,
)
def test_the_schema_refuses_the_values_that_rsegen_refuses(content: object, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, json.loads(printed(capsys, "schema")))
    with pytest.raises(rsegen.UserError):
        decode(content)


@pytest.mark.parametrize("name", KINDS)
def test_obstacles_lists_every_kind_with_its_parameters(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    _, _, rest = f"\n{printed(capsys, 'obstacles')}".partition(f"\n{name}\n")
    own, _, others = rest.partition("\n\n")
    _, _, of_every_kind = f"\n{others}".partition("\nevery kind\n")
    shared = parameters(Obstacle)
    assert all(f"    {parameter} " in of_every_kind for parameter in shared)
    for parameter, sort in own_parameters(KINDS[name]).items():
        listed = of_every_kind if sort == shared.get(parameter) else own
        assert any(
            line.startswith(f"    {parameter} ") and line.endswith(f": {sort.describe()}")
            for line in listed.split("\n")
        )


def test_one_kind_of_obstacle_is_listed_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["obstacles", "peak"]) == 0
    listed = [line for line in capsys.readouterr().out.splitlines() if line.isidentifier()]
    assert listed == ["peak"]
    assert [row["title"] for row in read(capsys, "obstacles", "peak")] == ["peak"]
    assert main(["obstacles", "peek"]) == 2
    assert "did you mean 'peak'?" in capsys.readouterr().err


def test_obstacles_in_json_are_the_schemas_of_the_kinds(capsys: pytest.CaptureFixture[str]) -> None:
    rows = read(capsys, "obstacles")
    assert {row["title"]: set(row["properties"]) for row in rows} == {
        name: {"kind", *parameters(cls)} for name, cls in KINDS.items()
    }


def test_info_agrees_with_generated_maps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (one,) = read(capsys, "generate", *SMALL, "-o", tmp_path)["maps"]
    told = read(capsys, "info", tmp_path / "rse_0000")
    files = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != JOURNAL]
    assert told["bytes"] == sum(path.stat().st_size for path in files)
    assert {key: told[key] for key in one.keys() & told.keys()} == {key: one[key] for key in one.keys() & told.keys()}
    assert set(told) - set(one) == {
        *("seed", "unit_cm", "fingerprint", "obstacles", "placed", "constraints"),
        *("mesh_type", "models", "collisions", "faces", "bytes"),
    }


def test_info_for_people_says_size_levels_and_cost(recipe_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "info", recipe_file)
    assert "rse_0000, seed 7" in out
    assert "4 x 4 blocks (6 x 6 cells with frames), 0.6 x 0.6 m" in out
    assert "16 in levels of 10 cm" in out
    assert "1 model, " in out
    assert "\nobstacle peak levels=3" in out


def test_info_lists_obstacles_and_constraints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    row = "random levels=3 weights=4,2,1 first=1,1 last=8,8 key=rough"
    off = "peak levels=3 key=off enabled=no"
    demand = ["--max-step", "1", "--crossable-by", "10,10,20", "--boundary", "none", "--seed", "7"]
    words = ["info", "--obstacle", row, "--obstacle", off, *demand]
    lines = printed(capsys, *words).splitlines()
    assert lines[lines.index(f"obstacle {row}") :] == [
        f"obstacle {row}",
        "demand   max_step 1",
        "demand   crossable_by 10,10,20",
        "off      obstacles[1]: peak",
        *(line for line in lines if line.startswith("warning: ")),
    ]
    told = read(capsys, *words)
    assert told["constraints"] == {"max_step": 1, "crossable_by": [10, 10, 20]}
    assert [entry["key"] for entry in told["obstacles"]] == ["rough"]
    many = printed(capsys, "info", "--seed", "7", *["--obstacle", "peak levels=3"] * 12)
    assert many.count("\nobstacle peak") == 10
    assert "\n         and 2 more\n" in many
    rsegen.save(
        rsegen.Recipe(seed=7, obstacles=[rsegen.Matrix(rows=("0 1 " * 50,) * 100)], chunks=(10, 10)),
        tmp_path / "m.yaml",
    )
    (long,) = (line for line in printed(capsys, "info", tmp_path / "m.yaml").splitlines() if "obstacle" in line)
    assert long.startswith("obstacle matrix levels=2 rows=0,1,0,1")
    assert long.endswith("...")
    assert len(long) < 120


def test_a_target_is_a_recipe_a_map_or_a_folder_of_maps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert generated(COURSE, "-o", tmp_path) == 0
    first, last = (read(capsys, "info", tmp_path / f"mixed-course_000{index}") for index in (0, 2))
    assert first != last
    assert main(["info", str(tmp_path), "--json"]) == 0
    out, err = capsys.readouterr()
    assert read(capsys, "info", COURSE) == json.loads(out) == first
    assert err == f"note: mixed-course_0000 is the first of 3 maps in {tmp_path}; --map selects another\n"
    for which in ("2", "0002", "mixed-course_0002"):
        assert read(capsys, "info", COURSE, "--map", which) == last
        assert read(capsys, "info", tmp_path, "--map", which) == last


@pytest.mark.parametrize(
    ("name", "start"),
    [("a.png", b"\x89PNG"), ("a.SVG", b"<?xml"), ("a.pdf", b"%PDF"), ("a.jpeg", b"\xff\xd8"), ("a.webp", b"RIFF")],
)
def test_preview_draws_the_format_of_the_suffix(
    tmp_path: Path, recipe_file: Path, capsys: pytest.CaptureFixture[str], name: str, start: bytes
) -> None:
    path = tmp_path / "new" / name
    assert printed(capsys, "preview", recipe_file, "--map", "1", "-o", path) == f"{path}: rse_0001, seed 7\n"
    assert path.read_bytes().startswith(start)
    assert {each.name for each in path.parent.iterdir()} == {path.name}


def test_preview_replaces_a_picture_only_by_force(tmp_path: Path, recipe_file: Path) -> None:
    path, command = tmp_path / "a.png", ["preview", str(recipe_file), "-o", str(tmp_path / "a.png")]
    assert [main(command), main(command), main([*command, "--force"])] == [0, 2, 0]
    assert path.read_bytes().startswith(b"\x89PNG")
    path.write_bytes(b"mine")
    assert (main(command), path.read_bytes()) == (2, b"mine")
    assert main([*command, "--force"]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "content",
    [b"\xef\xbb\xbfseed: 7\n", b"seed: 7\r\nmaps: 1\r\n", b"--- \nseed: 7\n...\n", b'{"seed": 7}', b"{}"],
    ids=["byte order mark", "lines of Windows", "document marks", "JSON is YAML", "nothing said"],
)
def test_harmless_oddities_of_files_are_read(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "recipe.yml"
    path.write_bytes(content)
    assert generated(path, "-o", tmp_path / "out") == 0
    assert (tmp_path / "out" / "rse_0000" / "rse_0000.world").is_file()


def test_version_is_the_packages(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"rsegen {rsegen.__version__}\n"


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    text = helped(capsys)
    for command, line in ((name, known.help) for name, known in commands().items()):
        assert f" {command} {line}" in text


@pytest.mark.parametrize("name", parameters(Recipe))
def test_help_of_generate_has_the_values_of_every_parameter(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    text = helped(capsys, "generate")
    parameter = parameters(Recipe)[name]
    assert f"--{name.replace('_', '-')} " in text
    assert parameter.help in text
    choices = ("yes", "no") if isinstance(parameter, Flag) else getattr(parameter, "values", ())
    values = f"{{{','.join(choices)}}}" if choices else parameter.describe()
    assert values in text


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("series", ["RECIPE", "--output", "--from", "--to", "--same-field", "--force", "--resume", "--workers"]),
        (
            "generate",
            ["RECIPE", "--output", "--obstacle", "--force", "--resume", "--preview", "--sheet", "--json", "--workers"],
        ),
        ("preview", ["RECIPE-or-DIR", "--output", "--map", "--force", "png, svg, pdf, jpg or webp"]),
        ("sheet", ["RECIPE-or-DIR", "--output", "--csv", "--map", "--force", "--kerf-mm", "--stock-cm", "pdf or csv"]),
        ("sheet", ["--kerf-mm MM", "(0..100 mm; default: 3)", "(0.001..100000 cm; default: 240)"]),
        ("dataset", ["--shard-maps MAPS", "--metrics {npy,parquet,none}", "(default: npy)", "--workers"]),
        ("metrics", ["--climb-cm CM", "highest step up on a path of cells (0..100000 cm)", "--width-cm CM"]),
        ("export", ["RECIPE-or-DIR", "--to", "--output", "--map", "--force", "--json", "--workers", "heightmap"]),
        ("info", ["RECIPE-or-DIR", "--map", "--json"]),
        ("obstacles", ["--json"]),
        ("schema", ["JSON Schema"]),
    ],
)
def test_help_of_every_command_names_its_flags(
    command: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    text = helped(capsys, command)
    assert [word for word in words if word not in text] == []


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize("command", ["generate", "series", "dataset", "export"])
def test_a_terminal_sees_how_many_maps_are_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, terminal: bool
) -> None:
    rsegen.save(rsegen.Recipe(seed=7, maps=3), tmp_path / "recipe.json")
    stderr = Terminal() if terminal else io.StringIO()
    monkeypatch.setattr(sys, "stderr", stderr)
    to = ["--to", "heightmap"] if command == "export" else []
    assert main([command, str(tmp_path / "recipe.json"), *to, "-o", str(tmp_path / "out")]) == 0
    assert ("3/3" in stderr.getvalue() or "3.00/3.00" in stderr.getvalue()) is terminal
    assert terminal or not stderr.getvalue()


@pytest.mark.parametrize("command", ["generate", "series", "dataset", "export"])
def test_progress_as_json_is_a_line_for_each_change(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    rsegen.save(rsegen.Recipe(seed=7, maps=3), tmp_path / "recipe.json")
    to = ["--to", "heightmap"] if command == "export" else []
    given = [command, str(tmp_path / "recipe.json"), *to, "--progress", "json", "-o", str(tmp_path / "out")]
    assert main(given) == 0
    said = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert said[0] == {"done": 0, "total": 3, "unit": "map", "step": ""}
    assert said[-1] == {"done": 3, "total": 3, "unit": "map", "step": ""}
    assert [each["done"] for each in said] == sorted({each["done"] for each in said})


@pytest.mark.parametrize("flags", [["--progress", "none"], ["--progress", "json", "--quiet"]])
def test_a_terminal_may_want_no_progress(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flags: list[str]) -> None:
    stderr = Terminal()
    monkeypatch.setattr(sys, "stderr", stderr)
    assert main(["generate", "peak", "--maps", "3", *flags, "-o", str(tmp_path)]) == 0
    assert stderr.getvalue() == ""


def test_unknown_progress_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", "peak", "--progress", "jso", "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == "rsegen: --progress: 'jso' is not one of bar, json, none; did you mean 'json'?\n"
    assert not (tmp_path / "out").exists()


def test_a_command_leaves_the_signals_as_they_were(capsys: pytest.CaptureFixture[str]) -> None:
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    assert printed(capsys, "schema")
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == before


def test_a_stop_while_a_module_is_imported_is_one_line(tmp_path: Path) -> None:
    """Dataclasses run `exec`; CPython, run with -m, would end by SIGINT if a stop interrupted one."""
    stopped = tmp_path / "stopped.py"
    stopped.write_text('exec("raise KeyboardInterrupt")\n')
    command = [sys.executable, "-m", "rsegen", "--plugin", str(stopped), "examples"]
    found = subprocess.run(command, check=False, capture_output=True, text=True)
    assert found.returncode in (130, -2), found.stderr  # a shell says 130 of both
    assert found.stderr.count("\n") == 1, found.stderr


def test_python_is_advised_in_python_and_a_shell_in_flags(
    recipe_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "out"
    for make in (rsegen.generate, rsegen.make_dataset):
        made = folder / make.__name__
        make(rsegen.load(recipe_file), made)
        with pytest.raises(rsegen.UserError, match=r"use (force|resume)=True") as refused:
            make(rsegen.load(recipe_file), made)
        assert "--" not in str(refused.value)
    assert generated(recipe_file, "-o", folder / "generate") == 2
    assert "use --force to replace it" in capsys.readouterr().err


@pytest.mark.parametrize("place", ["-0.5,0.3,90", "-.5,-0.3,-90", "-5e-1,0,0"])
def test_a_value_may_begin_with_a_minus_sign(tmp_path: Path, capsys: pytest.CaptureFixture[str], place: str) -> None:
    pictures = [tmp_path / "apart.png", tmp_path / "joined.png"]
    for picture, words in zip(pictures, (["--at", place], [f"--at={place}"]), strict=True):
        assert main(["preview", *SMALL, "--chunks", "3", "--robot", "burger", *words, "-o", str(picture)]) == 0
    apart, joined = (picture.read_bytes() for picture in pictures)
    assert apart == joined
    with pytest.raises(SystemExit) as ended:
        main(["preview", *SMALL, "--robot", "burger", "--at", "-x", "-o", str(pictures[0])])
    assert ended.value.code == 2
    assert "argument --at: expected one argument" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["generate", "export --to stl", "dataset", "examples", "preview", "view", "sheet"])
def test_the_standard_output_is_no_place_for_files(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    name, *flags = command.split()
    with pytest.raises(SystemExit, match="2"):
        main([name, *([] if name == "examples" else ["peak"]), *flags, "-o", "-"])
    assert "error: -o/--output: nothing is written to the standard output; use the name of a " in the_line(
        capsys.readouterr().err
    )
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize(
    "words", ["preview peak -o a.png/", "view peak -o a.html/", "sheet peak -o a.pdf/", "robot burger --picture a.png/"]
)
def test_a_file_whose_name_ends_as_that_of_a_folder_is_refused(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="2"):
        main(words.split())
    assert "/' names a folder; use the name of a file" in the_line(capsys.readouterr().err)
    assert [*tmp_path.iterdir()] == []


def test_a_folder_may_be_named_with_a_slash_at_its_end_or_a_dash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("worlds/", "./-"):
        assert main(["generate", "peak", "-o", folder, "-q"]) == 0
        assert (tmp_path / folder / "peak_0000").is_dir()
