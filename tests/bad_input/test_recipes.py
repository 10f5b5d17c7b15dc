"""Errors of files and obstacles that no single parameter can answer for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pytest

from rsegen import KINDS, Recipe
from rsegen.params.sorts import parameters
from tests.support.complaints import (
    BOMB,
    Refused,
    recipe,
)

OBSTACLES: Mapping[str, tuple[str, Sequence[str]]] = {
    "nothing": ("", ["expected a kind and then KEY=VALUE"]),
    "a misspelt kind": ("peek levels=5", ["'peek'", "did you mean 'peak'?", *KINDS]),
    "a kind of another world": ("volcano levels=5", ["'volcano'", *KINDS]),
    "a misspelt parameter": ("peak levls=5", ["'levls'", "did you mean 'levels'?", "softness", "first"]),
    "the paper's word": ("peak max_height=5", ["unknown parameter of peak 'max_height'", "known: ", "levels"]),
    "another kind's parameter": ("peak levels=5 weights=1,2", ["'weights'", "parameter of peak", "softness"]),
    "no height": ("peak", ["levels: missing; expected 2..32767 (number of levels: 5 levels of 10 cm are"]),
    "no equals sign": ("peak levels", ["'levels' is not KEY=VALUE"]),
    "spaces round the equals sign": ("peak levels = 5", ["'levels' is not KEY=VALUE, written without blanks"]),
    "a parameter twice": ("peak levels=5 levels=6", ["levels: is given twice"]),
    "a kind twice": ("peak kind=random levels=5", ["kind: is given twice"]),
    "an open quotation mark": ("peak 'levels=5", ["KEY=VALUE"]),
    "ends that share no coordinate": (
        "horizontal_barrier levels=5 first=1,2 last=3,4",
        ["last: first [1, 2] and last [3, 4] share neither x nor y"],
    ),
    "a cell beyond the map": (
        "peak levels=5 first=0,10",
        ["--obstacle 'peak levels=5 first=0,10': first[1]: 10 is outside 0..9: the map has 10 x 10 blocks"],
    ),
    "a bracket that is open": ("peak levels=5 first=(2,2", ["first[0]: '(2' is not a coordinate"]),
    "brackets around nothing": ("peak levels=5 first=()", ["first: '()' is not a place"]),
    "a cell very far beyond it": ("peak levels=5 last=" + "9" * 4000 + ",0", ["last[0]", "is outside 0..9"]),
    "too few weights": ("random levels=3 weights=1,2", ["weights: 2 weights for 3 levels"]),
    "too many weights": ("random levels=3 weights=1,2,3,4", ["weights: 4 weights for 3 levels"]),
    "weights of nothing": ("random levels=3 weights=0,0,0", ["weights: all weights are 0"]),
}


@pytest.mark.parametrize(("text", "words"), OBSTACLES.values(), ids=OBSTACLES)
def test_an_obstacle_as_a_flag(refused: Refused, text: str, words: Sequence[str]) -> None:
    line = refused("generate", "--obstacle", text, "-o", "out")
    assert [word for word in words if word not in line] == []


YAML: Mapping[str, tuple[str | bytes, Sequence[str]]] = {
    "empty": ("", ["an empty value is not a recipe", "obstacles:"]),
    "a comment only": ("# to do\n", ["an empty value is not a recipe"]),
    "a list": ("- kind: peak\n", ["is not a recipe", "expected keys"]),
    "a word": ("hello\n", ["'hello' is not a recipe"]),
    "an unknown key": ("sneed: 1\n", ["unknown key 'sneed'", "did you mean 'seed'?", *parameters(Recipe)]),
    "a key that is a number": ("1: 2\n", ["unknown key 1"]),
    "a key that is a list": ("? [1]\n: 2\n", ["recipe.yaml:1:3", "unhashable key"]),
    "a key of two lines": ('"a\\nb": 1\n', ["'a\\nb'"]),
    "a key of many letters": (f"{'k' * 900}: 1\n", ["unknown key 'kkk"]),
    "a key that is given twice": ("seed: 1\nmaps: 1\nseed: 2\n", ["recipe.yaml:3", "'seed' is given twice"]),
    "a key twice in a row": (
        "obstacles:\n  - kind: peak\n    kind: random\n    levels: 3\n",
        ["recipe.yaml:3", "'kind' is given twice"],
    ),
    "a merge key": ("<<: {seed: 1}\n", ["merge keys ('<<') are not supported", "write the keys out"]),
    "obstacles that are no list": ("obstacles: {kind: peak}\n", ["obstacles: ", "is not a list", "'- kind: '"]),
    "obstacles that are nothing": ("obstacles:\n", ["obstacles: an empty value is not a list"]),
    "an obstacle that is a word": (
        "obstacles: [peak]\n",
        ["obstacles[0]: 'peak' is not an obstacle", "expected kind:"],
    ),
    "an obstacle that is nothing": ("obstacles: [null]\n", ["obstacles[0]: an empty value is not an obstacle"]),
    "an obstacle without a kind": (
        "obstacles: [{levels: 3}]\n",
        ["obstacles[0].kind: missing; choose a kind of", *KINDS],
    ),
    "a kind that is a list": ("obstacles: [{kind: [peak], levels: 3}]\n", ["obstacles[0].kind", *KINDS]),
    "two obstacles of one key": (
        "obstacles: [{kind: peak, levels: 3, key: a}, {kind: peak, levels: 3, key: a}]\n",
        ["obstacles[1].key: 'a' is another obstacle's key too"],
    ),
    "a cell beyond the map": (
        "chunks: [1, 2]\nobstacles: [{kind: peak, levels: 3, first: [0, 19], last: [10, 0]}]\n",
        ["obstacles[0].last[0]: 10 is outside 0..9: the map has 10 x 20 blocks; larger chunks or chunk_size give more"],
    ),
    "a format of the future": ("version: 3\n", ["version: 3 is not 2"]),
    "a format of the past": ("version: 1\n", ["version: 1 is not 2"]),
    "a date": ("seed: 2022-02-02\n", ["seed: datetime.date(2022, 2, 2) is not a whole number"]),
    "a date that is none": ("seed: 2022-13-45\n", ["month must be in 1..12"]),
    "binary content": ("seed: !!binary aGVsbG8=\n", ["seed: b'hello' is not a whole number"]),
    "an object of Python": (
        "!!python/object/apply:os.mkdir [owned]\n",
        ["recipe.yaml:1:1", "not YAML", "python/object"],
    ),
    "an object in a value": ("seed: !!python/object/apply:os.mkdir [owned]\n", ["recipe.yaml:1:7", "not YAML"]),
    "a tag that lies": ("maps: !!bool maybe\n", ["not YAML: a value is not what its tag says"]),
    "another tag that lies": ("maps: !!timestamp now\n", ["not YAML: a value is not what its tag says"]),
    "a map that is a list": ("!!map [1]\n", ["recipe.yaml:1:1", "expected a mapping"]),
    "a letter that is none": ('name: "\\UFFFFFFFF"\n', ["not YAML"]),
    "too many digits": (f"seed: {'9' * 9000}\n", ["not YAML", "4300"]),
    "too many digits in base 16": (f"seed: 0x{'f' * 9000}\n", ["seed: a number of thousands of digits is outside 0.."]),
    "a cell of too many digits": (
        f"obstacles: [{{kind: peak, levels: 3, first: [0x{'f' * 9000}, 0]}}]\n",
        ["obstacles[0].first[0]: a number of thousands of digits is outside 0..9"],
    ),
    "wrong indentation": ("obstacles:\n - kind: peak\n  levels: 3\n", ["recipe.yaml:3:3: not YAML"]),
    "a tab": ("obstacles:\n\t- kind: peak\n", ["recipe.yaml:2:1: not YAML"]),
    "an open bracket": ("obstacles: [", ["recipe.yaml:1:13: not YAML"]),
    "two documents": ("seed: 1\n---\nseed: 2\n", ["recipe.yaml:2:1: not YAML"]),
    "an alias of nothing": ("seed: *a\n", ["recipe.yaml:1:7: not YAML", "'a'"]),
    "itself": ("&a {obstacles: [*a]}\n", ["obstacles[0].kind: missing; choose a kind of obstacle"]),
    "itself as a list": ("obstacles: &a [*a]\n", ["obstacles[0]: [[", "is not an obstacle"]),
    "deep nesting": (f"obstacles: {'[' * 600}{']' * 600}\n", ["nested too deeply"]),
    "deep nesting of keys": ("{a: " * 3000, ["nested too deeply"]),
    "a bomb": (BOMB, ["recipe.yaml:1: the aliases up to ", " stand for more than 4 MiB"]),
    "very many obstacles by one alias": (
        "obstacles:\n- &a {kind: peak, levels: 5}\n" + "- *a\n" * 200_000,
        ["recipe.yaml:64529: the aliases up to 'a' stand for more than 4 MiB"],
    ),
    "a matrix of very many rows by one alias": (
        f"obstacles: [{{kind: matrix, levels: 2, rows: [&r '{'1 ' * 10_000}'{', *r' * 10_000}]}}]\n",
        ["the aliases up to 'r' stand for more than 4 MiB"],
    ),
    "a number to the base of 60": (f"seed: 1{':1' * 200_000}\n", ["seed: '1:1", "is not a whole number"]),
    "a number with an exponent as a name": ("name: 1e3\n", ["name: invalid value 1000"]),
    "a number that is too large": ("unit_cm: 1e999\n", ["unit_cm: inf is not a finite number"]),
    "a time of day": ("unit_cm: 1:30\n", ["unit_cm: '1:30' is not a number"]),
    "a mapping with the tag of a number": ("name: !!int {a: 1}\n", ["not YAML: expected a scalar node"]),
    "a number in base 8": ("seed: 010\n", [":1: '010' is a number in base 8 in YAML 1.1", "without the 0 in front"]),
    "too many digits in base 8": (f"seed: 0{'7' * 9000}\n", ["is a number in base 8 in YAML 1.1"]),
    "a fraction to the base of 60": (f"unit_cm: 1{':1' * 200_000}.5\n", ["unit_cm: '1:1", "is not a number"]),
    "more weights than levels": (
        f"obstacles: [{{kind: random, levels: 2, weights: [{'1,' * 40_000}]}}]\n",
        ["obstacles[0].weights: 40,000 values; at most 32,767 are allowed"],
    ),
    "more counts than levels": (
        f"obstacles: [{{kind: random, levels: 2, counts: [{'1,' * 40_000}]}}]\n",
        ["obstacles[0].counts: 40,000 values; at most 32,767 are allowed"],
    ),
    "an inventory of too many levels": (
        f"inventory: [{'1,' * 40_000}]\n",
        ["inventory: 40,000 values; at most 32,767 are allowed"],
    ),
    "any bytes": (bytes(range(256)), ["not a text in UTF-8"]),
    "another encoding": ("description: über".encode("latin-1"), ["not a text in UTF-8"]),
    "sixteen bits a letter": ("seed: 1\n".encode("utf-16"), ["not a text in UTF-8"]),
    "a null character": (b"seed: 1\n\0", ["not YAML", "#x0000"]),
    "a bell": (b"name: \a\n", ["not YAML", "#x0007"]),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(100), ["a PNG image, and not a recipe"]),
    "a huge file": (b"#" * (4 * 2**20 + 1), ["larger than 4 MiB", "JSON: up to 64 MiB"]),
    "very many keys": (f"{{{', '.join(f'k{key}: 1' for key in range(5000))}}}", ["unknown key 'k0'"]),
}


@pytest.mark.slow
@pytest.mark.parametrize(("content", "words"), YAML.values(), ids=YAML)
def test_a_yaml_file(refused: Refused, content: str | bytes, words: Sequence[str]) -> None:
    line = refused("generate", recipe(content), "-o", "out")
    assert line.startswith("rsegen: recipe.yaml:")
    assert [word for word in words if word not in line] == []


JSON: Mapping[str, tuple[str | bytes, Sequence[str]]] = {
    "empty": ("", ["recipe.json:1:1: not JSON"]),
    "null": ("null", ["an empty value is not a recipe"]),
    "a list": ("[]", ["[] is not a recipe"]),
    "a comma too many": ('{"seed": 1,}', ["recipe.json:1:", "not JSON"]),
    "a comment": ("// mine\n{}", ["recipe.json:1:1: not JSON"]),
    "two documents": ("{}{}", ["recipe.json:1:3: not JSON"]),
    "a key that is given twice": ('{"seed": 1, "seed": 2}', ["'seed' is given twice"]),
    "a key twice in a row": ('{"obstacles": [{"kind": "peak", "kind": "random"}]}', ["'kind' is given twice"]),
    "a number that overflows": ('{"unit_cm": 1e400}', ["unit_cm: inf is not a finite number", "0.001..100000 cm"]),
    "too many digits": (f'{{"seed": {"9" * 9000}}}', ["not a recipe", "4300"]),
    "deep nesting": ("[" * 100_000, ["nested too deeply"]),
    "deep nesting of keys": ('{"a":' * 100_000, ["nested too deeply"]),
    "very many obstacles": (
        f'{{"obstacles": [{"{}," * 200_000}{{}}]}}',
        ["obstacles: 200,001 values; at most 200,000 are allowed"],
    ),
    "very many rows of a matrix": (
        f'{{"obstacles": [{{"kind": "matrix", "levels": 2, "rows": [{"1," * 1_000_000}1]}}]}}',
        ["obstacles[0].rows: 1,000,001 values; at most 1,000,000 are allowed"],
    ),
    "half a letter": ('{"name": "\\ud800"}', ["name: invalid value '\\ud800': expected"]),
    "a new line after the name": ('{"name": "x\\n"}', ["name: invalid value 'x\\n': expected"]),
    "sixteen bits a letter": ("{}".encode("utf-16"), ["not a text in UTF-8"]),
    "a huge file": (b" " * (64 * 2**20 + 1), ["larger than 64 MiB"]),
}


@pytest.mark.parametrize(("content", "words"), JSON.values(), ids=JSON)
def test_a_json_file(refused: Refused, content: str | bytes, words: Sequence[str]) -> None:
    line = refused("generate", recipe(content, "recipe.json"), "-o", "out")
    assert line.startswith("rsegen: recipe.json:")
    assert [word for word in words if word not in line] == []


NAMES = [
    "../../x",
    "a/b",
    "/x",
    "..",
    ".",
    ".hidden",
    "-x",
    "a b",
    '<&">',
    "x\0",
    "ünï",
    "x\n",
    "\n",
    "x" * 65,
    " ",
]


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_a_name_cannot_leave_the_folder_or_break_the_world(refused: Refused, name: str) -> None:
    line = refused("generate", f"--name={name}", "-o", "out")
    assert line.startswith("rsegen: --name: ")
    assert "1..64 letters, digits, _ . -" in line
