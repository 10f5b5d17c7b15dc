"""The command line names the flag of what is wrong, a recipe its key, and Python its parameter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

import rsegen
from rsegen.cli.command_line import parser_of
from rsegen.cli.edge import main
from rsegen.errors import ParameterError
from rsegen.params.capabilities import commands
from rsegen.params.sorts import Choice, Float, Integer, ListOf

COMMANDS = {
    "generate": ["-o", "out"],
    "info": ["peak"],
    "metrics": ["peak", "--climb-cm=5"],
    "sheet": ["peak", "-o", "sheet.pdf"],
    "drive": ["peak"],
    "series": ["peak", "-o", "out"],
    "export": ["peak", "--to", "stl", "-o", "out"],
}


def refusal(words: Sequence[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the line with which a command refuses its words."""
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    return line.removeprefix("rsegen: ")


@pytest.mark.parametrize("command", [name for name in COMMANDS if name in commands()])
def test_a_wrong_value_is_that_of_its_flag(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    declared = [(getattr(action, "declared", None), action.option_strings) for action in parser_of(command).actions]
    flags = [
        names[-1]
        for parameter, names in declared
        if names and parameter and isinstance(parameter.sort, (Integer, Float, Choice, ListOf))
        if not parameter.is_switch and parameter.name != "inventory"  # which may be a file
    ]
    assert {"--unit-cm", "--seed", "--level-friction", "--mesh"} <= {*flags}
    for flag in flags:
        assert refusal([command, *COMMANDS[command], f"{flag}=wrong/"], capsys).startswith(
            (f"{flag}: ", f"{flag}[0]: ")
        )
    assert not list(tmp_path.iterdir())


def test_what_a_recipe_has_wrong_is_named_by_its_key(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text("unit_cm: -1\n")
    assert refusal(["info", str(file), "--unit-cm", "5"], capsys) == f"{file}: unit_cm: -1 is outside 0.001..100000 cm"
    file.write_text("mesh_type: multi\n")
    assert refusal(["info", str(file), "--tile", "4"], capsys).startswith("--tile: 4 is for mesh_type single")
    file.write_text("maps: 99999999999\n")
    assert refusal(["generate", str(file), "-o", str(tmp_path / "out")], capsys).startswith(
        "maps: 99999999999 maps need"
    )
    given = ["generate", "-o", str(tmp_path / "out"), "--maps", "99999999999"]
    assert refusal(given, capsys).startswith("--maps: 99999999999 maps need")
    with pytest.raises(ParameterError, match=r"^unit_cm: -1 is outside"):
        rsegen.Recipe(unit_cm=-1)


def test_an_obstacle_that_does_not_fit_is_named_as_it_was_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "recipe.yaml"
    file.write_text("obstacles:\n  - {kind: random, levels: 3}\n")
    first, last = "peak levels=5 first=2,2", "peak levels=5 first=20,2"
    wrong = refusal(["info", str(file), "--obstacle", first, "--obstacle", last], capsys)
    assert wrong.startswith(f"--obstacle '{last}': first[0]: 20 is outside 0..9")
    assert refusal(["info", "--obstacle", "pit levels=3"], capsys).startswith(
        "--obstacle 'pit levels=3': pit reaches 2"
    )
    file.write_text("obstacles:\n  - {kind: peak, levels: 3, first: [5, 5]}\n")
    smaller = refusal(["info", str(file), "--chunk-size", "4", "--obstacle", "random levels=3"], capsys)
    assert smaller.startswith("obstacles[0].first[0]: 5 is outside 0..3")
