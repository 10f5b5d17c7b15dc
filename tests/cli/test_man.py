"""`rsegen man`, judged by groff."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess

import pytest

from rsegen.cli.command_line import parser_of
from rsegen.cli.edge import main
from rsegen.params.capabilities import commands
from tests.support.complaints import exit_code, the_line

Capture = pytest.CaptureFixture[str]


def page(capsys: Capture, *command: str) -> str:
    assert main(["man", *command]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(
    "command", [[], *([name] for name in commands())], ids=lambda words: "".join(words) or "rsegen"
)
def test_a_page_has_every_flag_and_groff_warns_of_nothing(command: list[str], capsys: Capture) -> None:
    if not shutil.which("groff"):
        pytest.skip("no groff here")
    roff = page(capsys, *command)
    shown = subprocess.run(
        ["groff", "-man", "-ww", "-Tascii", "-P-cbou", "-rLL=5000n"],
        input=roff,
        capture_output=True,
        text=True,
        check=True,
    )
    assert shown.stderr == ""
    words = set(re.split(r"[\s,=]+", shown.stdout))
    actions = parser_of(command[0]).actions if command else []
    flags = [flag for action in actions if action.help != argparse.SUPPRESS for flag in action.option_strings]
    wanted = flags if command else commands()
    assert [word for word in wanted if word not in words] == []
    assert f"rsegen{''.join(f'-{name}' for name in command)} - " in " ".join(shown.stdout.split())


def test_a_page_of_no_command_is_refused(capsys: Capture) -> None:
    assert exit_code("man", "generat") == 2
    assert "unknown command 'generat'; did you mean 'generate'?" in the_line(capsys.readouterr().err)
