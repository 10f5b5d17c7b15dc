"""Predictions of crossings are counted with their rivals, and none that is wrong is left out."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from benchmarks.crossings import Drive, best_limit, highest_step, table
from tests.standing.stands import field_of


def drive(*, foreseen: bool, crosses: bool, step: float = 0.01, **other: Any) -> Drive:
    given: dict[str, Any] = {
        "simulator": "classic",
        "robot": "burger",
        "field": "random, 4 levels",
        "unit_cm": 0.5,
        "seed": 1,
        "line": 0.0,
        "reason": "goes on" if foreseen else "tips over",
        "at": None if foreseen else 0.1,
        "seconds": 8.0 if crosses else None,
        "end_x": 0.7 if crosses else 0.1,
        "turned": 2.0,
        "tipped": 0,
        "incidents": (),
    }
    return Drive(**{**given, **other}, foreseen=foreseen, step=step)


DRIVES = [
    drive(foreseen=True, crosses=True, step=0.005),
    drive(foreseen=True, crosses=True, step=0.005),
    drive(foreseen=True, crosses=False, step=0.02, turned=-40.0),
    drive(foreseen=False, crosses=True, step=0.01),
    drive(foreseen=False, crosses=False, step=0.02, tipped=1),
]


def test_the_table_has_precision_recall_rivals_and_every_wrong_prediction() -> None:
    lines = list(table({"drives": [asdict(each) for each in DRIVES]}))
    assert lines[2] == "| burger | 5 | 3 | 60 % | 60 % | 100 % (1 cm) | 67 % | 67 % |"
    assert "| burger, 0.5 cm | 5 | 3 | 2 | 2 | 1 |" in lines
    assert lines[-2:] == [
        "| burger, 0.5 cm, 1, y = 0.00 m | crosses | ends at x = 0.10 m, turned by 40 degrees |",
        "| burger, 0.5 cm, 1, y = 0.00 m | tips over at x = 0.10 m | "
        "crosses after 8.0 s, turned by 2 degrees at the end |",
    ]


def test_the_best_limit_is_chosen_by_the_outcome() -> None:
    assert best_limit(DRIVES) == (0.01, 5)
    assert best_limit([drive(foreseen=True, crosses=False)]) == (-1.0, 1)


@pytest.mark.parametrize(("line", "width", "step"), [(0.0, 0.15, 0.03), (0.2, 0.05, 0.01), (-0.2, 0.05, 0.02)])
def test_the_highest_step_is_that_below_the_robot_with_the_ground_before_and_after(
    line: float, width: float, step: float
) -> None:
    levels = np.zeros((4, 5), int)
    levels[1:, 4], levels[3, 0], levels[1, 2] = 1, 2, 3
    assert highest_step(field_of(levels), line, width) == pytest.approx(step)


def test_a_drive_says_what_happened() -> None:
    assert DRIVES[0].happened == "crosses after 8.0 s, turned by 2 degrees at the end"
    assert DRIVES[2].happened == "ends at x = 0.10 m, turned by 40 degrees"
    assert DRIVES[4].happened == "tips over, ends at x = 0.10 m"
