"""The page in a folder in which nothing can be written opens, shows, says so in one line, and loses nothing."""

from __future__ import annotations

import argparse
import json
import os
import pwd
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest

from rsegen.page import commands
from rsegen.page.host import Host
from rsegen.page.service import Service
from rsegen.writing.user_state import home_folder, state_folder
from tests.page.client import TOKEN, Client, Reply
from tests.support.browser import chromium
from tests.support.missing import missing
from tests.support.patience import until

TEXT = "# mine\nseed: 3\nname: course\nobstacles:\n  - {kind: random, levels: 3} # rough\n"
PEAK = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}
_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="permissions bind root, and a mount is one process's, on Linux"),
]


class Place:
    """A folder with a recipe in which the page cannot write, and what starts a command there."""

    def __init__(self, folder: Path, state: Path, *, by: str) -> None:
        self.folder, self.state, self._by = folder, state, by
        folder.mkdir()
        state.mkdir()
        (folder / "course.yaml").write_text(TEXT)
        if by == "permission":
            folder.chmod(0o555)

    def start(self, *words: str, holds: Sequence[str] = ()) -> list[str]:
        """The command that runs words in the folder; holds: further folders that are read-only too."""
        if self._by == "permission":
            for place in map(Path, holds):
                place.chmod(0o555)
            # Permissions bind root only without its capabilities.
            return ["setpriv", "--bounding-set=-all", "--inh-caps=-all", *words] if _ROOT else [*words]
        mounts = [f"mount --bind '{place}' '{place}'" for place in (self.folder, *holds)]
        mounts += [f"mount -o remount,ro,bind '{place}'" for place in (self.folder, *holds)]
        script = f"{' && '.join(mounts)} && cd '{self.folder}' && exec \"$@\""
        return ["unshare", *([] if _ROOT else ["--map-root-user"]), "--mount", "sh", "-c", script, "sh", *words]


