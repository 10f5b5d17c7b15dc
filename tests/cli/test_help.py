"""Help and version: quick, in groups, and every command found in the table."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import rsegen.cli
from rsegen.cli.edge import main
from rsegen.params.capabilities import GROUPS, commands
from tests.support.shells import completed


def helped(capsys: pytest.CaptureFixture[str], *command: str) -> str:
    with pytest.raises(SystemExit) as end:
        main([*command, "--help"])
    assert end.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("flag", ["--help", "--version"])
def test_help_and_version_import_no_numpy_and_nothing_of_the_field(flag: str) -> None:
    code = f"""
import argparse, sys
argparse.ArgumentParser().format_help()  # from Python 3.14 on it imports dataclasses for its colours
own = set(sys.modules)
from rsegen.cli.edge import main
try:
    main([{flag!r}])
finally:
    names = [name for name in sys.modules if name.startswith(("numpy", "yaml", "dataclasses", "rsegen."))]
    print(*sorted(set(names) - own), file=sys.stderr)
"""
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout
    heavy = re.compile(r"numpy|yaml|dataclasses|rsegen\.(field|recipe|geometry|scene|gazebo)")
    assert [name for name in found.stderr.split() if heavy.match(name)] == []


def test_the_help_of_a_command_imports_neither_numpy_nor_yaml() -> None:
    """Of all commands in one process: a module stays imported, so the first command named is the one that does."""
    code = """
import sys
from rsegen.cli.edge import main
for command in sys.argv[1:]:
    try:
        main([command, "-h"])
    except SystemExit:
        print(command, *sorted({"numpy", "yaml", "matplotlib", "zmq"} & set(sys.modules)), file=sys.stderr)
"""
    result = subprocess.run([sys.executable, "-c", code, *commands()], check=True, capture_output=True, text=True)
    assert result.stdout.count("usage: rsegen") == len(commands())
    assert result.stderr.splitlines() == [*commands()]


def test_a_flag_is_completed_without_numpy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Whoever presses Tab waits for it; words are looked up when a value is completed."""
    monkeypatch.setenv("PYTHONPROFILEIMPORTTIME", "1")
    assert completed("rsegen drive --mot", tmp_path) == {"--motors"}
    imported = capfd.readouterr().err
    assert "argcomplete" in imported
    assert "numpy" not in imported


