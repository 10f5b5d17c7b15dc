"""The forms of pages are made of the one declaration, and what they give a command line takes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from inspect import Parameter as Argument
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import pytest
from hypothesis import HealthCheck, given, settings

from rsegen.cli.command_line import parser_of
from rsegen.errors import ParameterError, UnknownName
from rsegen.obstacles import KINDS
from rsegen.obstacles.base import row_parameters
from rsegen.page.command_forms import CommandForm, command_form, command_forms
from rsegen.page.forms import Field, global_groups, kinds
from rsegen.page.hello import hello
from rsegen.page.host import Host
from rsegen.page.places import Places
from rsegen.params.capabilities import GROUPS
from rsegen.params.capabilities import commands as all_commands
from rsegen.params.command import declared
from rsegen.params.sorts import parameters, plain
from rsegen.recipe.recipe import Recipe

COMMANDS = tuple(command_forms())


def test_every_parameter_of_a_recipe_is_in_one_field_with_its_schema_and_default() -> None:
    fields = [field for group in global_groups() for field in group["fields"]]
    known = parameters(Recipe)
    assert sorted(field["name"] for field in fields) == sorted(known)
    for field in fields:
        assert _without_words(field["schema"]) == known[field["name"]].schema()
        assert field["help"] == known[field["name"]].help
        default = declared(Recipe)[field["name"]].default
        assert field["default"] == (None if default is Argument.empty else plain(default))


def test_a_field_says_what_a_command_takes_if_it_is_left_empty() -> None:
    fields = {field["name"]: field for field in command_form("drive").described()["fields"]}
    assert fields["motors"]["default"] is None
    assert fields["motors"]["help"].endswith("; default: reaction")


def _without_words(schema: Any) -> Any:
    """Return the schema of a field without the words that a form knows of its texts."""
    parts = schema.get("anyOf", [])
    if any("enum" in part for part in parts) and any(part.get("type") == "string" for part in parts):
        title = {"title": schema["title"]} if "title" in schema else {}
        return title | next(part for part in parts if part.get("type") == "string")
    return schema | ({"anyOf": [_without_words(part) for part in parts]} if parts else {})


def _every_field() -> Iterator[Field]:
    """Every field of every form, those of obstacles and commands too."""
    yield from (field for group in global_groups() for field in group["fields"])
    yield from (field for kind in kinds() for field in kind["fields"])
    yield from (field for name in COMMANDS for field in command_form(name).described()["fields"])


def test_every_form_of_a_value_has_a_title_of_its_own() -> None:
    unions = [field for field in _every_field() if "anyOf" in field["schema"]]
    chosen = [field for field in unions if not any("enum" in part for part in field["schema"]["anyOf"][:1])]
    assert {field["name"] for field in chosen} >= {"chunks", "difficulty", "crossable_by", "inventory", "size"}
    for field in unions:
        parts = field["schema"]["anyOf"]
        if [*parts[0]] == ["enum"]:
            assert parts[1]["type"] == "string", field  # words, or another text
        else:
            titles = [part["title"] for part in parts]
            assert len(set(titles)) == len(titles) > 1
    chunks = next(field for field in unions if field["name"] == "chunks")
    assert [part["title"] for part in chunks["schema"]["anyOf"]] == ["square", "x and y"]


def test_a_slider_goes_where_most_people_need_it_and_the_default_is_well_inside() -> None:
    sliders = {field["name"]: field for field in _every_field() if field["slider"]}
    assert {"chunk_size", "levels", "softness", "rails", "duration", "rows", "kerf_mm"} <= sliders.keys()
    for field in sliders.values():
        low, high = field["slider"] or (0, 0)
        schema = field["schema"]
        assert schema.get("minimum", low) <= low < high <= schema.get("maximum", high)
        assert high - low <= 200
        if isinstance(field["default"], int | float):
            assert low <= field["default"] <= high, field["name"]
    low, high = sliders["chunk_size"]["slider"] or (0, 0)
    assert 0.1 < (10 - low) / (high - low) < 0.5
    assert "first_map" not in sliders
    assert "heading" not in sliders


def test_what_is_needed_is_asked_for_in_a_sentence(tmp_path: Path) -> None:
    asked = {
        (name, field["name"]): field["missing"]
        for name in COMMANDS
        for field in command_form(name).described()["fields"]
        if field["required"]
    }
    assert asked["export", "formats"] == "Choose at least one format."
    assert asked["rate", "robot"] == "Choose a robot."
    assert asked["import", "file"] == "Enter the name of a file."
    assert asked["scan", "clouds"] == "Enter the name of at least one cloud."
    for (command, name), sentence in asked.items():
        with pytest.raises(ParameterError) as error:
            command_form(command).arguments({}, Places(tmp_path))
        assert (error.value.where, error.value.problem) == (name, sentence)


def test_the_parameters_of_the_paper_are_shown_at_once() -> None:
    shown = [field["name"] for group in global_groups() for field in group["fields"] if field["basic"]]
    assert shown == ["maps", "chunk_size", "chunks", "unit_cm", "boundary", "mesh_type", "seed"]


def test_every_kind_has_its_own_parameters_and_those_of_its_place() -> None:
    made = {kind["name"]: kind for kind in kinds()}
    assert made.keys() == set(KINDS)
    for name, cls in KINDS.items():
        fields = [field["name"] for part in ("fields", "place") for field in made[name][part]]
        assert sorted(fields) == sorted(row_parameters(cls))
    assert [field["name"] for field in made["peak"]["fields"]][:2] == ["levels", "softness"]


def test_a_form_knows_no_word_of_a_schema_that_the_protocol_has_not() -> None:
    words: set[str] = set()

    def look(schema: Any) -> None:
        for part in schema if isinstance(schema, list) else [schema]:
            if isinstance(part, dict):
                words.update(part)
                for name in ("anyOf", "items", "prefixItems"):
                    look(part.get(name, []))

    known = hello(Host(folder=Path()))
    look([field["schema"] for group in known["globals"] for field in group["fields"]])
    look([field["schema"] for kind in known["kinds"] for field in (*kind["fields"], *kind["place"])])
    look([field["schema"] for command in known["commands"] for field in command["fields"]])
    assert words <= {
        *("type", "enum", "minimum", "maximum", "pattern", "anyOf", "items", "prefixItems", "minItems", "maxItems"),
        *("minLength", "title"),
    }


def test_hello_is_json_and_names_what_there_is(tmp_path: Path) -> None:
    known = json.loads(json.dumps(hello(Host(folder=tmp_path)), allow_nan=False))
    assert known["folder"] == str(tmp_path.resolve())
    assert [command["name"] for command in known["commands"]] == list(COMMANDS)
    assert {robot["name"] for robot in known["robots"]} >= {"burger", "crawler", "jackal"}


def test_every_command_of_a_page_is_one_of_the_shell() -> None:
    assert set(COMMANDS) < set(all_commands())
    assert all(command_form(name).help == all_commands()[name].help for name in COMMANDS)


def test_a_menu_has_the_groups_and_titles_that_commands_declare() -> None:
    described = [command_form(name).described() for name in COMMANDS]
    for command in described:
        declaration = all_commands()[command["name"]]
        assert command["group"] == declaration.group
        assert command["title"] == declaration.title
        assert command["title"][0].isupper()
    groups = list(dict.fromkeys(command["group"] for command in described))
    assert groups == [group for group in GROUPS if group in groups]
    assert groups[:3] == ["make worlds", "measure", "drive a robot"]
    assert len({command["title"] for command in described}) == len(described)


def _values(schema: Any) -> st.SearchStrategy[Any]:
    """Return a strategy for the values that a field's schema allows."""
    if "enum" in schema:
        return st.sampled_from(schema["enum"])
    if "anyOf" in schema:
        return st.one_of([_values(part) for part in schema["anyOf"]])
    low, high = schema.get("minimum", -1000), schema.get("maximum", 10**6)
    known: dict[str, Callable[[], st.SearchStrategy[Any]]] = {
        "boolean": st.booleans,
        "integer": lambda: st.integers(low, high),
        "number": lambda: st.floats(low, high, allow_nan=False) | st.integers(int(low) + 1, int(high)),
        "array": lambda: st.lists(
            _values(schema["items"]), min_size=schema.get("minItems", 0), max_size=min(schema.get("maxItems", 4), 6)
        ),
    }
    return known.get(schema["type"], lambda: st.from_regex(r"[a-z][a-z0-9_-]{0,8}", fullmatch=True))()


