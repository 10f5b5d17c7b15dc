"""Pictures, looked at by another library."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pypdf
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image

import rsegen
from rsegen import Random, Recipe, compose
from rsegen.field.stepfield import StepField
from rsegen.pictures.plan import boundary, cell_colours, covered_cells, legend_swatches
from rsegen.pictures.preview import (
    DRAWN,
    IMAGE_FORMATS,
    PAPER,
    WIDTH,
    in_rows,
    layout,
    preview,
    preview_figure,
)
from rsegen.recipe.building import placed
from rsegen.recipe.codec import decode
from rsegen.recipe.examples import EXAMPLES
from tests.support.strategies import recipes

RECIPE = Recipe(seed=1, obstacles=(Random(levels=5),))


@cache
def drawn(recipe: Recipe) -> bytes:
    """The picture of the first map, drawn once per recipe."""
    return preview(compose(recipe))


def image(recipe: Recipe) -> Image.Image:
    return Image.open(io.BytesIO(drawn(recipe)))


def share(found: Image.Image, colour: tuple[float, float, float]) -> float:
    """Share of a picture that has about a colour."""
    pixels = np.asarray(found.convert("RGB")).astype(float) / 255
    return float((np.abs(pixels - colour).max(axis=2) < 0.02).mean())


def test_a_picture_shows_every_level_and_the_frames() -> None:
    found, scene = image(RECIPE), compose(RECIPE)
    for material in range(5):
        assert share(found, scene.plan_colour(material)) > 0.01


def test_a_map_without_frames_is_drawn_without_frames() -> None:
    bare = replace(RECIPE, boundary="none")
    assert share(image(bare), compose(bare).plan_colour(0)) == 0


def test_a_picture_carries_its_recipe() -> None:
    assert decode(json.loads(image(RECIPE).info["Description"])) == RECIPE


@pytest.mark.slow
@pytest.mark.parametrize("format_", IMAGE_FORMATS)
def test_same_map_same_bytes_in_every_format(format_: str) -> None:
    assert preview(compose(RECIPE), format_) == preview(compose(RECIPE), format_)


@pytest.mark.parametrize(
    "recipe", [Recipe(seed=1, boundary="none"), replace(RECIPE, chunk_size=1)], ids=["flat", "one"]
)
def test_the_smallest_maps_can_be_drawn(recipe: Recipe) -> None:
    width, height = image(recipe).size
    assert 1000 < width <= 1600
    assert height > 400


def test_a_large_map_is_drawn_coarser_but_whole() -> None:
    large = replace(RECIPE, chunk_size=DRAWN + 50, boundary="none")
    assert share(image(large), compose(large).plan_colour(4)) > 0.01


@pytest.mark.parametrize("chunks", [(1, 1), (5, 1), (1, 5), (3, 2)], ids=str)
def test_no_half_of_a_picture_is_empty(chunks: tuple[int, int]) -> None:
    """In each of the parts, about as large as a view, there is something drawn; the legend may be short."""
    found = np.asarray(image(replace(RECIPE, chunks=chunks)).convert("L"))
    has_ink = found[:, :-170] < 250
    assert has_ink.any(axis=1).mean() > 0.8
    assert has_ink.any(axis=0).mean() > 0.85
    assert has_ink.mean() > 0.3


@pytest.mark.parametrize(("plan", "view"), [(1, 1.6), (5, 2.1), (0.2, 1.0), (1.9, 1.8), (50, 2.4), (0.02, 0.5)])
@pytest.mark.parametrize("legend", [1.6, 2.2])
def test_the_parts_of_a_picture_keep_their_shape_and_do_not_overlap(plan: float, view: float, legend: float) -> None:
    found = layout(plan, view, legend)
    width, height = found.size
    assert width <= WIDTH + 1e-9
    for (left, low, wide, high), ratio in ((found.plan, plan), (found.view, view)):
        assert left >= 0
        assert low >= 0
        assert left + wide <= found.legend + 1e-9 <= width
        assert low + high <= height
        assert wide / high == pytest.approx(ratio) or (wide / high > ratio and ratio == view)
    (left, low, wide, _), (other, _, _, top) = found.plan, found.view
    assert other >= left + wide or low >= top


@given(recipes(), st.integers(0, 3))
def test_outlines_enclose_the_cells_that_obstacles_cover(recipe: Recipe, index: int) -> None:
    scene = compose(recipe, index)
    inside = np.ix_(scene.field.inside(0), scene.field.inside(1))
    for obstacle in recipe.obstacles:
        _, _, patch = placed(recipe, obstacle, index)
        expected = np.zeros(scene.field.blocks.shape, dtype=bool)
        expected[patch.window] = patch.footprint
        cells = covered_cells(scene, obstacle)
        assert np.array_equal(cells[inside], expected)
        lines = boundary(cells, *scene.field.edges())
        assert np.allclose(np.abs(np.diff(lines, axis=1)).sum(axis=(1, 2)), scene.field.block_width)
        assert len(lines) == sum(np.count_nonzero(np.diff(np.pad(cells, 1), axis=axis)) for axis in (0, 1))


def test_outlines_are_drawn_on_request() -> None:
    course = compose(rsegen.load(EXAMPLES["mixed-course"]))
    with_them, without = (preview(course, "svg", outlines=outlines).decode() for outlines in (True, False))
    for number, obstacle in enumerate(course.recipe.obstacles):
        assert f"<!-- {number}  {obstacle.kind} -->" in with_them
    assert "peak -->" not in without


def test_cells_and_metres_are_on_opposite_sides() -> None:
    """Of a map with a frame in its middle, cell 10 is the first after it."""
    figure = preview_figure(compose(replace(RECIPE, chunks=(2, 2))), "")
    plan = figure.axes[0]
    numbers = {label.get_text(): at for at, label in zip(plan.get_xticks(), plan.get_xticklabels(), strict=True)}
    assert numbers["0"] == pytest.approx(-1.05)
    assert numbers["10"] == pytest.approx(0.15)
    assert [each.get_xlabel() for each in plan.child_axes if each.get_xlabel()] == ["x [m]"]
    assert plan.get_xlabel() == "x [cells]"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["red-diagonal-pallet", "five-pallet-dash"])
def test_a_picture_for_a_paper_is_a_column_wide_and_embeds_its_fonts(name: str) -> None:
    scene = compose(rsegen.load(EXAMPLES[name]))
    with Image.open(io.BytesIO(preview(scene, paper=True, outlines=True))) as found:
        assert found.size[0] == 1050
        assert found.info["dpi"] == pytest.approx((300, 300), abs=0.1)
    made = preview(scene, "pdf", paper=True)
    assert made == preview(scene, "pdf", paper=True)
    (page,) = pypdf.PdfReader(io.BytesIO(made)).pages
    assert float(page.mediabox.width) == 252  # points: 3.5 in
    fonts = [font.get_object() for font in page["/Resources"]["/Font"].values()]  # type: ignore[index]
    assert {font["/Subtype"] for font in fonts} == {"/Type0"}  # TrueType in a PDF; publishers refuse /Type3
    sizes: list[float] = []
    page.extract_text(visitor_text=lambda text, _, __, ___, size: sizes.append(size) if text.strip() else None)
    assert min(sizes) >= 4


def test_a_picture_for_a_paper_leaves_others_as_they_are() -> None:
    before = drawn(RECIPE)
    preview(compose(RECIPE), paper=True)
    assert preview(compose(RECIPE)) == before


def test_a_picture_says_which_version_made_it() -> None:
    maker, scene = f"rsegen {rsegen.__version__}", compose(RECIPE)
    assert image(RECIPE).info["Software"] == maker
    assert maker in preview(scene, "svg").decode()
    assert maker.encode() in preview(scene, "pdf")


@pytest.mark.parametrize(("paper", "is_stamped"), [(False, True), (True, False)])
def test_the_version_is_in_the_corner_of_all_pictures_but_those_for_a_paper(paper: bool, is_stamped: bool) -> None:
    text = preview(compose(RECIPE), "svg", paper=paper).decode()
    assert (f"<!-- rsegen {rsegen.__version__} -->" in text) == is_stamped


def test_a_legend_has_the_ground_every_height_and_frames() -> None:
    scene = compose(Recipe(seed=1, boundary="outer", unit_cm=5, obstacles=(Random(levels=3),)))
    entries = {patch.get_label(): patch.get_facecolor() for patch in legend_swatches(scene, 9)}
    assert list(entries) == ["0 cm", "5 cm", "10 cm", "frame, 10 cm"]
    colours = cell_colours(scene.plan_colour, scene.field)
    assert {tuple(colour) for colour in colours.reshape(-1, 3)} == {colour[:3] for colour in entries.values()}


def test_a_robot_in_a_column_of_a_paper_is_described_inside_it() -> None:
    class Resting:
        def draw(self, plan: object) -> None: ...

        def in_front(self, field: StepField) -> np.ndarray:
            return np.zeros(field.shape, dtype=bool)

        def silhouettes(self, project: object, toward: object) -> list[tuple[np.ndarray, str]]:
            return []

        def describe(self) -> str:
            return "the robot tilts by 1.2 degrees, 6 degrees from tipping over; one of 2 stable poses"

    with rc_context(PAPER):
        figure = preview_figure(compose(RECIPE), "", robot=Resting(), paper=True)
        FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]  # matplotlib's
    plan, view = figure.axes
    title, below = view.title.get_window_extent(), plan.xaxis.label.get_window_extent()
    assert figure.bbox.x0 <= title.x0 <= title.x1 <= figure.bbox.x1
    assert title.y1 <= below.y0


def test_entries_of_a_legend_are_read_row_by_row() -> None:
    figure, labels = Figure(), [f"{height} cm" for height in range(1, 8)]
    patches = [Patch(label=label) for label in labels]
    legend = figure.legend(handles=in_rows(patches, 4), ncols=4)
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]  # matplotlib has no types of it
    boxes = {text.get_text(): text.get_window_extent() for text in legend.get_texts()}
    # Digits are a pixel higher or lower, rows some twenty.
    assert sorted(boxes, key=lambda label: (-round(boxes[label].y0 / 10), boxes[label].x0)) == labels


@pytest.mark.parametrize("chunks", [(1, 12), (40, 1), (1, 40), (25, 1), (2, 2)])
def test_numbers_along_axes_do_not_overlap(chunks: tuple[int, int]) -> None:
    scene = compose(Recipe(seed=1, chunk_size=1, chunks=chunks, obstacles=(Random(levels=5),)))
    figure = preview_figure(scene, "")
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]  # matplotlib's
    plan = figure.axes[0]
    for axes in (plan, *plan.child_axes):
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=True)
            boxes = [label.get_window_extent() for place, label in ticks if low <= place <= high]
            assert not any(one.overlaps(other) for one, other in pairwise(boxes))
