"""A command's signature is the only declaration: checks, flags, schema and rows of the manual follow from it."""

from __future__ import annotations

import argparse
from inspect import Parameter as Argument
from inspect import signature, unwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import pytest
from jsonschema import Draft202012Validator

import rsegen
from rsegen.cli.parser import Parser
from rsegen.errors import ParameterError
from rsegen.params.command import Shell, add_flags, command, command_schema, declared, flags_in_errors, given, rows
from rsegen.params.sorts import Choice, Flag, Float, Integer, ListOf

if TYPE_CHECKING:
    from fractions import Fraction

COMMANDS: list[Any] = [
    *(rsegen.generate, rsegen.series, rsegen.make_dataset, rsegen.export_maps, rsegen.export),
    *(rsegen.drive, rsegen.spots, rsegen.experiment, rsegen.open, rsegen.spawn, rsegen.respawn, rsegen.remove),
]


Letter = Annotated[str, Choice(("a", "b"), help="letter"), Shell(metavar="L")]


@command
def brew(  # noqa: PLR0913  # each is a flag
    target: Fraction,
    *,
    cups: Annotated[int, Integer(1, 12, unit="cups", help="number of cups")] = 2,
    heat_: Annotated[float | None, Float(20, 100, unit="C", help="temperature"), Shell(default="boiling")] = None,
    milk: Annotated[bool, Flag(help="add milk")] = False,
    stir: Annotated[bool, Flag(help="stir it"), Shell(help="do not stir it")] = True,
    kind: Annotated[str, Choice(("green", "black"), help="kind of tea")] = "black",
    sizes: Annotated[tuple[float, ...] | None, ListOf(Float(0, 1, unit="cm"), 2, help="two lengths")] = None,
) -> dict[str, Any]:
    """Make tea: 100 % of it.

    More than a line.
    """
    return {**vars(), "target": target}


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_flags(parser, brew)
    return parser.parse_args(words)


def test_a_call_gets_canonical_values_and_its_own_defaults() -> None:
    made = brew(3, cups=4.0, sizes=[0, 1])  # type: ignore[arg-type]  # as users may
    assert made["cups"] == 4
    assert isinstance(made["cups"], int)
    assert made["sizes"] == (0.0, 1.0)
    assert (made["kind"], made["heat_"], made["target"]) == ("black", None, 3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"cups": 13}, "cups: 13 is outside 1..12 cups"),
        ({"heat_": "hot"}, "heat: 'hot' is not a number; expected 20..100 C"),
        ({"kind": "blak"}, "kind: 'blak' is not one of green, black; did you mean 'black'?"),
        ({"cups": None}, "cups: an empty value is not a whole number"),
        ({"milk": "yes"}, "milk: 'yes' is neither yes nor no"),
    ],
)
def test_a_wrong_value_is_refused_in_python(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError) as error:
        brew(3, **wrong)  # type: ignore[arg-type]  # as users may
    assert str(error.value).startswith(message)


def test_flags_give_what_a_call_takes() -> None:
    words = ["--cups", "3", "--heat", "90", "--milk", "--no-stir", "--kind", "green", "--sizes", "3mm,0.5"]
    said = given(brew, parsed(*words))
    assert said == {"cups": 3, "heat_": 90.0, "milk": True, "stir": False, "kind": "green", "sizes": [0.3, 0.5]}
    assert brew(1, **said)["sizes"] == (0.3, 0.5)  # type: ignore[arg-type]  # as users may
    assert given(brew, parsed()) == {}


def test_an_error_names_the_flag() -> None:
    with pytest.raises(ParameterError, match=r"^--heat: 101.0 is outside 20..100 C$"), flags_in_errors(brew):
        brew(3, heat_=101.0)  # type: ignore[arg-type]  # as users may
    with pytest.raises(ParameterError, match=r"^--sizes\[1\]: 2.0 is outside"), flags_in_errors(brew):
        brew(3, sizes=(0.0, 2.0))  # type: ignore[arg-type]  # as users may