_TEXTS = {
    "formats": st.lists(st.sampled_from(["stl", "mjcf shape=hfield", "heightmap"]), min_size=1),
    "inventory": st.sampled_from([[3, 4], [1]]),
    "crossable_by": st.sampled_from(["burger", [7.5, 7, 30]]),
    "level_colours": st.just(["#aa0000", "#00bb00"]),
    "frame_colour": st.just("#aa0000"),
    "difficulty": st.sampled_from([0.5, [0.25, 1]]),
    "robot": st.sampled_from(["burger", "crawler"]),
}
"""Values of sorts that are more than their schema says."""


def _refused(form: CommandForm, values: dict[str, Any], folder: Path) -> str:
    """Return the name of a value that a form refuses; nothing if it refuses none."""
    try:
        form.arguments(values, Places(folder))
    except ParameterError as error:
        return error.where.partition("[")[0]
    return ""


@pytest.mark.parametrize("name", COMMANDS)
@given(data=st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=4)
def test_the_parser_of_a_command_takes_what_a_form_gives(name: str, tmp_path: Path, data: st.DataObject) -> None:
    form = command_form(name)
    values: dict[str, Any] = {}
    for field in form.described()["fields"]:
        if field["required"] or data.draw(st.booleans(), label=field["name"]):
            values[field["name"]] = data.draw(
                _TEXTS[field["name"]] if field["name"] in _TEXTS else _values(field["schema"])
            )
    # A text of a schema without its pattern's whole meaning is refused where it stands, and then left out.
    while refused := _refused(form, values, tmp_path):
        assert refused in values
        del values[refused]
    flags, others = form.arguments(values, Places(tmp_path))
    target = ["my.yaml"] if form.takes_recipe else []
    output = ["--output=out"] if form.needs_output else []
    after = ["--", *others, *target] if others or target else []
    parsed = parser_of(name).parse_args([*flags, *output, *after])
    for key, value in values.items():
        action, said = form.fields[key], getattr(parsed, key)
        known = getattr(action, "declared", None)
        if action.nargs == 0:
            default = bool(known and known.default is True)
            assert bool(said if said is not None else default) is value
        elif known and not hasattr(known.sort, "repeats") and key not in ("robot", "crossable_by"):
            assert known.sort.check(key, known.sort.parse(said)) == known.sort.check(key, value)
        elif key == "formats":
            assert said == value


