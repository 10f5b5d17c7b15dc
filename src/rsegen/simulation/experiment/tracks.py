"""What robots did in each trial, on disk: the folder `tracks` of an experiment.

row1-80-free-0.csv   where every robot was in the first trial of the plan's first row, 80 x 80 blocks, pace `free`
row1-80-free.png     the same of the last trial of this cell, on the plan of its map
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rsegen.simulation.driving.drive_metrics import COLUMNS, Trajectory
from rsegen.simulation.driving.trajectory_plot import draw_trajectories
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
from rsegen.simulation.experiment.trial import Trial

FOLDER = "tracks"
"""The folder below that of the results."""


def track_files(plan: ExperimentPlan, cell: Cell, repeat: int, trial: Trial) -> dict[str, list[bytes]]:
    """Return the file of the trajectories of a trial, and a picture of them if it is the last one of its cell."""
    if not trial.trajectories:
        return {}
    files = {_csv_name(cell, repeat): [line.encode() for line in tracks_csv(trial.trajectories)]}
    if repeat == plan.repeats - 1:
        files[_picture_name(cell)] = [draw_trajectories(trial.scene, trial.trajectories)]
    return files


def track_names(plan: ExperimentPlan) -> Iterator[str]:
    """Yield the name of every file that a plan's tracks may have."""
    for cell in plan.cells:
        yield _picture_name(cell)
        yield from (_csv_name(cell, repeat) for repeat in range(plan.repeats))


def tracks_csv(trajectories: Mapping[str, Trajectory]) -> Iterator[str]:
    """Yield the lines of a CSV file: a header, then robot after robot."""
    yield ",".join(["robot", *COLUMNS]) + "\n"
    for name, trajectory in trajectories.items():
        _, *lines = trajectory.csv()
        yield from (f"{name},{line}" for line in lines)


def _csv_name(cell: Cell, repeat: int) -> str:
    return f"{_cell_name(cell)}-{repeat}.csv"


def _picture_name(cell: Cell) -> str:
    return f"{_cell_name(cell)}.png"


def _cell_name(cell: Cell) -> str:
    return f"{FOLDER}/row{cell.row + 1}-{cell.size}-{cell.pace}"