def test_the_help_has_meaning_values_and_default() -> None:
    parser = Parser(prog="tea")
    add_flags(parser, brew)
    text = " ".join(parser.format_help().split())
    for words in (
        "--cups CUPS number of cups (1..12 cups; default: 2)",
        "--heat HEAT temperature (20..100 C; default: boiling)",
        "--no-stir do not stir it",
        "--kind {green,black} kind of tea (default: black)",
    ):
        assert words in text


def test_a_schema_validates_what_a_call_takes() -> None:
    validator = Draft202012Validator(command_schema(brew))
    assert validator.is_valid({"cups": 3, "kind": "green", "sizes": [0, 1]})
    assert not validator.is_valid({"cups": 13})
    assert not validator.is_valid({"sugar": 1})
    assert command_schema(brew)["properties"]["cups"]["default"] == 2
    assert command_schema(brew)["description"] == "Make tea: 100 % of it."


def test_a_row_of_the_manual_has_name_flag_values_default_and_meaning() -> None:
    found = {row[0]: row[1:] for row in rows(brew)}
    assert found["cups"] == ("--cups CUPS", "1..12 cups", "2", "number of cups")
    assert found["stir"] == ("--no-stir", "yes or no", "yes", "stir it")


def test_the_manual_tells_what_is_required_and_which_default_a_shell_has_instead() -> None:
    defaults = {row[0]: row[3] for row in rows(rsegen.generate)}
    assert (defaults["folder"], defaults["formats"], defaults["scheduler"]) == ("required", "", "")
    assert defaults["workers"] == "1; in a shell the number of cores"


def test_nested_annotations_add_to_what_the_inner_ones_say() -> None:
    def write(letter: Annotated[Letter, Shell(default="none")] = "a") -> None: ...

    assert declared(write)["letter"].shell == Shell(metavar="L", default="none")


@pytest.mark.parametrize("function", COMMANDS, ids=lambda function: function.__name__)
def test_every_parameter_of_a_command_is_explained_and_its_default_is_valid(function: Any) -> None:
    known = declared(function)
    assert known
    arguments = signature(unwrap(function)).parameters
    for name, parameter in known.items():
        assert parameter.help, name
        assert parameter.default == arguments[name].default
        if parameter.default is not None and parameter.default is not Argument.empty:
            assert parameter.sort.check(name, parameter.default) == parameter.default
    flags = [flag for parameter in known.values() for flag in parameter.flags]
    assert len(flags) == len(set(flags))
    Draft202012Validator.check_schema(command_schema(function))


@pytest.mark.parametrize("function", COMMANDS, ids=lambda function: function.__name__)
def test_parameters_of_one_name_mean_the_same_in_every_command(function: Any) -> None:
    """Others by intention: spawn gives a name, respawn takes one; an experiment several simulators, what
    runs is a server; a series limits.
    """
    others = {
        ("name", "spawn"),
        ("simulator", "experiment"),
        *(("simulator", name) for name in ("spawn", "respawn", "remove")),
        ("robot", "series"),
        ("formats", "export_maps"),
        ("size", "spots"),
    }
    for name, parameter in declared(function).items():
        for other in COMMANDS:
            like = declared(other).get(name)
            if like and not {(name, function.__name__), (name, other.__name__)} & others:
                assert (type(like.sort), like.sort.describe()) == (type(parameter.sort), parameter.sort.describe())


@pytest.mark.parametrize("folder", ["", 3, None])
def test_an_invalid_folder_is_refused(folder: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError, match=r"folder: .*expected a folder"):
        rsegen.generate(rsegen.Recipe(seed=1), folder)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "named", "message"),
    [
        ((1, 3), {}, "brew() takes 1 positional argument, not 2; name the others: cups, heat_, milk, ..."),
        ((1,), {"cusp": 3}, "brew() has no parameter 'cusp'; did you mean 'cups'?"),
        ((), {}, "brew(): missing a required argument: 'target'"),
    ],
)
def test_a_call_with_other_arguments_says_which(arguments: tuple[Any], named: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError) as refused:
        brew(*arguments, **named)
    assert str(refused.value) == message
