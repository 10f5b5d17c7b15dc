"""Output of commands is printable whatever it names, and short enough to be read."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import pytest

from rsegen.cli.edge import main
from rsegen.errors import PluginWarning, line_of, printable
from tests.support.complaints import exit_code, the_line

HOSTILE = {
    "colours": "\x1b[31mred",
    "a carriage return": "a\rb",
    "a bell": "a\x07b",
    "right to left": "a\u202eb",
    "half a pair": "a\udcffb",
    "another line": "a\u2028b",
}


def is_printable(text: str) -> bool:
    return text.replace("\n", "").isprintable()


@pytest.mark.parametrize("name", HOSTILE.values(), ids=HOSTILE)
@pytest.mark.parametrize(
    "command",
    [
        ["info"],
        ["generate", "-o", "out"],
        ["import", "-o", "out"],
        ["dataset", "-o", "out"],
        ["spawn"],
        ["--plugin"],
        [],
    ],
    ids=lambda words: words[0] if words else "command",
)
def test_a_name_in_a_message_is_printable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: list[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code(*command, name) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert is_printable(the_line(err))


@pytest.mark.parametrize("name", HOSTILE.values(), ids=HOSTILE)
def test_a_folder_in_a_report_is_printable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["generate", "peak", "--chunks", "1", "-o", name]) == 0
    out, err = capsys.readouterr()
    assert printable(name).split()[-1] in out
    assert is_printable(out)
    assert err == ""


@pytest.mark.parametrize("name", ["n" * 20_000, "n/" * 10_000, "n " * 10_000, "\x01" * 20_000])
def test_a_long_name_is_shortened_in_the_middle(capsys: pytest.CaptureFixture[str], name: str) -> None:
    for command in (["info", name], ["generate", "peak", "-o", name], ["dataset", "--verify", name], [name]):
        assert exit_code(*command) == 2
        assert "..." in the_line(capsys.readouterr().err)


def test_the_end_of_a_shortened_message_stays() -> None:
    line = line_of(f"{'n' * 20_000}: File name too long")
    assert line.startswith("nnn")
    assert line.endswith("n: File name too long")
    assert len(line) < 400


def test_our_warnings_are_printable_and_warnings_of_libraries_are_hidden(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def warn(_: object) -> None:
        warnings.warn("of ours \x1b[31m", PluginWarning, stacklevel=1)
        warnings.warn("of a library", UserWarning, stacklevel=1)

    monkeypatch.setattr("rsegen.cli.reference.run_schema", warn)
    monkeypatch.setattr(sys, "warnoptions", [])
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert main(["schema"]) == 0
    assert capsys.readouterr().err == "rsegen: warning: of ours \\x1b[31m\n"


def test_a_command_leaves_the_output_as_it_was(capsys: pytest.CaptureFixture[str]) -> None:
    before = sys.stdout
    assert main(["schema"]) == 0
    assert sys.stdout is before
