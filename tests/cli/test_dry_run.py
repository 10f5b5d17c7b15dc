"""A dry run changes nothing, and lists exactly what the run then does to the disk."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rsegen.cli.command_line import parser_of
from rsegen.cli.edge import main
from rsegen.params.capabilities import commands
from tests.support.long import long_unless

MAPS = ["peak", "--seed", "3", "--maps", "2"]
GENERATE = ["generate", *MAPS, "-o", "out"]
EXPORT = ["export", *MAPS, "-o", "out"]
DATASET = ["dataset", *MAPS, "-o", "out"]
SERIES = ["series", "peak", "--seed", "3", "--maps", "3", "-o", "out"]
PACKAGE = ["export", *MAPS, "--to", "ros2 package=course", "-o", "out"]

RUNS = {
    "new maps": [GENERATE],
    "maps with pictures and files": [[*GENERATE, "--preview", "--sheet", "--formats", "stl,mjcf"]],
    "maps that are replaced": [[*GENERATE, "--preview"], [*GENERATE, "--force"]],
    "maps of which one is complete": [[*GENERATE, "--maps", "1"], [*GENERATE, "--resume"]],
    "a series": [SERIES],
    "a series that is complete": [SERIES, [*SERIES, "--resume"]],
    "a series that is replaced": [SERIES, [*SERIES, "--force"]],
    "maps of other programs": [[*EXPORT, "--to", "stl"]],
    "a format beside others": [[*GENERATE, "--formats", "stl"], [*EXPORT, "--to", "arrays"]],
    "a format that is replaced": [[*GENERATE, "--formats", "mjcf"], [*EXPORT, "--to", "mjcf shape=mesh", "--force"]],
    "formats that are complete": [[*EXPORT, "--to", "stl"], [*EXPORT, "--to", "stl", "--resume"]],
    "maps in one package": [PACKAGE],
    "a package that is complete": [PACKAGE, [*PACKAGE, "--resume"]],
    "a package that is replaced": [PACKAGE, [*PACKAGE, "--maps", "1", "--force"]],
    "a data set": [DATASET],
    "a data set that is complete": [DATASET, [*DATASET, "--resume"]],
    "a data set that is replaced": [DATASET, [*DATASET, "--metrics", "none", "--force"]],
    "a terrain": [["terrain", "peak", "--seed", "3", "--rows", "2", "--columns", "2", "-o", "out"]],
    "a picture": [["preview", "peak", "--seed", "3", "-o", "pictures/peak.svg"]],
    "a picture that is replaced": [
        ["preview", "peak", "-o", "peak.png"],
        ["preview", "peak", "-o", "peak.png", "--force"],
    ],
    "a build sheet": [["sheet", "peak", "--seed", "3", "-o", "sheet.pdf", "--csv", "lists/sheet.csv"]],
    "a page": [["view", "peak", "--seed", "3", "-o", "peak.html"]],
    "examples": [["examples", "-o", "recipes"]],
}
"""Commands that are run one after the other; the last one is run dry before it."""


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    "commands",
    long_unless(lambda runs: len(runs) > 1 or len(runs[0]) < 9, RUNS.values(), reason="a command more"),
    ids=RUNS,
)
def test_a_dry_run_lists_what_the_run_does(
    commands: list[list[str]], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    *before, command = commands
    for each in before:
        assert main([*each, "--quiet"]) == 0
    old = tree(here)
    folders = sorted(here.rglob("*"))
    capsys.readouterr()
    assert main([*command, "--dry-run", "--json"]) == 0
    fates = {fate: set(names) for fate, names in json.loads(capsys.readouterr().out).items()}
    assert tree(here) == old
    assert sorted(here.rglob("*")) == folders
    assert main([*command, "--quiet"]) == 0
    new = tree(here)
    assert fates["write"] == new.keys() - old.keys()
    assert fates["remove"] == old.keys() - new.keys()
    changed = {name for name in old.keys() & new.keys() if old[name] != new[name]}
    assert changed <= fates["replace"] <= old.keys() & new.keys()
    assert fates["keep"] <= old.keys() - fates["replace"] - fates["remove"]


def test_the_maps_that_a_resumed_run_keeps_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*GENERATE, "--maps", "1", "--quiet"]) == 0
    assert main([*GENERATE, "--resume", "--dry-run", "--json"]) == 0
    fates = json.loads(capsys.readouterr().out)
    assert "out/peak_0000/peak_0000.world" in fates["keep"]
    assert "out/peak_0001/peak_0001.world" in fates["write"]


@pytest.mark.parametrize("command", [DATASET, PACKAGE, GENERATE, [*EXPORT, "--to", "mjcf"]])
def test_a_resumed_run_that_is_complete_keeps_every_file(
    command: list[str], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*command, "--quiet"]) == 0
    assert main([*command, "--resume", "--dry-run", "--json"]) == 0
    fates = json.loads(capsys.readouterr().out)
    kept = set(fates.pop("keep"))
    assert not any(fates.values())
    assert kept == set(tree(here))


def test_what_a_person_reads_ends_with_the_counts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "peak", "-o", "peak.html", "--dry-run"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "write   peak.html",
        "a dry run: 1 to write; nothing was changed",
    ]


@pytest.mark.parametrize("command", [GENERATE, [*EXPORT, "--to", "stl"], SERIES, DATASET, PACKAGE])
def test_what_refuses_a_run_refuses_its_dry_run(
    command: list[str], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*command, "--quiet"]) == 0
    said = []
    for flags in ([], ["--dry-run"]):
        assert main([*command, *flags]) == 2
        said.append(capsys.readouterr().err)
    assert said[0] == said[1] != ""


@pytest.mark.parametrize("command", commands())
def test_every_command_that_replaces_files_has_a_dry_run(command: str) -> None:
    flags = parser_of(command).flags
    assert ("--force" in flags) == ("--dry-run" in flags)


def test_a_folder_that_cannot_be_written_refuses_the_dry_run(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "file").write_text("")
    assert main(["preview", "peak", "-o", "file/peak.png", "--dry-run"]) == 2
    assert "file" in capsys.readouterr().err
