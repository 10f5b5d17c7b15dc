"""Report of the trials: a ranked table in Markdown, everything in JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.contact.constructions import Construction
from benchmarks.contact.trial import Drive, Rest, Trial
from rsegen.simulators.base import Installation

_SOFT = {"soft: plain": ("soft", "plain"), "soft: lane": ("soft", "lane"), "soft: scattered": ("soft", "scattered")}
COLUMNS: Mapping[str, Mapping[str, tuple[str, str | None]]] = {
    "classic": {
        **_SOFT,
        "light wheels": ("light", None),
        "stiff wheels": ("stiff", None),
        "sphere wheels": ("sphere", None),
    },
    "sim": {**_SOFT, "sphere wheels": ("sphere", None), "ball as caster": ("ball", None)},
}
"""Title, robot and ground of a column of drives, for each simulator; None: every ground."""

_INTRODUCTIONS = {
    "classic": """\
# Constructions of a step field, by what robots meet on them

Made by `make bench-contact` in {simulator}; ranked by how far soft wheels stray on average. Drives of 2.2 m over
blocks of equal height, at up to five headings: sideways error at the end in mm, mean (max) / standard deviation of the
roll in mrad. Drops: how many of the bodies do not rest where they should (more than 1 mm too high or low, moved by more
than 1 cm, or still moving by 0.2 mm), and the largest error in height, mm. Cost: CPU s of the server for a simulated
second with all robots driving. Load: CPU s. Memory: MiB when loaded. The server itself and the robots are in all three:
compare with the plane. They are single runs: take differences under 30 % for noise. Distances aside are exact poses,
heights over time and rolls come from Gazebo's record, which has three digits. What a robot of a manufacturer makes of
them, and of other settings of ODE, is in [straight drives](straight.md#what-settings-of-gazebo-classic-change).
""",
    "sim": """\
# The same in Gazebo Sim

Made by `python -m benchmarks.contact --simulator sim --only` and the names below, in {simulator}, with its own physics
engine (DART), which reads neither `kd` nor a wheel's softness: "soft wheels" are stiff there. The same course and
bodies as above, with one sort of robot in a world, driven by motors as strong as need be; the cost is that of the soft
wheels' world. Poses are read twenty times a second, which is part of it. The robots' balls are capsules, as rsegen
writes them for Gazebo Sim ([why](agreement.md#balls-in-gazebo-sim)), but for "ball as caster": soft wheels with a
caster that was left a ball, as that of a robot which somebody else puts into the world. These and the spheres drive at
20, 45 and 70 degrees alone, among other blocks.
""",
}

_REST = ("drops failed, mm", "fields", "cost", "load", "memory")
"""Titles of the columns after those of drives."""


def write(
    trials: Sequence[Trial], tried: Sequence[Construction], lost: Sequence[str], gazebo: Installation, folder: Path
) -> None:
    """contact.md and contact.json, or contact-sim.md and contact-sim.json."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = "contact" if gazebo.simulator.name == "classic" else f"contact-{gazebo.simulator.name}"
    content = {"simulator": str(gazebo), "trials": [_rounded(asdict(trial)) for trial in trials], "lost": list(lost)}
    (folder / f"{stem}.json").write_text(json.dumps(content) + "\n")
    (folder / f"{stem}.md").write_text(table(trials, tried, lost, gazebo))


def _rounded(value: object) -> object:
    """Numbers to a thousandth, however deep."""
    if isinstance(value, float):
        return round(value, 3)
    if isinstance(value, dict):
        return {key: _rounded(inner) for key, inner in value.items()}
    return [_rounded(inner) for inner in value] if isinstance(value, list) else value


def table(trials: Sequence[Trial], tried: Sequence[Construction], lost: Sequence[str], gazebo: Installation) -> str:
    """The whole page."""
    groups = {each.name: [trial for trial in trials if trial.construction == each.name] for each in tried}
    ranked = sorted((name for name in groups if groups[name]), key=lambda name: strayed(groups[name]))
    columns = COLUMNS[gazebo.simulator.name]
    head = ("construction", *columns, *_REST)
    rows = [head, ("---",) * len(head), *(_row(name, groups[name], [*columns.values()]) for name in ranked)]
    introduction = _INTRODUCTIONS[gazebo.simulator.name].format(simulator=gazebo)
    lines = [introduction, *("| " + " | ".join(row) + " |" for row in rows), ""]
    lines += [f"- `{each.name}`: {each.says}" for each in tried if groups[each.name]]
    lines += ["", f"Fields (seeds): {', '.join(map(str, sorted({trial.seed for trial in trials})))}.", *lost]
    return "\n".join(lines) + "\n"


def strayed(trials: Sequence[Trial]) -> float:
    """Mean sideways error of the soft wheels, mm."""
    return float(np.mean([abs(drive.aside) for trial in trials for drive in trial.drives if drive.robot == "soft"]))


def _row(name: str, trials: Sequence[Trial], columns: Sequence[tuple[str, str | None]]) -> tuple[str, ...]:
    drives = [drive for trial in trials for drive in trial.drives]
    rests = [rest for trial in trials for rest in trial.rests]
    driven = [
        _driven([drive for drive in drives if drive.robot == robot and ground in (None, drive.ground)])
        for robot, ground in columns
    ]
    costs = (np.mean([getattr(trial, what) for trial in trials]) for what in ("cost", "load_cpu", "memory"))
    cost, load, memory = map(float, costs)
    return name, *driven, _rested(rests), str(len(trials)), f"{cost:.2f}", f"{load:.1f}", f"{memory:.0f}"


def _driven(drives: Sequence[Drive]) -> str:
    if not drives:
        return "-"
    aside = [abs(drive.aside) for drive in drives]
    stuck = sum(drive.ahead < 2 for drive in drives)
    said = f"{np.mean(aside):.2f} ({max(aside):.2f}) / {np.mean([drive.roll for drive in drives]):.2f}"
    return f"{said}, {stuck} stuck" if stuck else said


def _rested(rests: Sequence[Rest]) -> str:
    if not rests:
        return "-"
    failed = sum(rest.failed for rest in rests)
    return f"{failed} of {len(rests)}, {max(abs(rest.above) for rest in rests):.2f}"
