"""`rsegen gui` where there can be no window."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


def started(tmp_path: Path, *arguments: str, **environment: str) -> tuple[int, str]:
    command = [sys.executable, "-m", "rsegen", "gui", *arguments]
    run = subprocess.run(
        command, env={"HOME": str(tmp_path), **environment}, capture_output=True, text=True, check=False
    )
    return run.returncode, run.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
def test_a_missing_screen_is_reported_in_one_line(tmp_path: Path) -> None:
    pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")
    code, said = started(tmp_path)
    assert code == 2
    assert said == "rsegen: gui: there is no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set)\n"


def test_a_missing_recipe_is_refused_in_one_line(tmp_path: Path) -> None:
    pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")
    code, said = started(tmp_path, "nowhere.yaml", QT_QPA_PLATFORM="offscreen")
    assert (code, said.count("\n")) == (2, 1)
    assert "nowhere.yaml" in said


def test_without_qt_the_package_to_install_is_named(tmp_path: Path) -> None:
    (tmp_path / "PySide6.py").write_text("raise ImportError('no PySide6')\n")
    code, said = started(tmp_path, PYTHONPATH=str(tmp_path), QT_QPA_PLATFORM="offscreen")
    assert code == 2
    assert "pip install 'rsegen[gui]'" in said
