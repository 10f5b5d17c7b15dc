"""Tests of reliability: the printed table, scipy's binomial, and real drives."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

import rsegen
from rsegen.cli.edge import main
from rsegen.driving.many import ManyDrive, ManyDrives
from rsegen.errors import OutputError, ParameterError
from rsegen.rating.rate import _are_alike
from rsegen.rating.reliability import ReliabilityTest, shown_reliability
from rsegen.simulators.embedded import EMBEDDED


@pytest.mark.parametrize(("repetitions", "failures"), [(10, 0), (20, 1), (30, 3), (60, 8)])
def test_the_printed_table_is_that_of_80_percent_with_a_confidence_of_85(repetitions: int, failures: int) -> None:
    assert rsegen.failures_allowed(0.8, 0.85, repetitions) == failures


@given(st.floats(0.05, 0.99), st.floats(0.05, 0.99), st.integers(1, 2000))
def test_failures_are_allowed_up_to_the_chance_of_a_robot_that_is_no_better(
    reliability: float, confidence: float, repetitions: int
) -> None:
    allowed = rsegen.failures_allowed(reliability, confidence, repetitions)
    chance = 1 - confidence
    if allowed is None:
        assert binom.cdf(0, repetitions, 1 - reliability) > chance - 1e-9
    else:
        assert binom.cdf(allowed, repetitions, 1 - reliability) <= chance + 1e-9
        assert binom.cdf(allowed + 1, repetitions, 1 - reliability) > chance - 1e-9


@pytest.mark.parametrize(("reliability", "confidence"), [("0.3", "0.91"), ("0.8", "0.36"), ("0.5", "0.75")])
def test_a_chance_of_just_what_is_allowed_passes(reliability: str, confidence: str) -> None:
    """In decimals both are equal, but 0.3 ** 2 and 1 - 0.91 are not in binary numbers."""
    assert Fraction(reliability) ** 2 == 1 - Fraction(confidence)
    assert rsegen.failures_allowed(float(reliability), float(confidence), 2) == 0


@given(st.integers(1, 300), st.data(), st.floats(0.5, 0.99))
def test_the_shown_reliability_is_of_clopper_and_pearson(repetitions: int, data: st.DataObject, sure: float) -> None:
    failures = data.draw(st.integers(0, repetitions))
    test = binomtest(repetitions - failures, repetitions, alternative="greater")
    expected = test.proportion_ci(confidence_level=sure, method="exact").low
    assert shown_reliability(failures, repetitions, sure) == pytest.approx(expected, abs=1e-9)


@given(st.integers(1, 100), st.data(), st.floats(0.3, 0.95), st.floats(0.5, 0.99))
def test_passing_is_the_same_as_showing_the_reliability(
    repetitions: int, data: st.DataObject, reliability: float, sure: float
) -> None:
    failures = data.draw(st.integers(0, repetitions))
    allowed, shown = (
        rsegen.failures_allowed(reliability, sure, repetitions),
        shown_reliability(failures, repetitions, sure),
    )
    if abs(shown - reliability) > 1e-6:
        assert (allowed is not None and failures <= allowed) == (shown >= reliability)


def test_what_no_number_of_repetitions_shows_and_what_needs_none() -> None:
    assert rsegen.failures_allowed(1, 0.85, 1000) is rsegen.failures_allowed(0.5, 1, 1000) is None
    assert rsegen.failures_allowed(0, 0.85, 7) == 6
    assert rsegen.failures_allowed(0.9, 0, 7) == 7


def _drives(count: int, *failures: str) -> ManyDrives:
    """Drives that all crossed, and then drives that have no result."""
    drive = ManyDrive(
        map=0, seed=0, crossed=1.0, seconds=2.0, distance=1.0, stuck=0.0, tipped=0, tilt=0.1, climbed=0.0, x=1.0, y=0.0
    )
    failed = [replace(drive, crossed=None, failed=why) for why in failures]
    recipe = rsegen.Recipe(seed=1, obstacles=[rsegen.Random(levels=3)])
    return ManyDrives(
        recipe=recipe, robot="jackal", simulator="MuJoCo", route="straight", drives=(*[drive] * count, *failed)
    )


def test_impossible_values_are_refused() -> None:
    with pytest.raises(ParameterError, match="reliability: 2 is outside"):
        rsegen.failures_allowed(2, 0.85, 10)
    with pytest.raises(ParameterError, match="repetitions: 0 is"):
        rsegen.failures_allowed(0.8, 0.85, 0)


@pytest.mark.slow
@pytest.mark.skipif(not EMBEDDED, reason="the capability mujoco is not here")
def test_a_robot_is_tested_by_as_many_drives(tmp_path: Path) -> None:
    fields = rsegen.Recipe(name="rubble", seed=3, boundary="none", unit_cm=1, obstacles=[rsegen.Random(levels=3)])
    result = rsegen.rate(
        "jackal", fields, reliability=0.5, confidence=0.8, repetitions=4, duration=6, output=tmp_path / "out"
    )
    assert isinstance(result, ReliabilityTest)
    assert [drive.map for drive in result.drives.drives] == [0, 1, 2, 3]
    assert all(drive.distance > 1.0 for drive in result.drives.drives)
    assert (result.failures, result.allowed, result.has_passed) == (0, 0, True)
    assert "jackal failed in 0 of 4 repetitions: passed" in "\n".join(result.report())
    content = json.loads((tmp_path / "out" / "test.json").read_text())
    assert (content["passed"], content["allowed"], len(content["rows"])) == (True, 0, 4)
    with pytest.raises(OutputError, match="exists already"):
        rsegen.rate("jackal", fields, reliability=0.5, output=tmp_path / "out")
    high = rsegen.rate("jackal", fields, seed=4, reliability=0.9, repetitions=2, duration=0.5)
    assert isinstance(high, ReliabilityTest)
    assert (high.failures, high.allowed, high.has_passed) == (2, None, False)
    assert "2 repetitions are too few to show a reliability of 90%" in "\n".join(high.report())


def test_repetitions_that_would_be_the_same_drive_are_refused() -> None:
    fields = rsegen.Recipe(seed=3, obstacles=[rsegen.Peak(levels=5, first=(2, 2), last=(7, 7))])
    with pytest.raises(ParameterError, match="recipe: has nothing random, so all repetitions would be the same"):
        rsegen.rate("jackal", fields, reliability=0.8)


def test_a_recipe_with_two_fields_is_random_also_if_the_first_ones_are_alike() -> None:
    fields = rsegen.Recipe(chunk_size=1, boundary="none", obstacles=[rsegen.Random(levels=2)])
    recipes = (replace(fields, seed=seed) for seed in range(99))
    alike = next(recipe for recipe in recipes if len({rsegen.build(recipe, i).levels.item() for i in range(4)}) == 1)
    assert not _are_alike(alike)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"confidence": 0.9}, "confidence: is for a test of reliability"),
        ({"repetitions": 10}, "repetitions: is for a test of reliability"),
        ({"reliability": 0.8, "trials": 10}, "trials: is for a rating"),
        ({"reliability": 0.8, "by": "prediction"}, "by: is for a rating"),
        ({"reliability": 0.8, "axis": "slope"}, "axis: is for a rating"),
        ({"reliability": 0.8, "precision": 5}, "precision: is for a rating"),
        ({"reliability": 1.5}, r"reliability: 1\.5"),
    ],
)
def test_values_that_do_not_go_together_are_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        rsegen.rate("jackal", **values)  # type: ignore[arg-type]  # by name


@pytest.mark.parametrize(
    ("reliability", "confidence", "claim"),
    [(0.8, 0.85, "80% with a confidence of 85%"), (0.9995, 0.995, "99.95% with a confidence of 99.5%")],
)
def test_no_share_is_rounded_to_one_that_was_not_asked_for(reliability: float, confidence: float, claim: str) -> None:
    result = ReliabilityTest(drives=_drives(30), reliability=reliability, confidence=confidence)
    assert f"a reliability of {claim}" in "\n".join(result.report())


def test_no_more_is_shown_than_the_lower_end_of_the_interval() -> None:
    result = ReliabilityTest(drives=_drives(20_000), reliability=0.5, confidence=0.85)
    assert 0.9999 < result.shown < 0.99991
    assert "; 99.99% is shown" in "\n".join(result.report())


def test_repetitions_without_a_result_are_said_and_not_counted() -> None:
    result = ReliabilityTest(drives=_drives(10, "the physics failed", "again"), reliability=0.8, confidence=0.85)
    assert (result.repetitions, result.failures, result.allowed) == (10, 0, 0)
    said = list(result.report())
    assert said[1:] == [
        "  jackal failed in 0 of 10 repetitions: passed",
        "  a reliability of 80% with a confidence of 85% allows 0 failures; 82.71% is shown",
        "  2 more have no result, and are not counted; the first: the physics failed",
    ]


@pytest.mark.parametrize(("crossed", "code"), [(30, 0), (1, 1)])
def test_a_test_that_is_not_passed_ends_with_exit_code_1(
    crossed: int, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    result = ReliabilityTest(drives=_drives(crossed), reliability=0.8, confidence=0.85)
    monkeypatch.setattr("rsegen.rating.rate.reliability_shown", lambda *_, **__: result)
    assert main(["rate", "jackal", "--reliability", "0.8"]) == code
    assert ("not passed" in capsys.readouterr().out) is bool(code)