@pytest.mark.parametrize(
    ("command", "values", "message"),
    [
        ("drive", {"duration": -1}, "duration: -1 is outside 0.1..100000 s"),
        ("drive", {"speeed": 1}, "unknown parameter of drive 'speeed'"),
        ("drive", {"force": True}, "unknown parameter of drive 'force'"),
        ("drive", {"target": "/etc/passwd"}, "unknown parameter of drive 'target'"),
        ("drive", {"robot": "/etc/robot.sdf"}, "robot: /etc/robot.sdf: is outside"),
        ("drive", {"robot": "../robot.sdf"}, "robot: ../robot.sdf: is outside"),
        ("drive", {"robot": "../robot.xacro a:=1"}, "robot: ../robot.xacro: is outside"),
        ("series", {"robot": "/etc/robot.sdf"}, "robot: /etc/robot.sdf: is outside"),
        ("import", {"file": "a.csv", "crossable_by": "../robot.sdf"}, "crossable_by: ../robot.sdf: is outside"),
        ("drive", {"contacts": "no"}, "contacts: 'no' is neither yes nor no"),
        ("experiment", {}, "plan: Choose a plan."),
        ("experiment", {"plan": "../plan.yaml"}, "plan: ../plan.yaml: is outside"),
        ("scan", {"clouds": ["a.ply", "/etc/b.ply"]}, "clouds: /etc/b.ply: is outside"),
        ("sheet", {"csv": "../a.csv"}, "csv: ../a.csv: is outside"),
        ("remove", {"names": ["a\nb"]}, "names: 'a\\nb' is not a text"),
        ("generate", {"formats": ["nope"]}, "--formats: unknown format 'nope'"),
    ],
)
def test_what_is_wrong_is_one_line(command: str, values: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError) as error:
        command_form(command).arguments(values, Places(tmp_path))
    assert message in str(error.value)


def test_a_robot_of_a_file_is_looked_for_in_the_folder(tmp_path: Path) -> None:
    for name, given_ in (("mine.sdf", "mine.sdf"), ("my robot.sdf", "my robot.sdf"), ("a.xacro", "a.xacro n:=2")):
        flags, _ = command_form("drive").arguments({"robot": given_}, Places(tmp_path))
        assert flags == [f"--robot={tmp_path.resolve() / name}{given_.removeprefix(name)}"]


def test_an_unknown_command_is_refused() -> None:
    for name in ("gui", "schema", "completion", "rm"):
        with pytest.raises(UnknownName):
            command_form(name)


def test_a_value_that_begins_with_a_dash_is_no_flag(tmp_path: Path) -> None:
    flags, others = command_form("spawn").arguments({"at": [-2, 0], "name": "x-1"}, Places(tmp_path))
    parsed = parser_of("spawn").parse_args([*flags, "--", "a.yaml"])
    assert (parsed.at, parsed.name, others) == ("-2,0", "x-1", [])
    _, others = command_form("remove").arguments({"names": ["--timeout"]}, Places(tmp_path))
    assert parser_of("remove").parse_args(["--", *others]).names == ["--timeout"]
