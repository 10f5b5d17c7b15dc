"""Numbers of the page: no integer is rounded on its way, and what people type is read as they mean it, or refused."""

from __future__ import annotations

import json
from pathlib import Path
from shutil import which
from subprocess import run
from typing import Any

import pytest

from rsegen.page import browser as page_files

_APP = Path(page_files.__file__).parent / "app"
_ESBUILD = _APP / "node_modules" / ".bin" / "esbuild"


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The module as a script for node."""
    if not which("node") or not _ESBUILD.exists():
        pytest.skip("no node, or no esbuild: run npm ci in src/rsegen/page/browser/app")
    made = tmp_path_factory.mktemp("exact") / "exact.cjs"
    run(
        [_ESBUILD, "exact.ts", "--bundle", "--format=cjs", f"--outfile={made}"],
        cwd=_APP,
        check=True,
        capture_output=True,
    )
    return made


def _evaluated(script: Path, expression: str) -> Any:
    program = f"const exact = require({json.dumps(str(script))}); console.log(JSON.stringify({expression}))"
    return json.loads(run(["node", "-e", program], check=True, capture_output=True, text=True).stdout)


@pytest.mark.parametrize(
    "text",
    [
        '{"seed":9223372036854775807,"x":-1.7368213674154025}',
        '{"seed":-9007199254740993,"text":"1234567890123456789, \\"9223372036854775807\\""}',
        '{"list":[1,18446744073709551615,0.1,1e-7]}',
        '{"small":[1,2.5,"a"]}',
    ],
)
def test_json_comes_back_with_all_its_digits(script: Path, text: str) -> None:
    assert _evaluated(script, f"exact.written(exact.read({json.dumps(text)}))") == text


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("7.5", 7.5),
        ("7,5", 7.5),
        (" -0,25 ", -0.25),
        ("\u22123", -3),
        ("1e-3", 0.001),
        (",5", 0.5),
        ("2.125", 2.125),
        ("755", 755),
    ],
)
def test_a_number_is_read_in_any_locale(script: Path, text: str, number: float) -> None:
    assert _evaluated(script, f"exact.typed({json.dumps(text)}, false)") == number


@pytest.mark.parametrize(
    "text", ["", "1 000", "1.000,5", "1'000", "1,000", "0x10", "7.5.5", "1/2", "0.12345678901234567", "1e999"]
)
def test_what_is_no_number_or_would_be_rounded_is_refused_with_its_reason(script: Path, text: str) -> None:
    reason = _evaluated(script, f"exact.typed({json.dumps(text)}, false)")
    assert isinstance(reason, str)
    assert reason


def test_a_whole_number_has_no_decimals(script: Path) -> None:
    assert _evaluated(script, "[exact.typed('5', true), typeof exact.typed('5.0', true)]") == [5, "string"]


@pytest.mark.parametrize(("text", "numbers"), [("0,5 1", [0.5, 1]), ("1; 2,5", [1, 2.5]), ("0.5, 0.6", [0.5, 0.6])])
def test_numbers_in_a_row_may_have_decimal_commas(script: Path, text: str, numbers: list[float]) -> None:
    assert _evaluated(script, f"exact.typedList({json.dumps(text)}, false)") == numbers


def test_heights_are_multiples_without_the_dust_of_binary_fractions(script: Path) -> None:
    assert _evaluated(script, "[exact.times(0.1, 3), exact.times(7.55, 100)]") == [0.3, 755]
