"""The server lets nobody else in, answers whatever comes in one line, and tells pages of each other's changes."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from html import escape
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import rsegen
from rsegen.cli.command_line import parser_of
from rsegen.obstacles import KINDS
from rsegen.page import calls
from rsegen.page.host import Host
from rsegen.page.server import MOST_CALL, MOST_UPLOAD, file_name
from rsegen.page.service import Service
from rsegen.params.capabilities import commands
from tests.page.client import TOKEN, Client


@contextmanager
def serving(folder: Path, address: str = "127.0.0.1") -> Iterator[Service]:
    service = Service(host=Host(folder=folder), address=address, port=0, token=TOKEN, keep=True)
    service.start()
    try:
        yield service
    finally:
        service.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("served")


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[Client]:
    (folder / "course.yaml").write_text("seed: 3\n")
    with serving(folder) as service:
        yield Client(service.listening_port)


def opened(client: Client, what: str = "course.yaml") -> str:
    doc: str = client.call("open", what=what)["doc"]
    return doc


# Who is let in.


def test_the_page_needs_the_token_in_its_address(client: Client) -> None:
    for query in ("", "?token=", "?token=secre", "?token=%ff", "?token=Secret"):
        assert client.get(f"/{query}").status == 403
    page = client.get(f"/?token={TOKEN}")
    assert page.status == 200
    assert b'<div id="page">' in page.content
    assert TOKEN.encode() not in page.content


@pytest.mark.parametrize(
    "given_", ["", "secret", "Bearer", "Bearer secre", "Bearer secret2", "bearer secret", "Bearer \xff"]
)
@pytest.mark.parametrize("path", ["open", "events", "upload", "file", "nothing"])
def test_every_call_needs_the_token_in_its_header(client: Client, path: str, given_: str) -> None:
    answer = client.post(f"/api/{path}?token={TOKEN}", {}, Authorization=given_)
    assert answer.status == 403
    assert "token" in answer.failure["text"]


@pytest.mark.parametrize(
    "name", ["evil.example", "localhost.evil.example", "192.168.1.5", "10.0.0.1:8000", "", "[", "localhost@evil", "a b"]
)
def test_other_names_than_that_of_this_machine_are_not_answered(client: Client, name: str) -> None:
    assert client.get(f"/?token={TOKEN}", Host=name).status == 403


@pytest.mark.parametrize("name", ["localhost", "localhost:99", "127.0.0.1:8000", "[::1]:8000", "127.1.2.3"])
def test_this_machine_is_answered_by_any_of_its_names(client: Client, name: str) -> None:
    assert client.get(f"/?token={TOKEN}", Host=name).status == 200


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost:9999", "http://localhost", "[", "http://["]
)
def test_no_other_page_may_ask(client: Client, origin: str) -> None:
    assert client.post("/api/state", {}, Origin=origin).status == 403
    assert client.post("/api/open", {}, Origin=f"http://localhost:{client.port}").status == 200
    asked = client.request("OPTIONS", "/api/open", b"", {"Origin": origin, "Access-Control-Request-Method": "POST"})
    assert not [name for name in asked.headers if name.startswith("access-control")]


def test_browsers_may_do_nothing_that_is_not_needed(client: Client) -> None:
    for answer in (client.get(f"/?token={TOKEN}"), client.get("/"), client.post("/api/nothing", {})):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'self' http://localhost:*" in policy
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_the_manual_has_every_command_and_kind_and_needs_the_token(client: Client) -> None:
    assert client.get("/manual").status == client.get("/manual?token=wrong").status == 403
    answer = client.get(f"/manual?token={TOKEN}")
    assert answer.status == 200
    text = answer.content.decode()
    for name in commands():
        assert f'<section id="{name}">' in text
        assert escape(parser_of(name).format_help().splitlines()[-1]) in text
    assert all(f"\n{kind}\n" in text for kind in KINDS)
    assert "<script" not in text


# What is sent.

CALL_BODIES = [
    b"",
    b"[]",
    b"5",
    b"null",
    b"{",
    b'{"what": NaN}',
    b'{"what": 1e400}',
    b"[" * 100_000,
    b'{"what": ' * 5000,
    b'{"a":' * 70 + b"1" + b"}" * 70,
    b'{"what": "\\ud800"}',
    b'{"\\udfff": 1}',
    b"\xff\xfe",
    b'{"what": "a\\u0000b"}',
    b'{"what": ' + b"9" * 5000 + b"}",
    b'{"what": 5}',
    b'{"what": true}',
    b'{"why": ""}',
    b'{"what": "/etc/passwd"}',
    b'{"what": "../../etc/passwd"}',
    b'{"what": "' + b"a" * 5000 + b'"}',
    b'{"what": "x#99999999999999999999"}',
]


@pytest.mark.parametrize("body", CALL_BODIES, ids=lambda body: repr(body[:20]))
def test_whatever_is_sent_is_answered_in_one_line(client: Client, body: bytes) -> None:
    answer = client.post("/api/open", body=body)
    assert answer.status in ((200,) if body == b"" else (400,))
    assert body == b"" or len(answer.failure["text"].splitlines()) == 1


def test_unknown_calls_documents_and_arguments_are_named(client: Client) -> None:
    doc = opened(client)
    for path, arguments, words in (
        ("nothing", {}, "unknown call 'nothing'"),
        ("state", {}, "is not open here"),
        ("state", {"doc": "d99"}, "d99"),
        ("state", {"doc": ["d1"]}, "is not a text"),
        ("edit", {"doc": doc}, "is missing"),
        ("edit", {"doc": doc, "actions": {}}, "is not a list"),
        ("edit", {"doc": doc, "actions": [1]}, "is not an object"),
        ("edit", {"doc": doc, "actions": [], "index": "0"}, "is not a whole number"),
        ("state", {"doc": doc, "index": 10**30}, "is outside 0..0"),
        ("edit", {"doc": doc, "actions": [], "indx": 1}, "did you mean 'index'?"),
    ):
        answer = client.post(f"/api/{path}", arguments)
        assert answer.status == 400
        assert words in answer.failure["text"]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("close", {"doc": "a\nb\x1b[2J"}),
        ("state", {"doc": "a\r\nb"}),
        ("shell_line", {"doc": "", "command": "a\nb", "values": {}}),
        ("files", {"folder": "a\n/../../../b"}),
        ("open", {"what": "a\nb"}),
        ("file", {"path": "a\nb"}),
        ("made_maps", {"paths": ["a\u2028b"]}),
    ],
)
def test_names_of_several_lines_are_refused_in_one(client: Client, name: str, arguments: dict[str, object]) -> None:
    reply = client.post(f"/api/{name}", arguments)
    assert reply.status in (400, 404)
    assert reply.failure["text"].isprintable()


def test_too_large_bodies_are_refused(client: Client) -> None:
    answer = client.post("/api/open", body=b" " * (MOST_CALL + 1))
    assert (answer.status, answer.failure["text"]) == (413, "more than 4 MiB at once")
    assert client.post("/api/open", Content_Length="9" * 12).status == 413
    assert client.post("/api/open", Content_Length="9" * 30).status == 400
    endless = client.post("/api/open", body=(b" " * 2**20 for _ in range(5)))
    assert endless.status == 413


def test_an_error_of_ours_is_one_line_too(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(_: Host) -> None:
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setitem(calls.OF_HOST, "breaks", breaks)
    answer = client.post("/api/breaks", {})
    assert answer.status == 500
    assert answer.failure["text"].endswith("ZeroDivisionError: division by zero")


def test_a_question_says_what_it_is_about(client: Client, folder: Path) -> None:
    doc = opened(client, "")
    (folder / "theirs.yaml").write_text("seed: 4\n")
    answer = client.post("/api/save", {"doc": doc, "path": "theirs.yaml"})
    assert (answer.status, answer.failure["kind"]) == (409, "exists")
    assert (folder / "theirs.yaml").read_text() == "seed: 4\n"


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
NAMES = st.sampled_from(["row", "to", "at", "entry", "cells", "cell", "end", "level", "name", "value", "index"])
VALUES = JSON | st.integers(-2, 12) | st.sampled_from(["first", "both", "seed", "chunk_size", [3, 4], [[3, 4]]])
_DOES = [
    *("set", "reroll", "add", "change", "remove", "clear", "move", "enable", "duplicate", "fix", "move_end", "paint"),
    *("undo", "redo"),
]
ACTIONS = st.fixed_dictionaries(
    {"do": st.sampled_from(_DOES)},
    optional={"gesture": st.text(max_size=3), "enabled": st.booleans() | JSON},
).flatmap(lambda action: st.dictionaries(NAMES, VALUES, max_size=4).map(lambda more: {**more, **action}))


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150, deadline=None)
@given(st.lists(ACTIONS, min_size=1, max_size=5))
def test_wild_actions_are_applied_or_refused_and_can_be_undone(client: Client, actions: list[Any]) -> None:
    doc = opened(client, "")
    for action in ({"do": "add", "entry": {"kind": "peak", "levels": 3}}, *actions):
        answer = client.post("/api/edit", {"doc": doc, "actions": [action]})
        assert answer.status in (200, 400), answer.content
        state = client.post("/api/state", {"doc": doc}).json()
        assert state["problem"] or client.post("/api/texts", {"doc": doc}).status == 200
    while state["can_undo"]:
        state = client.post("/api/edit", {"doc": doc, "actions": [{"do": "undo"}]}).json()
    assert (state["rows"], state["unsaved"]) == ([], False)
    client.post("/api/close", {"doc": doc})


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_every_call_answers_wild_arguments(client: Client, data: st.DataObject) -> None:
    known = {**calls.OF_DOCUMENT, **calls.OF_HOST}
    name = data.draw(st.sampled_from(["open", "state", "edit", "save", "reload", "close", "texts", "scene"]))
    names = st.sampled_from(["doc", "page", *(known[name].__kwdefaults__ or {"index": None})])
    given_ = data.draw(st.dictionaries(names, JSON, max_size=4))
    answer = client.post(f"/api/{name}", {**given_, **data.draw(st.sampled_from([{}, {"doc": "d1"}]))})
    assert answer.status in (200, 400, 409), answer.content


# Files.


def test_files_that_are_sent_are_kept_apart_and_only_they_and_the_folder_are_read(client: Client, folder: Path) -> None:
    sent = client.post("/api/upload?name=../../etc/scan.ply", body=b"ply").json()["path"]
    assert Path(sent).name == "scan.ply"
    assert client.post("/api/file", {"path": sent}).content == b"ply"
    (folder / "plan.png").write_bytes(b"\x89PNG")
    answer = client.post("/api/file", {"path": "plan.png"})
    assert (answer.content, answer.headers["content-type"]) == (b"\x89PNG", "image/png")
    (folder / "link").symlink_to("/etc/hostname")
    for path in ("../x", "/etc/hostname", "link", ".", "", ".rsegen.jsonl", "nothing.png", "a\0b"):
        assert client.post("/api/file", {"path": path}).status in (400, 404)


def test_files_that_are_sent_are_bounded_and_gone_at_the_end(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        client = Client(service.listening_port)
        assert client.post("/api/upload?name=a", Content_Length=str(4 * MOST_UPLOAD + 1)).status == 413
        sent = Path(client.post("/api/upload?name=a", body=b"1").json()["path"])
        assert sent.exists()
    assert not sent.exists()


@pytest.mark.parametrize(
    ("given_", "name"),
    [
        ("a.ply", "a.ply"),
        ("", "file"),
        ("..", "file"),
        ("/x/.y", "y"),
        ("C:\\a b.csv", "a_b.csv"),
        ("é" * 300, "_" * 100),
    ],
)
def test_names_of_files_are_made_harmless(given_: str, name: str) -> None:
    assert file_name(given_) == name


# A server that runs.


@pytest.mark.slow
def test_two_pages_hear_of_each_other(tmp_path: Path) -> None:
    (tmp_path / "course.yaml").write_text("seed: 3\n")
    with serving(tmp_path) as service:
        client = Client(service.listening_port)
        doc = opened(client)
        one = client.events(doc, "one")
        assert one.until(event="state")["state"]["pages"] == 1
        other = client.events(doc, "other")
        assert one.until(pages=2)
        client.call("edit", doc=doc, page="other", actions=[{"do": "set", "name": "unit_cm", "value": 5}])
        assert one.until(event="state", page="other")["state"]["values"]["unit_cm"] == 5
        (tmp_path / "course.yaml").write_text("seed: 4\n")
        assert one.until(event="file")["changed_on_disk"] is True
        other.close()
        assert one.until(pages=1)
        service.close()
        assert b"Traceback" not in one.rest()
        one.close()


@pytest.mark.slow
def test_a_slow_call_delays_no_event_and_no_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    goes_on = Event()

    def slow(_: object) -> bool:
        return goes_on.wait(20)

    monkeypatch.setitem(calls.OF_DOCUMENT, "slow", slow)
    monkeypatch.setattr(calls, "AT_ONCE", {"slow"})
    with serving(tmp_path) as service, ThreadPoolExecutor() as pool:
        client = Client(service.listening_port)
        doc = opened(client, "")
        stream = client.events(doc, "one")
        answer = pool.submit(client.call, "slow", doc=doc)
        client.call("edit", doc=doc, page="two", actions=[{"do": "reroll"}])
        stream.until(page="two")
        assert not answer.done()
        goes_on.set()
        assert answer.result() is True
        stream.close()


def test_a_search_ends_whose_asker_has_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, ended = Event(), Event()

    def search(host: Host, *, doc: str) -> None:
        with host.opened(doc).newest_turn("reach") as watch:
            begun.set()
            try:
                while True:
                    watch()
            finally:
                ended.set()

    monkeypatch.setitem(calls.OF_HOST, "search", search)
    with serving(tmp_path) as service:
        client = Client(service.listening_port)
        doc = opened(client, "")
        stream = client.events(doc, "one")  # the page stays, and others may
        impatient = Client(service.listening_port, seconds=0.2)
        with pytest.raises(TimeoutError):
            impatient.call("search", doc=doc, page="one")
        assert begun.is_set()
        assert ended.wait(20)
        stream.close()


@contextmanager
def command(folder: Path, *arguments: str, **variables: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`rsegen gui` with arguments and environment variables, and the address that it prints."""
    words = [sys.executable, "-m", "rsegen", "gui", "--port", "0", *arguments]
    kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment = {**kept, **variables}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(words, cwd=folder, env=environment, **pipes) as run:
        assert run.stdout
        yield run, run.stdout.readline().strip()
        if run.poll() is None:
            run.kill()


