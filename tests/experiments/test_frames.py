"""Paces that draw frames are refused in one line where nothing can be drawn; the load of the GPU is nvidia-smi's."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import replace
from pathlib import Path

import pytest

from rsegen.errors import NoSimulator, UserError
from rsegen.experiments.plan import ExperimentPlan, TableRow
from rsegen.experiments.trial_server import busy, gpu_load, refuse_without_frames, wait_for_frames
from rsegen.simulators.base import SIMULATORS, Installation


def installation(name: str, *commands: str) -> Installation:
    return Installation(simulator=SIMULATORS[name], version="1", commands={each: Path(each) for each in commands})


CLASSIC = installation("classic", "gzserver", "gz", "gzclient")


def refusal(pace: str, here: Installation) -> str:
    plan = ExperimentPlan(name="p", rows=(TableRow(),), paces=("real", pace))
    try:
        refuse_without_frames(plan, {"any": here})
    except UserError as error:
        return str(error)
    return ""


def test_frames_are_refused_where_they_cannot_be_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":1")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert [refusal(pace, CLASSIC) for pace in ("camera", "window", "free")] == ["", "", ""]
    assert "Gazebo Sim" in refusal("camera", installation("sim", "gz"))
    assert "is not installed" in refusal("window", replace(CLASSIC, commands={"gzserver": Path("gzserver")}))
    monkeypatch.delenv("DISPLAY")
    for pace in ("camera", "window"):
        assert refusal(pace, CLASSIC) == f"paces: {pace} needs a screen, and there is none; run under xvfb-run -a"
    assert refusal("free", CLASSIC) == ""


def test_a_screen_without_opengl_is_one_line() -> None:
    with pytest.raises(NoSimulator, match="the camera drew nothing in 120 s") as refused:
        wait_for_frames(lambda: 0, "camera", lambda _: None)
    assert "\n" not in str(refused.value)
    wait_for_frames(iter((0, 0, 3)).__next__, "camera", lambda _: None)


@pytest.mark.parametrize(
    ("script", "load"),
    [("echo 37", 0.37), ("echo 3; echo 90", 0.9), ("echo '[N/A]'", None), ("echo 50; exit 9", None)],
)
def test_the_load_of_the_gpu_is_that_of_the_busiest(
    script: str, load: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "nvidia-smi").write_text(f"#!/bin/sh\n{script}\n")
    (tmp_path / "nvidia-smi").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    assert gpu_load() == load


def test_the_time_in_which_the_machine_was_busy_only_grows() -> None:
    assert busy() <= busy()


def test_the_machine_is_busy_with_all_that_is_not_idle_and_guests_count_once(monkeypatch: pytest.MonkeyPatch) -> None:
    times = {"user": 8.0, "system": 2.0, "idle": 100.0, "iowait": 5.0, "guest": 3.0, "guest_nice": 1.0}
    found = namedtuple("found", times)(**times)  # as psutil's
    monkeypatch.setattr("psutil.cpu_times", lambda: found)
    monkeypatch.setattr("os.cpu_count", lambda: 4)
    assert busy() == (8 + 2) / 4