def test_rsegen_alone_says_how_to_begin(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    text = capsys.readouterr().out
    assert len(text.splitlines()) < 10
    assert {"generate", "open", "examples", "gui", "--help"} <= set(text.split())


@pytest.mark.parametrize(("asked", "meant"), [(["help"], ["--help"]), (["help", "drive"], ["drive", "--help"])])
def test_help_is_a_word_too(asked: list[str], meant: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    printed = []
    for words in (asked, meant):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
    assert printed[0].startswith("usage: rsegen")


@pytest.mark.parametrize("command", commands())
def test_every_command_has_json_and_quiet(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert {"--json", "--quiet"} <= set(helped(capsys, command).replace(",", " ").split())


@pytest.mark.slow
def test_quiet_prints_nothing_and_json_is_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (
        ["generate", "peak", "-o", str(tmp_path / "worlds")],
        ["preview", "peak", "-o", str(tmp_path / "a.png")],
        ["sheet", "peak", "-o", str(tmp_path / "a.csv")],
        ["info", "peak"],
        ["metrics", "peak"],
        ["examples"],
        ["spots", "peak", "--seed", "1"],
    ):
        assert main([*words, "--quiet"]) == 0
        assert capsys.readouterr() == ("", "")
        assert main([*words, "--json", *(["--force"] if "-o" in words else [])]) == 0
        assert json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("gen", {"generate"}),
        ("generate --lo", {"--look"}),
        ("generate --look ", {"plain", "levels", "wood", "friction"}),
        ("info mixed", {"mixed-course"}),
        ("info my", {"my.yaml", "my.urdf"}),  # zsh and fish look for no files by themselves
        ("drive --route ", {"straight", "random", "way"}),
        ("generate --obstacle pe", {"peak"}),
        ("generate --obstacle 'peak levels=5 sof", {"peak levels=5 softness="}),
        ("drive --robot ja", {"jackal"}),
        ("drive --robot my.u", {"my.urdf"}),
        ("robot ja", {"jackal"}),
        ("generate --crossable-by cr", {"crawler"}),
        ("export peak --to st", {"stl"}),
        ("export peak --to stl,mj", {"stl,mjcf"}),
        ("series peak --by steps.r", {"steps.rms"}),
        ("rate crawler --by mujoco,pr", {"mujoco,prediction"}),
        ("experiment qu", {"quick"}),
        ("experiment quick --simulator classic,mu", {"classic,mujoco"}),
        ("completion z", {"zsh"}),
        ("man gen", {"generate"}),
        ("schema gen", {"generate"}),
    ],
)
@pytest.mark.slow
def test_a_shell_completes_commands_flags_words_and_files(line: str, answer: set[str], tmp_path: Path) -> None:
    (tmp_path / "my.yaml").touch()
    (tmp_path / "my.urdf").touch()
    assert completed(f"rsegen {line}", tmp_path) == answer


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_prints_what_the_shell_reads(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    assert "rsegen" in capsys.readouterr().out


UNUSED = [
    *("multiprocessing", "matplotlib", "yaml", "rsegen.recipe.constraints", "rsegen.recipe.difficulty"),
    *("rsegen.simulators.base", "rsegen.datasets.making", "rsegen.build_sheets.document", "rsegen.pictures.preview"),
]


@pytest.fixture(scope="module")
def imported_by_generate(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The modules that a small world takes."""
    code = "import sys; from rsegen.cli.edge import main; main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"
    folder = str(tmp_path_factory.mktemp("worlds"))
    command = [sys.executable, "-c", code, "generate", "--obstacle", "random levels=5", "-o", folder]
    return subprocess.run(command, check=True, capture_output=True, text=True).stderr.split()


@pytest.mark.parametrize("module", UNUSED)
def test_a_small_world_takes_no_module_that_it_does_not_use(module: str, imported_by_generate: list[str]) -> None:
    assert "rsegen.writing.worlds" in imported_by_generate
    assert module not in imported_by_generate


def test_every_function_that_runs_a_command_is_declared() -> None:
    house = Path(rsegen.__file__).parent
    running = re.compile(r"^def run_(\w+)\(\w+: argparse\.Namespace\)", re.MULTILINE)
    files = {f"rsegen.{path.parent.name}.{path.stem}": path.read_text("utf-8") for path in house.glob("*/*.py")}
    found = {(name, module) for module, text in files.items() for name in running.findall(text)}
    assert found == {(name, command.module) for name, command in commands().items()}


def test_the_help_lists_the_commands_in_their_groups(capsys: pytest.CaptureFixture[str]) -> None:
    text = helped(capsys)
    places = [text.index(f"\n{title}:\n") for title in GROUPS]
    assert places == sorted(places)
    for command in commands().values():
        assert text.index(f"\n  {command.name} ") > places[GROUPS.index(command.group)]


@pytest.mark.parametrize("command", commands())
def test_the_help_of_a_command_has_options_last_and_none_that_are_required_among_them(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = helped(capsys, command)
    assert text.startswith(f"usage: rsegen {command}")
    _, found, options = text.partition("\noptions:\n")
    assert found
    assert "-h, --help" in options
    assert "-o " not in options.split("\n\n")[0] or command in ("examples", "drive", "experiment", "spawn", "respawn")


@pytest.mark.parametrize("command", ["", *commands()])
def test_helps_fit_narrow_terminals(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    lines = helped(capsys, *command.split()).splitlines()
    assert len(lines) > 10
    assert [line for line in lines if len(line) > 60] == []


def test_a_default_is_printed_once_and_none_is_omitted(capsys: pytest.CaptureFixture[str]) -> None:
    text = " ".join(helped(capsys, "generate").split())
    assert (
        "--boundary {none,divided,outer} frames: none, around every chunk, or one around the map (default: divided)"
        in text
    )
    assert "(0.001..100000 cm; default: 10)" in text
    assert "None" not in text
    assert "by default)" not in text


def test_a_command_is_compared_with_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["genrate"])
    assert end.value.code == 2
    assert "unknown command 'genrate'; did you mean 'generate'?" in capsys.readouterr().err