@pytest.mark.slow
def test_the_token_is_in_no_command_line(tmp_path: Path) -> None:
    """A browser is started with a file that leads to the page, which no other user can read, and which goes then."""
    place, seen = tmp_path / "maps", tmp_path / "seen"
    place.mkdir()
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {seen}.new && mv {seen}.new {seen}\n')
    browser.chmod(0o700)
    with command(place, DISPLAY=":4711", BROWSER=f"{browser} %s") as (_, url):
        for _ in range(100):
            if seen.exists():
                break
            time.sleep(0.1)
        door = Path(seen.read_text().strip().removeprefix("file://"))
        token = re.findall(r"token=([\w-]+)", url)[0]
        assert token not in seen.read_text()
        assert f'url={url.replace("&", "&amp;")}"' in door.read_text()
        assert door.stat().st_mode & 0o077 == 0
        assert Client(int(re.findall(r":(\d+)/", url)[0]), token).get(f"/?token={token}").status == 200
        assert not list(place.iterdir())


def test_a_file_that_leads_to_the_page_goes_with_its_server(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        door = service.write_door(service.url())
        assert door.parent == tmp_path
    assert not door.exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_command_in_a_line(tmp_path: Path, number: signal.Signals) -> None:
    with command(tmp_path, "--no-browser", "--seed", "5") as (run, url):
        match = re.fullmatch(r"http://localhost:(\d+)/\?token=([\w-]{32})&doc=(d1-\w+)", url)
        assert match, url
        client, doc = Client(int(match[1]), match[2]), match[3]
        assert client.call("state", doc=doc)["values"]["seed"] == 5
        stream = client.events(doc, "one")
        stream.until(event="state")
        run.send_signal(number)
        assert run.wait(10) == 128 + number
        assert run.stderr
        assert run.stderr.read() == "rsegen: stopped\n"
        stream.close()


@pytest.mark.slow
def test_the_command_ends_some_seconds_after_its_last_page(tmp_path: Path) -> None:
    with command(tmp_path) as (run, url):
        port, token, doc = re.findall(r":(\d+)/\?token=([\w-]+)&doc=([\w-]+)", url)[0]
        for _ in range(2):  # a reload
            stream = Client(int(port), token).events(doc, "one")
            stream.until(event="state")
            stream.close()
            time.sleep(2)
        assert run.poll() is None
        assert run.wait(12) == 0


def test_a_server_for_others_is_asked_by_addresses_and_its_own_name_only(tmp_path: Path) -> None:
    with serving(tmp_path, "0.0.0.0") as service:  # noqa: S104  # for this test
        client = Client(service.listening_port)
        assert service.url("d1").startswith(f"http://{socket.gethostname()}:")
        for name in ("192.168.1.5", "[fe80::1]:80", "localhost", socket.gethostname().lower()):
            assert client.get(f"/?token={TOKEN}", Host=name).status == 200
        assert client.get(f"/?token={TOKEN}", Host="evil.example").status == 403


def test_servers_of_a_folder_on_this_machine_have_one_token_and_others_have_none_that_stays(
    tmp_path: Path, state_folder: Path
) -> None:
    tokens = {}
    (tmp_path / "other").mkdir()
    for number, (folder, address) in enumerate(
        [(".", "127.0.0.1"), (".", "127.0.0.1"), ("other", "127.0.0.1"), (".", "0.0.0.0")]  # noqa: S104  # for this test
    ):
        service = Service(host=Host(folder=tmp_path / folder), address=address, port=0)
        service.keep_token()
        tokens[number] = service.token
        service._socket.close()
        service.host.close()
    assert tokens[0] == tokens[1]
    assert len({*tokens.values()}) == 3
    files = [*state_folder.glob("*.token")]
    assert {file.read_text("ascii") for file in files} == {tokens[0], tokens[2]}
    if sys.platform != "win32":
        assert {file.stat().st_mode & 0o777 for file in files} == {0o600}
    next(file for file in files if file.read_text("ascii") == tokens[0]).write_text("not a token")
    service = Service(host=Host(folder=tmp_path), port=0)
    service.keep_token()
    assert re.fullmatch(r"[\w-]{32}", service.token)
    assert service.token not in tokens.values()
    service._socket.close()


def test_a_port_that_is_taken_is_a_line(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(rsegen.UserError, match=f"port: cannot listen on port {port} of 127.0.0.1"):
            Service(host=Host(folder=tmp_path), port=port)
    with pytest.raises(rsegen.UserError, match="is no address of this machine"):
        Service(host=Host(folder=tmp_path), address="no.such.host.invalid")
