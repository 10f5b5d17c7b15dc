"""One rating of a robot by drives and by predictions, of which many tests look at something."""

from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import pytest

from rsegen.cli.edge import main


@dataclass(frozen=True)
class Rated:
    """The folder of a rating, the line that a dry run prints, and those that its command prints."""

    folder: Path
    planned: str
    printed: str


@pytest.fixture(scope="session")
def of_jackal(tmp_path_factory: pytest.TempPathFactory) -> Rated:
    """Eight fields, each driven for six seconds and predicted; for tests that only read it."""
    folder = tmp_path_factory.mktemp("rated") / "out"
    command = ["rate", "jackal", "--by", "prediction,mujoco", "--trials", "8", "--seed", "7", "--duration", "6"]
    command += ["-o", str(folder)]
    planned, printed = StringIO(), StringIO()
    with redirect_stdout(planned):
        assert main([*command, "--dry-run"]) == 0
    assert not folder.exists()
    with redirect_stdout(printed):
        assert main(command) == 0
    return Rated(folder=folder, planned=planned.getvalue(), printed=printed.getvalue())
