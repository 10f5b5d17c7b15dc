"""rsegen completion: what makes a shell complete commands, flags and their words."""

from __future__ import annotations

import argparse
import os

from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.errors import UnknownName

_SHELLS = ("bash", "zsh", "fish")


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print what makes a shell complete commands, flags and their words when Tab is pressed."
    epilog = (
        'For good: eval "$(rsegen completion bash)" in ~/.bashrc, the same with zsh in ~/.zshrc after compinit, or '
    )
    command = add_command(
        commands,
        "completion",
        text=text,
        epilog=f"{epilog}rsegen completion fish > ~/.config/fish/completions/rsegen.fish.",
    )
    text = f"{', '.join(_SHELLS)} (default: that of $SHELL)"
    command.add_argument("shell", nargs="?", metavar="SHELL", help=text)


def run(arguments: argparse.Namespace) -> Report:
    """Print it: argcomplete asks rsegen itself at each Tab."""
    from argcomplete.shell_integration import shellcode

    shell = arguments.shell or os.path.basename(os.environ.get("SHELL", "bash"))
    if shell not in _SHELLS:
        raise UnknownName.among("", "shell", shell, _SHELLS)
    code = shellcode(["rsegen"], shell=shell)
    return Report(lines=[code.rstrip("\n")], content={"shell": shell, "code": code})
