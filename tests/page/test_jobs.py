"""Commands that pages run are those of a shell: they make the same, say the same, and stop without a trace."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import psutil
import pytest

from rsegen.errors import FileError, ParameterError, UserError
from rsegen.page import documents as hosting
from rsegen.page import jobs, runs, scenes
from rsegen.page.calls import Question
from rsegen.page.host import Host
from rsegen.writing.journal import read_journal
from tests.support.patience import until

pytestmark = pytest.mark.slow

MAP = "peak"


@pytest.fixture
def host(tmp_path: Path) -> Iterator[Host]:
    made, before = Host(folder=tmp_path), set(psutil.Process().children(recursive=True))  # of tests before
    yield made
    made.jobs.close()
    assert not set(psutil.Process().children(recursive=True)) - before


@pytest.fixture
def doc(host: Host) -> str:
    name: str = hosting.open(host, what=MAP)["doc"]
    return name


Start = Callable[..., dict[str, Any]]


@pytest.fixture
def start(host: Host, doc: str) -> Start:
    def started(command: str, output: str = "", *, replace: bool = False, **values: Any) -> dict[str, Any]:
        return runs.run(host, doc=doc, command=command, values=values, output=output, replace=replace)

    return started


def ended(host: Host, job: dict[str, Any]) -> dict[str, Any]:
    """Return a job once it has ended."""

    def now() -> dict[str, Any]:
        return next(each for each in host.jobs.listed() if each["id"] == job["id"])

    until(lambda: now()["state"] != "running")
    return now()


def test_what_a_page_makes_a_shell_makes_of_its_line(host: Host, start: Start, doc: str) -> None:
    hosting.save(host, doc=doc, path="mine.yaml")
    told: list[dict[str, Any]] = []
    host.jobs.changed = told.append
    job = ended(host, start("generate", "worlds", formats=["stl"], sync=False))
    assert (job["state"], job["result"]["folder"]) == ("done", "worlds")
    assert job["line"] == "rsegen generate --no-sync --formats=stl --output=worlds mine.yaml"
    assert {"path": "worlds/peak_0000/recipe.json", "name": "peak_0000", "kind": "recipe"} in job["files"]
    assert any(line.startswith("1 map of") for line in job["lines"])
    assert [each["state"] for each in told][-1] == "done"
    _, *words = shlex.split(job["line"].replace("=worlds", "=by_shell"))
    subprocess.run([sys.executable, "-m", "rsegen", *words], cwd=host.folder, check=True, capture_output=True)
    made, again = (
        {path.relative_to(host.folder / name): path.read_bytes() for path in _files(host.folder / name)}
        for name in ("worlds", "by_shell")
    )
    assert made == again


def _said_by(host: Host, line: str) -> str:
    """Run the line of a shell in the folder of the page, and return what it prints."""
    command = line.replace("rsegen ", f"{sys.executable} -m rsegen ")
    ended_well = subprocess.run(["bash", "-c", command], cwd=host.folder, check=True, capture_output=True, text=True)
    return ended_well.stdout


@pytest.mark.parametrize("command", ["metrics", "spots"])
def test_the_line_of_a_recipe_that_was_never_saved_does_the_same_in_a_shell(
    command: str, host: Host, start: Start, doc: str
) -> None:
    session = host.opened(doc).document.session
    session.set(name="seed", value=11)
    session.set(name="description", value='it\'s "mine" & yours')
    values = {"robot": "burger", "seed": 3} if command == "spots" else {}
    job = ended(host, start(command, **values))
    assert job["state"] == "done"
    assert "peak.yaml" not in job["line"]
    assert runs.shell_line(host, doc=doc, command=command, values=values) == {"text": job["line"], "why": ""}
    # The flag --seed of spots is another one, so the map is made first.
    assert (" && " in job["line"]) == (command == "spots")
    assert "--obstacle" in job["line"]
    assert [*host.folder.iterdir()] == []
    printed = _said_by(host, f"{job['line']} --json")
    begins = re.search(r"^[\[{]", printed, re.MULTILINE)
    assert begins
    assert json.loads(printed[begins.start() :]) == job["result"]


def test_there_is_no_line_while_a_value_is_wrong_or_missing(host: Host, doc: str) -> None:
    line = partial(runs.shell_line, host, doc=doc)
    assert line(command="export", values={}) == {"text": "", "why": "Choose at least one format."}
    assert line(command="metrics", values={}, target="..")["text"] == ""
    wrong = line(command="sheet", values={"kerf_mm": -1.5}, output="peak.pdf")
    assert (wrong["text"], wrong["why"]) == ("", "-1.5 is outside 0..100 mm")
    right = line(command="spawn", values={"robot": "burger", "pose": [-1, 0, -0.5]}, output="worlds")
    assert "--robot=burger --pose=-1,0,-0.5 --output=worlds" in right["text"]


def test_a_command_runs_on_a_map_that_was_written(host: Host, start: Start, doc: str) -> None:
    made = ended(host, start("generate", "worlds"))
    host.opened(doc).document.session.set(name="chunk_size", value=0)  # the document may be anything meanwhile
    (path,) = [file["path"] for file in made["files"] if file["kind"] == "recipe"]
    folder = str(Path(path).parent)
    job = ended(host, runs.run(host, doc=doc, command="metrics", values={}, target=folder))
    assert (job["state"], job["line"]) == ("done", f"rsegen metrics {folder}")
    assert job["lines"][0].startswith("peak_0000")
    with pytest.raises(FileError):
        runs.run(host, doc=doc, command="metrics", values={}, target="..")
    (drawn,) = scenes.made_maps(host, paths=[path])
    assert (drawn["scene"]["name"], drawn["index"]) == ("peak_0000", 0)


def test_a_folder_is_shown_in_a_file_manager_or_is_a_path_to_copy(
    host: Host, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "note").write_text("")
    started: list[list[str]] = []
    monkeypatch.setattr(subprocess, "Popen", lambda words, **_: started.append(words))
    monkeypatch.setattr(runs, "which", lambda name: f"/bin/{name}")
    monkeypatch.setattr(runs, "has_screen", lambda: False)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    place = str((tmp_path / "worlds").resolve())
    assert runs.show_folder(host, path="worlds/note") == {"path": place, "is_open": False}
    assert started == []
    monkeypatch.setattr(runs, "has_screen", lambda: True)
    assert runs.show_folder(host, path="worlds") == {"path": place, "is_open": True}
    assert [words[1:] for words in started] == [[place]]
    with pytest.raises(FileError):
        runs.show_folder(host, path="..")


def test_a_job_runs_until_its_files_are_known(host: Host, start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    states, made = list[str](), jobs._made

    def looked(*places: Any) -> Any:
        states.extend(each["state"] for each in host.jobs.listed())
        return made(*places)

    monkeypatch.setattr(jobs, "_made", looked)
    assert ended(host, start("generate", "worlds"))["files"]
    assert states == ["running"]


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file() and not path.name.startswith(".rsegen")]


def test_what_exists_is_a_question_if_it_may_be_replaced(host: Host, start: Start) -> None:
    assert ended(host, start("preview", "map.png"))["files"] == [
        {"path": "map.png", "name": "map.png", "kind": "picture"}
    ]
    known, told = host.jobs.listed(), list[Any]()
    host.jobs.changed = told.append
    with pytest.raises(Question, match=r"^map\.png: exists already$") as question:
        start("preview", "map.png")
    assert question.value.kind == "exists"
    assert (host.jobs.listed(), told) == (known, [])
    (host.folder / "map.png").write_bytes(b"mine")
    with pytest.raises(Question, match=r"^map\.png: exists already$"):
        start("preview", "map.png")
    assert (host.folder / "map.png").read_bytes() == b"mine"
    assert ended(host, start("preview", "map.png", replace=True))["state"] == "done"
    assert (host.folder / "map.png").read_bytes().startswith(b"\x89PNG")


def test_a_job_that_is_cancelled_leaves_whole_maps_and_nothing_else(host: Host, start: Start, doc: str) -> None:
    session = host.opened(doc).document.session
    session.set(name="maps", value=5000)
    job = start("generate", "worlds", workers=1)
    until(lambda: any(each["done"] for each in host.jobs.listed()))
    runs.cancel(host, job=job["id"])
    found = ended(host, job)
    assert found["state"] == "cancelled"
    assert found["lines"][0].startswith("stopped; ")
    made = [path for path in (host.folder / "worlds").iterdir() if path.name != ".rsegen.jsonl"]
    assert 0 < len(made) < 5000
    for path in made:
        assert read_journal(path), "every map is complete"
    with pytest.raises(UserError, match="job 99 is not known"):
        runs.cancel(host, job=99)


def test_the_end_of_the_server_ends_all_jobs_also_those_that_wait(host: Host, start: Start, doc: str) -> None:
    host.opened(doc).document.session.set(name="maps", value=10**6)
    before = set(psutil.Process().children(recursive=True))
    jobs = [start("dataset", f"data{number}", workers=1) for number in range(6)]
    until(lambda: sum(each["step"] == "" for each in host.jobs.listed()) == 4)
    waiting = [each["step"] for each in host.jobs.listed()]
    assert waiting.count("waiting for other commands") == 2
    host.jobs.close()
    assert not set(psutil.Process().children(recursive=True)) - before
    assert {each["state"] for each in host.jobs.listed()[: len(jobs)]} <= {"cancelled", "running"}


@pytest.mark.parametrize("output", ["../out", "/out", "link/out", ".", "a\0b"])
def test_nothing_is_written_outside_the_folder(output: str, host: Host, start: Start, tmp_path_factory: Any) -> None:
    outside = tmp_path_factory.mktemp("outside")
    (host.folder / "link").symlink_to(outside)
    with pytest.raises((FileError, ParameterError)):
        start("generate", output)
    assert (host.jobs.listed(), list(outside.iterdir())) == ([], [])


def test_an_invalid_document_is_not_run(host: Host, start: Start, doc: str) -> None:
    host.opened(doc).document.session.set(name="chunk_size", value=0)
    with pytest.raises(ParameterError, match="chunk_size: 0"):
        start("generate", "worlds")
    host.opened(doc).document.session.set(name="chunk_size", value=10)
    with pytest.raises(ParameterError, match="output: Enter a name"):
        start("generate")


def test_an_error_is_its_one_line(host: Host, start: Start) -> None:
    job = ended(host, start("metrics", climb_cm=None, drop_cm=5))
    assert (job["state"], len(job["lines"])) == ("failed", 1)
    assert job["lines"][0].startswith("--climb-cm: choose a robot")


def test_modules_in_the_folder_are_not_run(host: Host, start: Start) -> None:
    for name in ("json", "numpy", "rsegen", "sitecustomize"):
        (host.folder / f"{name}.py").write_text("raise SystemExit(99)\n")
    job = ended(host, start("metrics"))
    assert (job["state"], job["lines"][0].split(",")[0]) == ("done", "peak_0000")


def test_a_scan_can_be_opened(host: Host, start: Start) -> None:
    (host.folder / "heights.csv").write_text("10,0,20\n0,10,0\n30,0,10\n")
    job = ended(host, start("import", "worlds", file="heights.csv"))
    assert job["opens"] == "worlds/heights_0000/recipe.json"
    assert json.loads((host.folder / job["opens"]).read_text())["chunk_size"]


def test_many_threads_start_jobs_with_numbers_of_their_own(host: Host, start: Start) -> None:
    jobs: list[dict[str, Any]] = []
    threads = [threading.Thread(target=lambda: jobs.append(start("sim"))) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(job["id"] for job in jobs) == [1, 2, 3]
    assert {ended(host, job)["state"] for job in jobs} == {"done"}
