"""Files that are read: nothing waits for a pipe to which nobody writes, and pipes that have a writer go on working."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from rsegen.errors import FileError
from rsegen.input_files import open_regular, read_start, text_of
from rsegen.recipe.recipe_file import load

RECIPE = b"seed: 7\nobstacles: [{kind: random, levels: 3}]\n"


def test_a_regular_file_is_opened(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(RECIPE)
    with open_regular(path) as file:
        assert file.read() == RECIPE


def test_a_pipe_is_no_regular_file_and_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="not a regular file"):
        open_regular(tmp_path / "pipe")


@pytest.mark.parametrize("path", ["/dev/null", "/dev/zero"])
def test_a_device_is_no_regular_file(path: str) -> None:
    with pytest.raises(OSError, match="not a regular file"):
        open_regular(path)


def test_a_folder_is_no_regular_file(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError):
        open_regular(tmp_path)


def test_a_text_is_not_read_from_a_pipe_to_which_nobody_writes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileError, match="pipe: a pipe to which nobody writes, for 2 seconds"):
        text_of(tmp_path / "pipe", 1, "this")


def test_a_socket_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket")
        with pytest.raises(FileError, match="socket: No such device"):
            text_of(Path("socket"), 1, "this")


def test_no_more_is_read_of_an_endless_device_than_asked_for() -> None:
    assert read_start("/dev/zero", 1000) == bytes(1000)
    with pytest.raises(FileError, match="larger than 1 MiB"):
        text_of(Path("/dev/zero"), 1, "this")


def _writing(path: Path, pieces: list[bytes], pause: Callable[[], object] = lambda: None) -> threading.Thread:
    def write() -> None:
        with path.open("wb", buffering=0) as pipe:
            for piece in pieces:
                pipe.write(piece)
                pause()

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    return thread


def test_a_pipe_is_read_to_the_end_whatever_the_pieces_are(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    pieces = [b"a", b"b" * 100_000, b"c" * 3_000_000]
    writer = _writing(path, pieces)
    assert read_start(path, 10**7) == b"".join(pieces)
    writer.join()


def test_a_writer_may_pause(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writer = _writing(path, [b"a", b"b"], lambda: threading.Event().wait(0.2))
    assert read_start(path, 100) == b"ab"
    writer.join()


def test_a_pipe_that_is_closed_without_a_byte_is_empty(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writer = _writing(path, [])
    assert read_start(path, 100) == b""
    writer.join()


COMMAND = f"{sys.executable} -m rsegen info --json"


@pytest.mark.parametrize(
    "line",
    [
        f"{COMMAND} /dev/stdin < recipe.yaml",
        f"cat recipe.yaml | {COMMAND} /dev/stdin",
        f"(sleep 0.5; cat recipe.yaml) | {COMMAND} /dev/stdin",
        f"{COMMAND} <(cat recipe.yaml)",
        f"{COMMAND} <(sleep 0.5; cat recipe.yaml)",
        f"mkfifo p.yaml; cat recipe.yaml > p.yaml & sleep 0.1; {COMMAND} p.yaml",
    ],
)
def test_a_recipe_through_a_shell_pipe_is_the_same(tmp_path: Path, line: str) -> None:
    (tmp_path / "recipe.yaml").write_bytes(RECIPE)
    shown = subprocess.run(["bash", "-c", line], cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60)
    direct = f"{COMMAND} recipe.yaml"
    usual = subprocess.run(["bash", "-c", direct], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert shown.stdout == usual.stdout
    assert shown.stderr == ""


def test_a_recipe_behind_a_link_is_read(tmp_path: Path) -> None:
    (tmp_path / "recipe.yaml").write_bytes(RECIPE)
    (tmp_path / "link.yaml").symlink_to("recipe.yaml")
    assert load(tmp_path / "link.yaml") == load(tmp_path / "recipe.yaml")
