"""Every parameter refuses what its sort does not take, gives one canonical form, and is described by its schema."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

import jsonschema
import numpy as np
import pytest

from rsegen import Peak, Recipe
from rsegen.errors import ParameterError
from rsegen.obstacles.matrix import Rows
from rsegen.obstacles.random import Counts, Weights
from rsegen.params.sorts import (
    ANYWHERE,
    CellRef,
    Choice,
    Flag,
    Float,
    Integer,
    ListOf,
    Parameter,
    Size2D,
    Text,
    as_int,
    parse_int,
)
from tests.support.wrong_values import EVERY, right, wrong_texts, wrong_values

PARAMETER = pytest.mark.parametrize(("owner", "name"), EVERY, ids=[".".join(one) for one in EVERY])


def refusal(parameter: Parameter, value: object) -> str:
    """Message of a parameter of the name `here` on a value; empty if it takes it."""
    try:
        parameter.check("here", value)
    except ParameterError as error:
        return str(error)
    return ""


@PARAMETER
def test_a_parameter_refuses_values_outside_its_sort(owner: str, name: str) -> None:
    parameter = EVERY[owner, name]
    given = [*wrong_values(name, parameter), *map(parameter.parse, wrong_texts(name, parameter))]
    said = [(value, refusal(parameter, value)) for value in given]
    wrong = [
        (value, text)
        for value, text in said
        if not text.startswith("here") or "\n" in text or right(parameter) not in text or len(text) > 1000
    ]
    assert wrong == []


BOUNDS: Mapping[str, tuple[Parameter, list[object], list[object]]] = {
    "integer": (Integer(2, 5), [2, 5, 5.0, np.int64(3)], [1, 6, 2.5, "2", True, None]),
    "integer from": (Integer(2), [2, 10**400], [1, -(10**400)]),
    "float": (Float(0.5, 2), [0.5, 2, np.float32(1), 1.25], [0.49, 2.01, math.nan, "1", True, None, 10**400]),
    "float any": (Float(), [-1e308, 1e308], [math.inf, -math.inf]),
    "choice": (Choice(("a", "b")), ["a", "b"], ["c", "A", "", None, 1]),
    "flag": (Flag(), [True, False], [1, 0, "yes", None]),
    "text": (Text("[a-z]{1,3}", "small letters"), ["a", "abc"], ["", "abcd", "a\n", "A", 1, None]),
    "any text": (Text(".*", "a line"), ["", "\U0001f600"], ["\ud800", "a\udfffb", "a\nb"]),
    "list": (ListOf(Integer(0, 9)), [[0], [1, 9], (3,), 4], [[], [10], [1, [2]], -1, None]),
    "triple": (ListOf(Integer(0, 9), 3), [[1, 2, 3]], [[1, 2], [1, 2, 3, 4], 1, "1,2,3"]),
    "cell": (CellRef(), [[0, 0], ["random", 3], "random", (2.0, 1)], [[-1, 0], [0], [0, 0, 0], "any", [0, "any"], 1]),
    "size": (Size2D(), [1, 10**9, [1, 10**9]], [0, 10**9 + 1, [1, 0], [0, 1], [1, 2, 3], "2"]),
    "weights": (Weights(), [[0, 1], [1e12, 0.5]], [[0, 0], [1e13], [-0.1, 1], [], 1]),
    "counts": (Counts(), [[0, 1], [10**9]], [[0, 0], [10**9 + 1], [-1, 1], [0.5], [], 1]),
    "rows": (
        Rows(),
        [["0 1", ". 2"], ["0,1"], [[0, None]]],
        [["0 1", "2"], ["a"], [""], [], "0 1", [[-1]], ["123456"]],
    ),
}


@pytest.mark.parametrize(("parameter", "taken", "refused"), BOUNDS.values(), ids=BOUNDS)
def test_a_sort_takes_values_within_its_bounds_only(
    parameter: Parameter, taken: list[object], refused: list[object]
) -> None:
    assert [value for value in taken if refusal(parameter, value)] == []
    assert [value for value in refused if not refusal(parameter, value)] == []


@pytest.mark.parametrize(("parameter", "taken", "refused"), BOUNDS.values(), ids=BOUNDS)
def test_file_flag_and_schema_share_the_canonical_form_of_a_value(
    parameter: Parameter, taken: list[object], refused: list[object]
) -> None:
    for value in taken:
        canonical = parameter.check("here", value)
        assert parameter.check("here", canonical) == canonical
        written = json.loads(json.dumps(canonical))
        assert parameter.check("here", written) == canonical
        assert parameter.check("here", parameter.parse(parameter.format(written))) == canonical
        if isinstance(written, list) and all(isinstance(part, int | float) for part in written):
            assert parameter.check("here", parameter.parse(str(written))) == canonical, "as a file has it"
        jsonschema.validate(written, parameter.schema())
    for value in refused:
        if isinstance(value, (int, list)) and not isinstance(parameter, (Rows, Counts, Weights)):
            with pytest.raises(jsonschema.ValidationError):
                jsonschema.validate(value, parameter.schema())


def test_canonical_forms() -> None:
    assert type(Integer(0).check("", 2.0)) is int
    assert type(Integer(0).check("", np.int16(2))) is int
    assert type(Float().check("", 2)) is float
    assert Size2D().check("", 3) == (3, 3)
    assert Size2D().check("", [2, 3]) == (2, 3)
    assert CellRef().check("", "random") == ANYWHERE
    assert CellRef().check("", [2.0, "random"]) == (2, "random")
    assert CellRef().parse("(2,3)") == CellRef().parse("[2,3]") == CellRef().parse("2,3") == [2, 3]
    assert ListOf(Integer(0)).check("", 4) == (4,)
    assert Rows().check("", [[0, None], "1,  2"]) == ("0 .", "1 2")
    assert Flag().parse("yes") is True
    assert Flag().parse("no") is False


@pytest.mark.parametrize(
    ("parameter", "value", "said"),
    [
        (Integer(2, 5, unit="units"), 6, "here: 6 is outside 2..5 units"),
        (Integer(2), 1, "here: 1 is not 2 or more"),
        (Integer(2), "1", "here: '1' is not a whole number; expected 2 or more"),
        (Float(0.5, 2, unit="cm"), 3.0, "here: 3.0 is outside 0.5..2 cm"),
        (Float(0, unit="m"), -1, "here: -1 is outside 0 or more m"),
        (Float(0, 1), math.nan, "here: nan is not a finite number; expected 0..1"),
        (Float(0, 1), "1", "here: '1' is not a number; expected 0..1"),
        (Choice(("a", "b")), "c", "here: 'c' is not one of a, b"),
        (Flag(), "maybe", "here: 'maybe' is neither yes nor no"),
        (Text("a", "an a"), "b", "here: invalid value 'b': expected an a"),
        (ListOf(Integer(0, 9)), [], "here: [] is not 0..9, or a list of these"),
        (ListOf(Integer(0, 9), 2), [1], "here: [1] is not 2 values, each 0..9"),
        (ListOf(Integer(0, 9)), [1, 10], "here[1]: 10 is outside 0..9"),
        (CellRef(), [1, -1], "here[1]: -1 is not a coordinate; expected a cell from 0 on, or random"),
        (Size2D(), 0, f"here: 0 is not {Size2D().describe()}"),
        (Weights(), [1, -1], "here[1]: -1 is outside 0..1000000000000"),
        (Weights(), [0, 0], "here: all weights are 0; at least one must be above 0"),
        (Counts(), [1, -1], "here[1]: -1 is outside 0..1000000000"),
        (Counts(), [0, 0], "here: all counts are 0; at least one must be above 0"),
        (Rows(), ["0 1", "2"], "here[1]: has 1 cells, and here[0] 2"),
        (Rows(), ["0 x"], "here[0]: '0 x' is not a row of levels and dots, as in '0 1 . 2'"),
    ],
)
def test_a_message_has_the_place_the_value_and_the_valid_range(parameter: Parameter, value: object, said: str) -> None:
    assert refusal(parameter, value) == said


@pytest.mark.parametrize(
    ("text", "value"), [("12", 12), ("+1", 1), ("-3", -3), ("1.0", "1.0"), ("", ""), ("1_0", "1_0"), ("٣", "٣")]
)
def test_digits_stand_for_a_number_and_other_text_for_itself(text: str, value: object) -> None:
    assert parse_int(text) == value


def test_digits_of_more_than_python_reads_stay_a_text() -> None:
    assert parse_int("9" * 4000) == int("9" * 4000)
    assert parse_int("9" * 4001) == "9" * 4001


def test_only_whole_numbers_are_whole() -> None:
    assert [as_int(value) for value in (2, 2.0, np.uint8(2), 2.5, True, "2", None)] == [2, 2, 2, *[None] * 4]


def test_nothing_is_taken_only_where_it_is_the_default() -> None:
    assert Recipe(seed=1, max_step=None).max_step is None
    with pytest.raises(ParameterError, match=r"^maps: an empty value is not a whole number; expected 1 or more$"):
        Recipe(seed=1, maps=None)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"^softness: an empty value is not a number; expected 0..100 %$"):
        Peak(levels=5, softness=None)  # type: ignore[arg-type]
