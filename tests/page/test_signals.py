"""`rsegen gui` ends by signals while a call runs that takes minutes, and that no page can stop."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

from tests.page.client import Client

_LARGE = ["--chunk-size", "1000", "--obstacle", "random levels=2", "--seed", "1"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM that a program hears of")
@pytest.mark.parametrize(
    ("name", "signals", "code", "seconds"),
    [
        ("reach", (signal.SIGINT, signal.SIGINT, signal.SIGTERM), 130, 10),
        ("measure", (signal.SIGTERM,), 143, 30),
    ],
    ids=["two Ctrl-C and a polite kill", "a polite kill"],
)
def test_signals_end_the_page_while_a_call_runs(
    tmp_path: Path, name: str, signals: Sequence[int], code: int, seconds: float
) -> None:
    command = [sys.executable, "-m", "rsegen", "gui", *_LARGE, "--no-browser", "--keep", "--json", "--port", "0"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        try:
            assert program.stdout
            assert program.stderr
            parts = urlsplit(json.loads(program.stdout.readline())["url"])
            given = parse_qs(parts.query)
            assert parts.port
            client, answered = Client(parts.port, given["token"][0]), threading.Event()

            def ask() -> None:
                with suppress(OSError, ValueError):
                    client.post(f"/api/{name}", {"doc": given["doc"][0], "index": 0, "robot": "burger"})
                answered.set()

            threading.Thread(target=ask, daemon=True).start()
            time.sleep(3)
            assert not answered.is_set(), "the call must take long"
            began = time.monotonic()
            for number in signals:
                with suppress(ProcessLookupError):
                    program.send_signal(number)
                with suppress(subprocess.TimeoutExpired):
                    program.wait(1.5)
            assert program.wait(60) == code
            assert time.monotonic() - began < seconds
            assert program.stderr.read().count("\n") == 1
        finally:
            program.kill()
