"""Settings of all tests: markers by folder, a limit of CPU time, hypothesis, signals.

Hypothesis runs without deadlines, as machines are noisy, and in CI with the same examples every time: 25 per test, and
100 with `--hypothesis-profile=thorough`, as the long ones have in `make test-all`.

A shell that runs the tests in the background has them ignore Ctrl-C, nohup has them ignore that their terminal is gone,
and all that they start would do so too; so both are set back.
"""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support.patience import limit_cpu_of_tests

TESTS = Path(__file__).parent
MARKED_FOLDERS = {"simulation/real": pytest.mark.real}
"""Folder -> the marker of every test in it."""

settings.register_profile("house", deadline=None, derandomize=os.environ.get("CI") == "true", max_examples=25)
settings.register_profile("thorough", settings.get_profile("house"), max_examples=100)
settings.load_profile("house")

for _name, _usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    if hasattr(signal, _name) and signal.getsignal(getattr(signal, _name)) == signal.SIG_IGN:
        signal.signal(getattr(signal, _name), _usual)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
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
