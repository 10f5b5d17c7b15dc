"""Plans with trajectories: no text runs over another one, and the whole way of a robot is in the picture."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import rsegen
from rsegen.driving import plots
from rsegen.driving.drive_metrics import Trajectory
from rsegen.pictures.preview import figure_bytes
from rsegen.scene.scene import Scene


def drawn(recipe: rsegen.Recipe, lines: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch) -> Figure:
    """The figure of these trajectories, as it was when its bytes were written."""
    figures: list[Figure] = []

    def kept(figure: Figure, scene: Scene, format: str) -> bytes:  # noqa: A002  # its name there
        figures.append(figure)
        return figure_bytes(figure, scene, format)

    monkeypatch.setattr(plots, "figure_bytes", kept)
    rows = {name: np.hstack([np.zeros((len(line), 1)), line, np.zeros((len(line), 4))]) for name, line in lines.items()}
    plots.trajectory_plot(rsegen.compose(recipe), {name: Trajectory(rows=each) for name, each in rows.items()})
    FigureCanvasAgg(figures[0]).draw()  # type: ignore[no-untyped-call]  # matplotlib's
    return figures[0]


@pytest.mark.parametrize("levels", [2, 3, 5])
@pytest.mark.parametrize("robots", [1, 2, 3, 8])
@pytest.mark.parametrize("kind", ["robot", "turtlebot3_burger", "a_robot_with_the_name_of_its_laboratory"])
def test_no_text_runs_over_another_one(kind: str, robots: int, levels: int, monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = rsegen.Recipe(seed=1, boundary="none", obstacles=(rsegen.Random(levels=levels),))
    figure = drawn(recipe, {f"{kind}_{n}": np.array([[-0.7, 0.0], [0.7, 0.1]]) for n in range(robots)}, monkeypatch)
    texts = [*figure.legends[0].get_texts(), *figure.texts, figure.axes[0].xaxis.label, figure.axes[0].yaxis.label]
    boxes = [text.get_window_extent() for text in texts]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    page = figure.bbox
    assert all(page.x0 <= box.x0 and page.y0 <= box.y0 and box.x1 <= page.x1 and box.y1 <= page.y1 for box in boxes)


@pytest.mark.parametrize("chunks", [(40, 1), (1, 40), (20, 1), (12, 1), (1, 1)])
def test_numbers_along_axes_do_not_overlap(chunks: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = rsegen.Recipe(seed=1, boundary="none", chunk_size=5, chunks=chunks, obstacles=(rsegen.Random(levels=3),))
    half = rsegen.build(recipe).extent[0] / 2
    (axes,) = drawn(recipe, {"robot": np.array([[-half - 0.3, 0.0], [half + 0.3, 0.0]])}, monkeypatch).axes
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=True)
        boxes = [label.get_window_extent() for place, label in ticks if low <= place <= high]
        assert boxes
        assert not any(one.overlaps(other) for one, other in pairwise(boxes))


@pytest.mark.parametrize(("boundary", "last"), [("outer", "frame, 10 cm"), ("none", "20 cm")])
def test_the_legend_has_every_colour_of_the_plan(boundary: str, last: str, monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = rsegen.Recipe(seed=1, boundary=boundary, obstacles=(rsegen.Random(levels=3),))
    figure = drawn(recipe, {"robot": np.array([[-0.7, 0.0], [0.7, 0.1]])}, monkeypatch)
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert labels == {"robot", "0 cm", "10 cm", "20 cm", last}


def test_robots_one_behind_the_other_begin_in_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = rsegen.Recipe(seed=1, boundary="none", obstacles=(rsegen.Random(levels=3),))
    lines = {f"robot_{n}": np.array([[-1.0 - 1.1 * n, 0.2], [0.0, 0.2]]) for n in range(2)}
    (axes,) = drawn(recipe, lines, monkeypatch).axes
    assert axes.get_xlim()[0] < -2.1
    lines["robot_0"] = np.array([[-1.0, 0.2], [50.0, 0.2]])
    (axes,) = drawn(recipe, lines, monkeypatch).axes
    assert axes.get_xlim()[1] < 3, "the map is small in it"
