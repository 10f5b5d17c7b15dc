"""A rating on a page: the curve of the trials so far, and trials that are driven again as they were."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.input_files import JOURNAL
from rsegen.page import documents as hosting
from rsegen.page.host import Host
from rsegen.rating.page import drive_trial, rating
from rsegen.rating.rating import Rating
from tests.page.test_jobs import ended
from tests.rating.conftest import Rated
from tests.rating.test_rate import crosses, real
from tests.support.journals import edited


@pytest.fixture
def host(tmp_path: Path) -> Iterator[Host]:
    made = Host(folder=tmp_path)
    yield made
    made.jobs.close()


def made(folder: Path, robot: object = crosses, **values: Any) -> Rating:
    found = rsegen.rate(robot, **{"seed": 7, "trials": 24, "output": folder, **values})  # type: ignore[arg-type]  # any
    assert isinstance(found, Rating)
    return found


def test_a_page_draws_the_curve_of_the_rating(host: Host, tmp_path: Path) -> None:
    (curve,) = made(tmp_path / "rate").curves
    shown = rating(host, path="rate")
    assert (shown["robot"], shown["axis"], shown["is_rising"]) == ("crosses", "unit [cm], harder to the right", True)
    (drawn,) = shown["curves"]
    assert drawn["half"] == curve.axis.shown(*curve.half)
    assert [(trial["map"], trial["level"]) for trial in drawn["trials"]] == [(t.map, t.level) for t in curve.trials]
    assert sum(crossed for _, crossed, _ in drawn["points"]) == curve.crossed > 0
    assert sum(count for *_, count in drawn["points"]) == 24
    levels, shares, low, high = np.transpose(drawn["line"])
    assert (np.diff(levels) > 0).all()
    assert (np.diff(shares) < 0).all()
    assert ((low < shares) & (shares < high)).all()
    assert np.interp(0.5, shares[::-1], levels[::-1]) == pytest.approx(curve.half.level, rel=0.05)
    assert all(levels[0] <= tick <= levels[-1] for tick in shown["ticks"])


def test_a_rating_that_is_not_done_is_drawn_as_far_as_it_is(host: Host, tmp_path: Path) -> None:
    made(tmp_path / "rate")
    journal = tmp_path / "rate" / JOURNAL
    begin, *others = journal.read_text().splitlines(keepends=True)
    trials = [line for line in others if '"judge"' in line]
    assert len(trials) == 24
    journal.write_text(begin + "".join(trials[:10]) + trials[10][:20])  # a line that is being written
    assert len(rating(host, path="rate")["curves"][0]["trials"]) == 10
    journal.write_text(begin)
    with pytest.raises(UserError, match="no trial has a result yet"):
        rating(host, path="rate")


def test_what_is_no_rating_is_refused(host: Host, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match="contains no rating"):
        rating(host, path="empty")
    with pytest.raises(FileError, match="outside"):
        rating(host, path="../rate")
    made(tmp_path / "rate")
    journal = tmp_path / "rate" / JOURNAL
    text = journal.read_text()
    edited(journal, '"axis": "unit"', '"axis": "moon"')
    with pytest.raises(FileError, match="not that of a rating"):
        rating(host, path="rate")
    journal.write_text(text)
    doc = hosting.open(host, what="peak")["doc"]
    title = rating(host, path="rate")["curves"][0]["judge"]
    with pytest.raises(ParameterError, match="crosses is no robot that rsegen drives"):
        drive_trial(host, doc=doc, path="rate", judge=title, trial=0)
    for judge, trial in ((title, 24), (title, -1), ("nobody", 0)):
        with pytest.raises(ParameterError, match="is none of the"):
            drive_trial(host, doc=doc, path="rate", judge=judge, trial=trial)


def test_the_robot_of_a_rating_of_anybody_is_no_file_elsewhere(host: Host, tmp_path: Path) -> None:
    made(tmp_path / "rate", "burger", by=("prediction",), trials=8)
    doc = hosting.open(host, what="peak")["doc"]
    title = rating(host, path="rate")["curves"][0]["judge"]
    journal = tmp_path / "rate" / JOURNAL
    edited(journal, '"robot": "burger"', '"robot": "/etc/robot.sdf"')
    with pytest.raises(ParameterError, match="outside"):
        drive_trial(host, doc=doc, path="rate", judge=title, trial=0)


@real
@pytest.mark.slow
def test_trials_are_driven_again_as_they_were_whoever_judged_them(of_jackal: Rated, host: Host, tmp_path: Path) -> None:
    """Also over an earlier drive, as both judges have the same fields."""
    copytree(of_jackal.folder, tmp_path / "rate")
    doc = hosting.open(host, what="peak")["doc"]
    curves = json.loads((tmp_path / "rate" / "rating.json").read_text())["curves"]
    assert {curve["by"] for curve in curves} == {"mujoco", "prediction"}
    (trial,) = [trial for curve in curves for trial in curve["trials"] if trial["crossed"]]
    for curve in curves:
        job = ended(host, drive_trial(host, doc=doc, path="rate", judge=curve["title"], trial=trial["map"]))
        assert job["state"] == "done", job["lines"]
        (drive,) = [file for file in job["files"] if file["kind"] == "drive"]
        assert drive["path"] == f"rate-trials/map_{trial['map']}_unit_{trial['level']:g}"
        told = json.loads((tmp_path / drive["path"] / "drive.json").read_text())
        assert told["robots"][0]["kind"] == "jackal"
        assert told["robots"][0]["crossed"] == trial["seconds"]
