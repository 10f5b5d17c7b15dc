"""What was imported from rsegen 0.1 by the name of its module is still found."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from rsegen.params.moved import NEW_NAMES


@pytest.mark.parametrize("old", NEW_NAMES)
def test_an_old_name_gives_the_module_itself(old: str) -> None:
    new = importlib.import_module(f"rsegen.{NEW_NAMES[old]}")
    with pytest.warns(DeprecationWarning, match=f"rsegen.{old} is now rsegen.{NEW_NAMES[old]}"):
        found = importlib.import_module(f"rsegen.{old}")
    del sys.modules[f"rsegen.{old}"]
    assert found is new
    assert new.__spec__ is not None
    assert new.__spec__.name == new.__name__ == f"rsegen.{NEW_NAMES[old]}"


def test_what_is_registered_once_is_not_registered_again() -> None:
    code = "from rsegen.formats.stl import Stl; import rsegen; assert rsegen.FORMATS['stl'] is Stl"
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True)


def test_functions_stay_functions_whatever_is_imported() -> None:
    code = "import rsegen.scene, rsegen.io, rsegen.recipe; rsegen.build(rsegen.Recipe(seed=1)); rsegen.metrics"
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True)
