"""Settings of all tests: markers by folder, a limit of CPU time, hypothesis, signals, where temporary files are.

Hypothesis runs without deadlines, as machines are noisy, and in CI with the same 25 examples per test every time.

A shell that runs the tests in the background has them ignore Ctrl-C, nohup has them ignore that their terminal is gone,
and all that they start would do so too; so both are set back.

Warp compiles its kernels anew on a fresh machine, in a third of the time where it does not optimize them.

What rsegen writes it syncs, some 25,000 times in all tests, and each time waits milliseconds for a disk. So temporary
files are in memory, if there is enough of it for them.
"""

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from itertools import compress
from pathlib import Path
from zlib import crc32

import pytest
from hypothesis import settings

from tests.support.complaints import Refused, exit_code, snapshot, the_line
from tests.support.patience import limit_cpu_of_tests

TESTS = Path(__file__).parent
MARKED_FOLDERS = {"real": pytest.mark.real}
"""Folder -> the marker of every test in it."""

settings.register_profile("house", deadline=None, derandomize=os.environ.get("CI") == "true", max_examples=25)
settings.load_profile("house")

for _name, _usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    if hasattr(signal, _name) and signal.getsignal(getattr(signal, _name)) == signal.SIG_IGN:
        signal.signal(getattr(signal, _name), _usual)

MEMORY = "/dev/shm"  # noqa: S108  # a file system in memory, of Linux
ROOM = 2e9
"""Bytes that have to be free there, more than twice what all tests need at once."""


def _takes_files(folder: str) -> bool:
    """Return whether a folder has room for the files of tests, and its programs may be run; not in most containers."""
    if not os.path.isdir(folder):
        return False
    found = os.statvfs(folder)
    return found.f_bavail * found.f_frsize > ROOM and not found.f_flag & os.ST_NOEXEC


if find_spec("warp"):
    import warp

    warp.config.optimization_level, warp.config.enable_backward = 0, False

if "TMPDIR" not in os.environ and _takes_files(MEMORY):
    os.environ["TMPDIR"] = tempfile.tempdir = MEMORY


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--long-share", type=int, metavar="N", help="of long tests run one in N: those that a commit draws"
    )


def pytest_report_header(config: pytest.Config) -> list[str]:
    share = config.getoption("long_share")
    return [f"long tests: part {_drawn_part(share)} of {share}, drawn by the commit"] if share else []


@cache
def _drawn_part(share: int) -> int:
    """Return which of so many parts of the long tests a commit has: each has another one."""
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=TESTS, check=True, capture_output=True, text=True).stdout
    return int(head, 16) % share


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if share := config.getoption("long_share"):
        is_left = [
            bool(item.get_closest_marker("long")) and crc32(item.nodeid.encode()) % share != _drawn_part(share)
            for item in items
        ]
        config.hook.pytest_deselected(items=list(compress(items, is_left)))
        items[:] = [item for item, left in zip(items, is_left, strict=True) if not left]
    for item in items:
        for folder, marker in MARKED_FOLDERS.items():
            if (TESTS / folder) in item.path.parents:
                item.add_marker(marker)
        for marked in item.iter_markers("long"):
            if not marked.kwargs.get("reason"):
                raise pytest.UsageError(f"{item.nodeid}: say why, as in long(reason=...)")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """A test that never ends fails, however busy the machine is."""
    with limit_cpu_of_tests():
        return (yield)


@pytest.fixture(autouse=True)
def state_folder(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the test's own for drafts and open simulations, so that it finds none of another one or of a user."""
    folder = tmp_path_factory.mktemp("state")
    monkeypatch.setenv("XDG_STATE_HOME", str(folder))
    return folder / "rsegen"


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Refused:
    """Inside `tmp_path`: exit code 2, quickly; one line on stderr and none on stdout; and everything is as it was."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str | Path) -> str:
        capsys.readouterr()
        before, start = snapshot(tmp_path), time.process_time()
        assert exit_code(*arguments) == 2
        assert time.process_time() - start < 10
        assert snapshot(tmp_path) == before
        out, err = capsys.readouterr()
        assert out == ""
        return the_line(err)

    return run
