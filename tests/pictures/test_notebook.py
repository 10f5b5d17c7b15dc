"""Fields and scenes are shown as small plans by a real IPython shell."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytest.importorskip("IPython", reason="IPython is not installed")

_SHOW = """
import base64, json, sys
from IPython.core.interactiveshell import InteractiveShell

shell = InteractiveShell.instance()
shell.run_cell("import rsegen")
loaded = sorted(name for name in sys.modules if name.startswith("rsegen.") or name in ("numpy", "matplotlib"))
shell.run_cell("scene = rsegen.compose(rsegen.Recipe(seed=7, boundary='outer'))")
shown = {}
for expression in ("scene", "scene.field", "scene.recipe"):
    formats, _ = shell.display_formatter.format(shell.ev(expression))
    shown[expression] = base64.b64encode(formats["image/png"]).decode() if "image/png" in formats else None
from rsegen.params.command import Reported

class Result(Reported):
    def report(self):
        yield "crossed"
        yield "in 8 s"

shown["result"] = shell.display_formatter.format(Result())[0]["text/plain"]
from rsegen.pictures.preview import thumbnail

expected = base64.b64encode(thumbnail(shell.user_ns["scene"])).decode()
print(json.dumps({"loaded": loaded, "shown": shown, "expected": expected}))
"""


@pytest.mark.slow
def test_ipython_shows_a_small_plan_of_a_scene_and_of_a_field() -> None:
    run = subprocess.run([sys.executable, "-c", _SHOW], capture_output=True, text=True, timeout=120, check=True)
    report = json.loads(run.stdout.splitlines()[-1])
    assert report["shown"]["scene"] == report["expected"]
    assert report["shown"]["scene.field"]
    assert report["shown"]["scene.recipe"] is None
    assert report["shown"]["result"] == "crossed\nin 8 s"
    assert "numpy" not in report["loaded"], report["loaded"]
