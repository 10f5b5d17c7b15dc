"""Words that newcomers type for what is called otherwise here are answered with what was meant."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rsegen import KINDS, Obstacle, Recipe
from rsegen.cli.command_line import parser_of
from rsegen.cli.edge import main
from rsegen.errors import _PARAMETERS, UnknownName, did_you_mean
from rsegen.obstacles.base import row_parameters
from rsegen.params.capabilities import Command, commands, unknown_command
from rsegen.params.sorts import parameters

COMMANDS = [command for command in commands().values() if command.also]


def meant(error: str) -> list[str]:
    """The names that a message suggests."""
    found = re.search(r"did you mean (.*?)\?", error)
    return re.findall(r"'(\w+)'", found[1]) if found else []


@pytest.mark.parametrize("command", COMMANDS, ids=[command.name for command in COMMANDS])
def test_a_command_is_found_by_its_other_words(command: Command) -> None:
    for word in command.also:
        assert word not in commands(), f"{word} is a command itself"
        assert command.name in meant(str(unknown_command(word)))
        assert command.name in meant(str(unknown_command(word.upper())))


def test_commands_of_the_core_have_other_words() -> None:
    assert {command.name for command in COMMANDS} >= {"generate", "info", "examples", "obstacles"}
    assert meant(str(unknown_command("make"))) == ["generate"]


@pytest.mark.parametrize("cls", KINDS.values(), ids=list(KINDS))
def test_a_kind_is_found_by_its_other_words(cls: type[Obstacle]) -> None:
    assert cls.also or KINDS.source(cls.kind)
    for word in cls.also:
        assert word not in KINDS
        with pytest.raises(UnknownName) as refused:
            KINDS.named(word, "kind")
        assert cls.kind in meant(str(refused.value))


def test_other_words_of_parameters_mean_parameters_and_flags_that_exist() -> None:
    rows = {name for cls in KINDS.values() for name in row_parameters(cls)}
    flags = {flag.strip("-").replace("-", "_") for name in commands() for flag in parser_of(name).flags}
    of_capabilities = {"robot", "duration", "to", "formats", "workers"}
    named = {name for names in _PARAMETERS.values() for name in names}
    assert named - of_capabilities <= {*rows, *flags, *parameters(Recipe), "obstacles"}
    assert len(_PARAMETERS) > 50
    for word, names in _PARAMETERS.items():
        assert did_you_mean(word, names) == f"; did you mean {names[0]!r}?"


@pytest.mark.parametrize(
    ("given", "name"),
    [
        (["generate", "--obstacle", "peak height=5"], "levels"),
        (["generate", "--obstacle", "peak levels=5 start=1,2"], "first"),
        (["generate", "--obstacle", "peak levels=5 end=1,2"], "last"),
        (["generate", "--obstacle", "normal_random levels=5 sigma=1"], "spread"),
        (["generate", "--obstacle", "hill levels=5"], "peak"),
        (["generate", "--obstacle", "Gaussian levels=5"], "normal_random"),
        (["generate", "--obstacle", "stepping-stones levels=5"], "stones"),
        (["generate", "--count", "2"], "maps"),
        (["generate", "--overwrite"], "force"),
        (["generate", "--frames", "outer"], "boundary"),
        (["generate", "--unit", "5"], "unit-cm"),
        (["generate", "--levels", "5"], "obstacle"),
    ],
    ids=lambda given: " ".join(given) if isinstance(given, list) else given,
)
def test_words_of_newcomers_are_answered(
    given: list[str], name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "out"
    try:
        code = main([*given, "-o", str(output)])
    except SystemExit as end:
        code = int(end.code or 0)
    assert code == 2
    said = capsys.readouterr().err
    assert f"did you mean '{name}'?" in said or f"did you mean '--{name}'?" in said
    assert not output.exists()


def test_a_misspelt_name_is_answered_with_the_nearest_one_and_nonsense_with_the_list() -> None:
    assert did_you_mean("chunksize", parameters(Recipe)) == "; did you mean 'chunk_size'?"
    assert did_you_mean("xyzzy", parameters(Recipe)) == ""
    assert meant(str(unknown_command("frobnicate"))) == []
    assert "generate" in str(unknown_command("frobnicate"))


def test_version_is_a_word_as_in_git(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["version"], ["--version"]):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert not end.value.code
    one, other = capsys.readouterr().out.splitlines()
    assert one == other
