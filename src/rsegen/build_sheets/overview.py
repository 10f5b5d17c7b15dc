"""The pages of a build sheet about the whole map: the overview, and what is needed besides blocks.

The overview has the arrangement of pallets, the blocks to cut, the timber to buy and how each piece is cut. The page of
materials has frame boards and how to cut them, base boards, weight and cost. Lists that do not fit are counted, and the
sheet as CSV has all of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap

from rsegen import __version__
from rsegen.build_sheets.cut_settings import CutSettings
from rsegen.build_sheets.page import COLUMN, EMPTY, GREY, POINT, ROW, Page, PrintedPlan
from rsegen.build_sheets.timber import (
    CuttingPlan,
    Materials,
    NumberedPallet,
    frame_price,
    length,
    losses,
    together,
    too_short,
    unknown_price,
)
from rsegen.build_sheets.timber_lengths import TimberLengths
from rsegen.field.stepfield import StepField
from rsegen.params.numbers import decimal
from rsegen.scene.scene import Scene, fingerprint

_ABREAST = 3
"""Narrow columns of lists that are too long for one column."""


def draw_cut_list(page: Page, scene: Scene, field: StepField, place: tuple[float, float], bottom: float) -> float:
    """Draw the cut list above `bottom`, counting what does not fit; return the y of the next line."""
    # One level per line with its swatch, or several if they do not fit; below the line their sum, and empty cells.
    (x, y), written = place, page.written
    columns = [x + 20, x + 40, x + 60, x + COLUMN]
    y = page.heading(x, y, "Blocks to cut", COLUMN)
    counts = {level: count for level, count in field.level_counts().items() if level}
    lengths = {level: length(level, field) for level in counts}
    room = max(1, int((bottom - y) / ROW) - 2)
    if len(counts) < room:
        y = page.table(y, columns, [("level", f"length {written.name}", "number", "timber")], size=8, color=GREY)
        for level, count in counts.items():
            page.swatch(x, y, scene.plan_colour(level))
            row = str(level), written.tape(lengths[level]), f"{count:,}", written.long(lengths[level] * count)
            y = page.table(y, columns, [row])
    else:
        # Several levels per line, in narrow columns.
        page.text(x, y, f"number x length in {written.name}", 8, color=GREY)
        rows = max(1, min(room - 2, -(-len(counts) // _ABREAST)))
        for at, (level, count) in enumerate(list(counts.items())[: rows * _ABREAST]):
            left, down = x + at // rows * ((COLUMN + 4) / _ABREAST), y + (at % rows + 1) * ROW
            page.swatch(left, down, scene.plan_colour(level))
            page.text(left + 8, down, f"{count:,} x {written.tape(lengths[level])}", 8)
        y += (rows + 1) * ROW
        if len(counts) > rows * _ABREAST:
            more = len(counts) - rows * _ABREAST
            page.text(x, y, f"and {more} more length{'s'[: more != 1]}, which the sheet as CSV has", 8, color=GREY)
            y += ROW
    page.line((x, x + COLUMN), (y - 3.6, y - 3.6))
    whole = sum(lengths[level] * count for level, count in counts.items())
    y = page.table(y, columns[1:], [("together", f"{sum(counts.values()):,}", written.long(whole))], fontweight="bold")
    page.swatch(x, y, EMPTY)
    page.text(x + 3, y, "0", 8, ha="center", color=GREY)
    empty = field.level_counts().get(0, 0)
    page.text(x + 9, y, f"no block: {empty:,} cell{'s'[: empty != 1]}", 9)
    return y + ROW


_LISTS = 127.0
"""Height of the lists below the plan in millimetres, at the least."""

SMALLEST = 4.0
"""Smallest legible font size of names and heights, in points."""

_LONGEST = 160
"""Characters of a description, at the most: a line in a small font."""

_BROAD = 30
"""Characters in a line of a cutting pattern, at the most, so that the offcut fits next to it."""


def draw_overview(page: Page, scene: Scene, pallets: Sequence[NumberedPallet], needed: Materials) -> None:
    """Draw the overview: the map, and below it, in two columns, what to cut and how."""
    _draw_head(page, scene, len(pallets))
    top = _draw_map(page, scene, pallets) + 12
    below = draw_cut_list(page, scene, scene.field, (page.left, top), page.bottom)
    y = page.heading(page.second, top, "Timber to buy", COLUMN)
    y = page.amounts(page.second, y, _timber(needed, page.written))
    below = max(below, _draw_patterns(page, needed.blocks, y + 4))
    _draw_boxes(page, scene, pallets, below + 6)


def _draw_head(page: Page, scene: Scene, pallets: int) -> None:
    n_x, n_y = scene.field.shape
    timber = page.written
    along_x, along_y = (decimal(round(along * 1e9 / timber.timber_size, 4)) for along in scene.field.extent)
    page.fitted((page.left, 22), f"Build sheet: {scene.name}", 20, page.across - 12, fontweight="bold")
    many = f"{pallets} pallet{'s'[: pallets > 1]}"
    cells = "cells with frames" if scene.field.frame.any() else "cells"
    size = f"{along_x} x {along_y} {timber.timber}, {n_x} x {n_y} {cells}, {many}, seed {scene.recipe.seed}"
    page.text(page.left, 29, size, 10)
    page.fitted((page.left, 35), scene.recipe.description[:_LONGEST], 9, page.across, color=GREY)
    about = f"seen from above; fingerprint {fingerprint(scene.field.blocks)}; rsegen {__version__}"
    page.text(page.left, 39.5, about, 8, color=GREY)
    page.compass()


def _draw_map(page: Page, scene: Scene, pallets: Sequence[NumberedPallet]) -> float:
    """Draw the map from above with the name and number of each pallet; return the y of its lower end."""
    n_x, n_y = scene.field.shape
    top = 43.0
    cell = min(page.across / n_x, (page.bottom - _LISTS - top) / n_y)
    left, bottom = page.left + (page.across - n_x * cell) / 2, top + n_y * cell
    side = scene.field.block_width
    # A plan per pallet, placed by its centre: the drawing of the whole map is made of those that the pallets have.
    for pallet in pallets:
        field = pallet.chunk.field
        (cells_x, cells_y), (x, y) = field.shape, pallet.chunk.centre
        plan = PrintedPlan(
            page=page,
            scene=scene,
            field=field,
            left=left + (x / side + (n_x - cells_x) / 2) * cell,
            top=bottom - (y / side + (n_y + cells_y) / 2) * cell,
            cell=cell,
        )
        plan.draw(min(0.4, cell / 25))
        page.rectangle((plan.left, plan.top), (cells_x * cell, cells_y * cell), linewidth=1.2)
        if len(pallets) > 1:
            _draw_name(plan, pallet)
    # A run starts in the west, and its goal is in the east.
    for x, text in ((left - 3, "start"), (left + n_x * cell + 3, "goal")):
        style = {"ha": "center", "va": "center", "color": GREY}
        page.text(x, bottom - n_y * cell / 2, text, 8, rotation=90, **style)
        page.text(x, bottom - n_y * cell / 2 - 7, "\N{RIGHTWARDS ARROW}", 9, **style)
    if len(pallets) == 1:
        return bottom
    rule = "Pallets are built row by row from the north-west; A1 is the one of smallest x and y, as on a chess board."
    page.text(page.left, bottom + 5, rule, 8, color=GREY)
    return bottom


def _draw_name(plan: PrintedPlan, pallet: NumberedPallet) -> None:
    """Draw the name of a pallet on a white card in its middle, with the number if there is room."""
    n_x, n_y = plan.field.shape
    x, y = plan.middle((n_x - 1) / 2, (n_y - 1) / 2)
    for text in (f"{pallet.number}: {pallet.name}", pallet.name):
        # A letter is 0.72 of the font's size wide, and the card needs one more point per point.
        size = min(15.0, n_x * plan.cell / POINT / (0.72 * len(text) + 1))
        if size >= SMALLEST:
            break
    card = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "black", "linewidth": 0.5}
    plan.page.text(x, y, text, size, ha="center", va="center", fontweight="bold", bbox=card)


def _draw_patterns(page: Page, plan: CuttingPlan, y: float) -> float:
    """Draw how every piece of stock is cut, in the right column; return the y of the next line."""
    written = page.written
    y = page.heading(page.second, y, f"Cutting {written.stock(plan.settings.stock)} of stock", COLUMN)
    for drawn, pattern in enumerate(plan.patterns):
        texts = (f"{count} x {written.tape(part)}".replace(" ", "\xa0") for part, count in pattern.parts)
        parts, offcut = wrap(" + ".join(texts), _BROAD), written.tape(pattern.offcut(plan.settings))
        if y + len(parts) * ROW > page.bottom:
            more = len(plan.patterns) - drawn
            page.text(
                page.second, y, f"and {more} more way{'s'[: more != 1]}, which the sheet as CSV has", 8, color=GREY
            )
            return y + ROW
        page.text(page.second + 10, y, f"{pattern.pieces:,} x", ha="right")
        for at, line in enumerate(parts):
            page.text(page.second + 13, y + at * ROW, line)
        page.text(page.second + COLUMN, y, f"{offcut} left", 8, ha="right", color=GREY)
        y += len(parts) * ROW
    return y


def _timber(needed: Materials, written: TimberLengths) -> Iterator[tuple[str, str]]:
    """Yield the lines about timber, each a text and an amount."""
    plan, settings, (width, _) = needed.blocks, needed.blocks.settings, needed.section
    stock = written.stock(settings.stock)
    yield f"blocks: {stock} of {_by((width, width), written)}", _pieces(plan.pieces)
    yield from _sold_as((width, width), written)
    yield "  blocks together", written.long(plan.timber)
    yield f"  lost: {losses(settings, written)}", written.long(plan.kerf_loss)
    if plan.trimmed:
        yield f"  ends, {written.tape(settings.trim // 2)} {written.unit} each", written.long(plan.trimmed)
    yield "  left over", written.long(plan.offcuts)
    if needed.frames:
        pieces = _pieces(needed.boards.pieces) if needed.boards else "too short"
        yield f"frames: {stock} of {_by(needed.section, written)}", pieces
        yield from _sold_as(needed.section, written)
        yield from _boards(needed.frames, written)


def _sold_as(section: tuple[int, int], written: TimberLengths) -> Iterator[tuple[str, str]]:
    """Yield a line with the name by which lumber of a section is sold, if it has one."""
    if name := written.section(section):
        yield f"  sold as {name}, dry and planed", ""


def _boards(frames: Mapping[int, int], written: TimberLengths, boards: str = " boards") -> Iterator[tuple[str, str]]:
    """Yield a line per length of boards."""
    for board, count in frames.items():
        yield f"  {count:,}{boards} of {written.tape(board)} {written.unit}", written.long(board * count)


def _pieces(count: int) -> str:
    """Return a number of pieces of stock as text."""
    return f"{count:,} piece{'s'[: count != 1]}"


def _draw_boxes(page: Page, scene: Scene, pallets: Sequence[NumberedPallet], y: float) -> None:
    """Draw a table of the blocks of each pallet, if there is room for it."""
    levels = [level for level in scene.field.level_counts() if level]
    if not levels or len(levels) > 8 or len(pallets) < 2 or y + (len(pallets) + 3) * ROW > page.bottom:
        return
    y = page.heading(page.left, y, "Blocks for each pallet", page.across)
    columns = [page.left + 8, page.left + 24, *(page.left + 44 + 17 * at for at in range(len(levels)))]
    heads = [f"{page.written.tape(length(level, scene.field))} {page.written.unit}" for level in levels]
    y = page.table(y, columns, [("", "pallet", *heads)], size=8, color=GREY)
    for pallet in pallets:
        counts = pallet.chunk.field.level_counts()
        row = (str(pallet.number), pallet.name, *(str(counts.get(level, 0)) for level in levels))
        y = page.table(y, columns, [row])


_STEPS = (
    "Cut the frame boards first: two as long as the frame",
    "is outside, in the north and the south, and two between",
    "them. Screw the corners, and the frame to its base",
    "board, from which all heights count; its thickness is",
    "free, if it carries the weight.",
    "",
    "A block stands upright on a cut end: its length is its",
    "height. Measure the timber first: for another section",
    "make a new sheet (--block-width-cm).",
    "",
    "Try a row of blocks in the frame before all are cut.",
    "Place them in the order of the pallet's page. They",
    "stand by themselves between the frame and one another;",
    "to move a pallet, fix each with glue, or with a screw",
    "from below through the base board.",
    "",
    "Lengths are those of finished parts. Wood swells: give",
    "blocks some play in the frame (--play-mm), which makes",
    "its boards and base longer.",
)


def draw_materials(page: Page, scene: Scene, needed: Materials) -> None:
    """Draw the page of materials, with the steps of building."""
    settings, written = needed.blocks.settings, page.written
    page.text(page.left, 22, "Frames, bases and cost", 20, fontweight="bold")
    page.fitted((page.left, 29), scene.name, 9, page.across)
    weights = [(f"blocks, of {written.density(settings.density)}", written.weight(needed.block_weight))]
    if needed.frames:
        weights.append(("frames", written.weight(needed.frame_weight)))
    # The left column says what is needed, the right one how to cut the boards and how to build.
    y = 40.0
    for heading, rows in (
        ("Frames", _frames(needed, written)),
        ("Base boards", [(f"{needed.bases:,} of {_by(needed.base, written)}", "")]),
        ("Weight", weights),
        ("Cost", _cost(needed, scene, settings)),
    ):
        y = page.heading(page.left, y, heading, COLUMN)
        y = page.amounts(page.left, y, rows) + 4
    y = 40.0
    if needed.boards:
        y = _draw_patterns(page, needed.boards, y) + 4
    page.instructions(y, _STEPS)


def _frames(needed: Materials, written: TimberLengths) -> Iterator[tuple[str, str]]:
    if not needed.frames:
        yield "none", ""
        return
    yield f"boards, {_by(needed.section, written)} high", written.long(together(needed.frames))
    yield from _boards(needed.frames, written, "")
    stock = written.stock(needed.blocks.settings.stock)
    if needed.boards:
        yield f"stock of {stock}", _pieces(needed.boards.pieces)
    else:
        yield from ((line, "") for line in too_short(needed, written))


def _by(sides: tuple[int, ...], written: TimberLengths) -> str:
    return f"{' x '.join(map(written.tape, sides))} {written.unit}"


def _cost(needed: Materials, scene: Scene, settings: CutSettings) -> Iterator[tuple[str, str]]:
    if settings.price is None:
        yield "no price given (--price, --frame-price)", ""
        return
    yield f"blocks: {needed.blocks.pieces:,} x {settings.price:,.2f}", f"{needed.blocks.pieces * settings.price:,.2f}"
    price = frame_price(scene.recipe, settings)
    if needed.boards and price is not None:
        yield f"frames: {needed.boards.pieces:,} x {price:,.2f}", f"{needed.boards.pieces * price:,.2f}"
    if needed.price is not None:
        yield "together, without base boards", f"{needed.price:,.2f}"
    else:
        yield f"frames: {unknown_price(needed)}", ""