@pytest.fixture(params=["permission", "mount"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Place]:
    made = Place(tmp_path / "maps", tmp_path / "kept", by=request.param)
    program = {"permission": "setpriv" if _ROOT else "true", "mount": "unshare"}[request.param]
    if not shutil.which(program):
        missing(f"no {program}: apt-get install util-linux")
    tried = subprocess.run(made.start("touch", "written"), cwd=made.folder, capture_output=True, text=True, check=False)
    if "touch" not in tried.stderr:
        missing(f"nothing can be made read-only here: {tried.stderr.strip() or 'a file was written'}")
    yield made
    for folder in (made.folder, made.state):
        folder.chmod(0o755)


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page that runs, and its address."""

    program: subprocess.Popen[str]
    url: str

    @property
    def client(self) -> Client:
        parts = urlsplit(self.url)
        assert parts.port
        return Client(parts.port, parse_qs(parts.query)["token"][0])

    def ask(self, name: str, **arguments: Any) -> Reply:
        """The answer to a call about the document."""
        doc = parse_qs(urlsplit(self.url).query)["doc"][0]
        return self.client.post(f"/api/{name}", {"doc": doc, **arguments})

    def state(self) -> Any:
        return self.ask("state").json()


@contextmanager
def page(place: Place, *, holds: Sequence[str] = ()) -> Iterator[Page]:
    """`rsegen gui course.yaml` in the folder; killed at the end, unless it has ended."""
    words = [sys.executable, "-m", "rsegen", "gui", "course.yaml", "--no-browser", "--keep", "--json", "--port", "0"]
    own = os.environ | {"XDG_STATE_HOME": str(place.state)}
    with subprocess.Popen(
        place.start(*words, holds=holds),
        cwd=place.folder,
        env=own,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout
        try:
            yield Page(program=program, url=json.loads(program.stdout.readline())["url"])
        finally:
            program.kill()


def refusal(reply: Reply) -> str:
    """The one line by which a call is refused."""
    assert reply.status == 400, reply.content
    text = reply.failure["text"]
    assert "internal error" not in text
    assert "\n" not in text
    return text


def outcome(shown: Page, **arguments: Any) -> Mapping[str, Any]:
    """The job of a command, when it has ended."""
    number = shown.ask("run", values={}, **arguments).json()["id"]
    ended: list[Mapping[str, Any]] = []

    def has_ended() -> bool:
        ended[:] = [job for job in shown.client.call("jobs") if job["id"] == number and job["state"] != "running"]
        return bool(ended)

    until(has_ended)
    return ended[0]


@pytest.mark.parametrize("keeps_drafts", [True, False], ids=["state kept", "state read-only"])
def test_a_read_only_folder_is_shown_and_nothing_is_lost(place: Place, *, keeps_drafts: bool) -> None:
    holds = [] if keeps_drafts else [str(place.state)]
    with page(place, holds=holds) as shown:
        told = shown.client.call("hello")["read_only"]
        assert told.startswith(f"{place.folder} is read-only, so nothing can be saved; ")
        assert shown.client.get(f"/?{urlsplit(shown.url).query}").status == 200
        assert [entry["path"] for entry in shown.client.call("files")["entries"]] == ["course.yaml"]
        assert shown.ask("edit", actions=[{"do": "add", "entry": PEAK}]).status == 200
        assert shown.ask("scene", index=0).json()["palette"]
        for path in ("", "course.yaml", "other.yaml"):
            assert "nothing was changed" in refusal(shown.ask("save", path=path, replace=True))
        failed = outcome(shown, command="generate", output="worlds")
        measured = outcome(shown, command="metrics")
        assert (failed["state"], len(failed["lines"])) == ("failed", 1)
        assert "cannot be written" in failed["lines"][0]
        assert measured["state"] == "done"
        held = shown.state()
        assert (held["unsaved"], len(held["rows"]), held["path"]) == (True, 2, str(place.folder / "course.yaml"))
        assert bool(held["journal"]) is not keeps_drafts
        if not keeps_drafts:
            assert f"cannot be kept in {place.state}" in held["journal"]
        shown.program.kill()
        assert shown.program.stderr
        assert shown.program.stderr.read().splitlines() == [f"warning: {told}"]
    assert (place.folder / "course.yaml").read_text() == TEXT
    assert [path.name for path in place.folder.iterdir()] == ["course.yaml"]
    with page(place, holds=holds) as again:
        assert len(again.state()["rows"]) == (2 if keeps_drafts else 1)


@pytest.mark.parametrize("place", ["mount"], indirect=True)
def test_without_a_temporary_folder_too_each_refusal_is_one_line(place: Place) -> None:
    """A file that a page sends, and what runs, need one."""
    everywhere = [folder for folder in ("/tmp", "/var/tmp", "/usr/tmp") if Path(folder).is_dir()]  # noqa: S108
    with pytest.MonkeyPatch.context() as patched:
        patched.delenv("TMPDIR", raising=False)
        with page(place, holds=[str(place.state), *everywhere]) as shown:
            assert shown.ask("scene", index=0).json()["palette"]
            sent = shown.client.post("/api/upload?name=a.csv", body=b"1,2\n3,4\n")
            assert refusal(sent).startswith("No usable temporary directory")
            failed = outcome(shown, command="metrics")
            assert (failed["state"], len(failed["lines"])) == ("failed", 1)
            assert failed["lines"][0].startswith("No usable temporary directory")


@pytest.mark.parametrize("place", ["permission"], indirect=True)
def test_what_cannot_be_read_is_listed_and_refused_in_one_line(place: Place) -> None:
    """A `lost+found` stands at the top of many disks."""
    place.folder.chmod(0o755)
    closed, secret, picture = (place.folder / name for name in ("lost+found", "secret.yaml", "picture.png"))
    closed.mkdir()
    for file in (secret, picture, closed / "course.yaml"):
        file.write_text(TEXT)
    for path in (closed, secret, picture):
        path.chmod(0)
    place.folder.chmod(0o555)
    try:
        with page(place) as shown:
            listed = {entry["path"]: entry["kind"] for entry in shown.client.call("files")["entries"]}
            assert listed == {
                "course.yaml": "recipe",
                "lost+found": "folder",
                "picture.png": "other",
                "secret.yaml": "recipe",
            }
            for name, arguments in (
                ("open", {"what": "secret.yaml"}),
                ("open", {"what": "lost+found"}),
                ("open", {"what": "lost+found/course.yaml"}),
                ("files", {"folder": "lost+found"}),
                ("made_maps", {"paths": ["secret.yaml"]}),
                ("playback", {"path": "lost+found"}),
                ("rating", {"path": "lost+found"}),
                ("robot", {"robot": "lost+found/a.sdf"}),
            ):
                assert "Permission denied" in refusal(shown.client.post(f"/api/{name}", arguments)), (name, arguments)
            assert "Permission denied" in refusal(shown.client.post("/api/file", {"path": "picture.png"}))
    finally:
        place.folder.chmod(0o755)
        for path in (closed, secret, picture):
            path.chmod(0o755)


def test_the_page_says_what_cannot_be_saved_in_one_line(place: Place) -> None:
    from selenium.webdriver.common.by import By

    with page(place, holds=[str(place.state)]) as shown, chromium() as chrome:
        chrome.get(shown.url)
        until(lambda: chrome.execute_script("return Boolean(window.rsegen?.state.scene.value)"))
        banner = chrome.find_element(By.CSS_SELECTOR, ".banner p")
        until(lambda: f"{place.folder} is read-only" in banner.text)
        assert "cannot be kept" not in banner.text
        shown.ask("edit", actions=[{"do": "add", "entry": PEAK}])
        until(lambda: f"cannot be kept in {place.state}" in banner.text)
        assert len(chrome.find_elements(By.CSS_SELECTOR, ".banner")) == 1
        chrome.find_element(By.CSS_SELECTOR, ".banner button").click()
        until(lambda: not chrome.find_elements(By.CSS_SELECTOR, ".banner"))


def test_a_browser_that_cannot_be_led_to_the_page_ends_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The address is printed, and a person can open it."""
    monkeypatch.setattr("tempfile.mkstemp", _refused)
    service = Service(host=Host(folder=tmp_path), port=0, keep=True, token=TOKEN)
    monkeypatch.setattr("rsegen.writing.programs.has_screen", lambda: True)
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    service.start()
    try:
        said = argparse.Namespace(json=True, recipe=None, no_browser=False)
        commands._show_address(service, service.url(), said)
        assert capsys.readouterr().err.startswith("warning: no file can be written that leads the browser to the page")
        assert Client(service.listening_port).call("hello")["folder"] == str(tmp_path)
    finally:
        service.close()


def _refused(*_: object, **__: object) -> tuple[int, str]:
    raise PermissionError(13, "Permission denied")


def test_a_user_without_a_home_has_the_page_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A container runs programs by a number that is no user's."""

    def unknown(_: int) -> pwd.struct_passwd:
        raise KeyError("no such user")

    monkeypatch.delenv("HOME")
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setattr("pwd.getpwuid", unknown)
    with pytest.raises(RuntimeError):
        Path.home()
    assert not home_folder().is_dir()
    assert not state_folder().exists()
    (tmp_path / "course.yaml").write_text(TEXT)
    service = Service(host=Host(folder=tmp_path), port=0, keep=True, token=TOKEN)
    service.keep_token()
    service.start()
    try:
        client = Client(service.listening_port, service.token)
        doc = client.call("open", what="course.yaml")["doc"]
        held = client.call("edit", doc=doc, actions=[{"do": "add", "entry": PEAK}])
        assert "cannot be kept" in held["journal"]
        assert not client.call("save", doc=doc)["unsaved"]
    finally:
        service.close()
