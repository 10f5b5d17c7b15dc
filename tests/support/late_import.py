"""A module that takes seconds to import, and that only the tests which use it should wait for.

pytest imports every file of tests before it leaves any out, in each of its processes.
"""

from __future__ import annotations

from typing import Any

import pytest


class LateImport:
    """A module that is imported when a test first asks it for something; the test is skipped if it is not installed."""

    def __init__(self, module: str, *, reason: str) -> None:
        self._module, self._reason = module, reason

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # pytest asks everything in a file whether it is a test
            raise AttributeError(name)
        return getattr(pytest.importorskip(self._module, reason=self._reason), name)
