"""What robots did in each trial, on disk: the folder `tracks` of an experiment.

row1-80-free-0.csv   where every robot was in the first trial of the plan's first row, 80 x 80 blocks, pace `free`
row1-80-free.png     the same of the last trial of this cell, on the plan of its map
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from rsegen.io.contents import refuse_loss_of_files
from rsegen.io.record import RECORD, Record, recorded
from rsegen.io.writer import refuse_not_a_folder, write_files
from rsegen.simulation.driving.drive_metrics import COLUMNS, Trajectory
from rsegen.simulation.driving.trajectory_plot import draw_trajectories
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
from rsegen.simulation.experiment.trial import Trial

FOLDER = "tracks"
"""The folder below that of the results."""


def refuse_loss_of_tracks(plan: ExperimentPlan, output: Path) -> None:
    """Raise an OutputError if a file of this plan's tracks would replace one that is not rsegen's."""
    refuse_not_a_folder(output / FOLDER)
    refuse_loss_of_files(output / FOLDER, _names(plan))


def write_tracks(plan: ExperimentPlan, output: Path, cell: Cell, repeat: int, trial: Trial) -> None:
    """Write the trajectories of a trial, and a picture of them if it is the last one of its cell."""
    if not trial.trajectories:
        return
    files = {_csv_name(cell, repeat): [line.encode() for line in tracks_csv(trial.trajectories)]}
    if repeat == plan.repeats - 1:
        files[_picture_name(cell)] = [draw_trajectories(trial.scene, trial.trajectories)]
    folder = output / FOLDER
    write_files(files, folder, record=recorded(folder) or Record(content="files", files={}))


def remove_tracks(output: Path) -> None:
    """Remove the tracks that rsegen has written there; an OutputError if one of them was changed since."""
    folder = output / FOLDER
    record = recorded(folder)
    if record is None:
        return
    refuse_loss_of_files(folder, record.files)
    for name in (*record.files, RECORD):
        (folder / name).unlink(missing_ok=True)
    if not any(folder.iterdir()):
        folder.rmdir()


def tracks_csv(trajectories: Mapping[str, Trajectory]) -> Iterator[str]:
    """The lines of a CSV file: a header, then robot after robot."""
    yield ",".join(["robot", *COLUMNS]) + "\n"
    for name, trajectory in trajectories.items():
        _, *lines = trajectory.csv()
        yield from (f"{name},{line}" for line in lines)


def _names(plan: ExperimentPlan) -> Iterator[str]:
    for cell in plan.cells:
        yield _picture_name(cell)
        yield from (_csv_name(cell, repeat) for repeat in range(plan.repeats))


def _csv_name(cell: Cell, repeat: int) -> str:
    return f"{_cell_name(cell)}-{repeat}.csv"


def _picture_name(cell: Cell) -> str:
    return f"{_cell_name(cell)}.png"


def _cell_name(cell: Cell) -> str:
    return f"row{cell.row + 1}-{cell.size}-{cell.pace}"
