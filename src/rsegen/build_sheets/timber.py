"""Timber for a map: the cutting plan, the order of building, frame boards, base boards, weight and cost.

Cutting plan: the one-dimensional cutting stock problem, by first-fit decreasing: the longest parts first, each into the
first piece of stock with room for it. It needs at most 11/9 of the least number of pieces, plus 6/9 (Dosa 2007); on
maps, whose parts are few multiples of a unit, mostly the least. Pieces that are cut alike are one `Pattern` with a
count, so the time grows with the lengths, not with the blocks. Lengths are whole nanometres, so that twelve blocks of
20 cm are exactly 240 cm.

     |trim| part + tolerance |kerf| part + tolerance |kerf| room |trim|

Order of building: pallets and blocks are numbered row by row from the north-west to the south-east. A person at the
south side of a pallet fills the far row first and never reaches over placed blocks; every block leans on the frame or
on the previous one.

Frames: two boards as long as the frame is outside, and two between them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rsegen.build_sheets.cut_settings import CutSettings, nanometres
from rsegen.build_sheets.timber_lengths import TimberLengths
from rsegen.field.stepfield import Chunk, Ints, Levels, StepField
from rsegen.params.sorts import Cell
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene


@dataclass(frozen=True, kw_only=True, slots=True)
class Pattern:
    """Pieces of stock that are cut alike, into `parts` (length, number); `room` is the length that is still free.

    A part takes its length, the tolerance and a kerf, and the stock without its ends counts as a kerf longer: where
    those begin a last part needs no cut of its own.
    """

    pieces: int
    parts: tuple[tuple[int, int], ...]
    room: int

    def offcut(self, settings: CutSettings) -> int:
        """Return the offcut of each piece in nanometres."""
        return max(0, self.room - settings.kerf)


@dataclass(frozen=True, kw_only=True, slots=True)
class CuttingPlan:
    """The patterns by which all parts are cut; lengths in nanometres."""

    settings: CutSettings
    patterns: Sequence[Pattern]

    @property
    def pieces(self) -> int:
        """The number of pieces of stock to buy."""
        return sum(pattern.pieces for pattern in self.patterns)

    @property
    def timber(self) -> int:
        """The length of all blocks together."""
        return sum(pattern.pieces * length * count for pattern in self.patterns for length, count in pattern.parts)

    @property
    def offcuts(self) -> int:
        """The length of all offcuts together."""
        return sum(pattern.pieces * pattern.offcut(self.settings) for pattern in self.patterns)

    @property
    def kerf_loss(self) -> int:
        """The length that is lost to cuts and tolerances, without the ends of the stock."""
        return self.pieces * self.settings.usable - self.timber - self.offcuts

    @property
    def trimmed(self) -> int:
        """The length of all ends that are cut off."""
        return self.pieces * self.settings.trim


def plan_cuts(counts: Mapping[int, int], settings: CutSettings) -> CuttingPlan:
    """Return the cutting plan for a number of parts of each length [nm], by the first-fit-decreasing rule."""
    # Longest first: a length goes into the room that longer ones left, and only then into pieces not cut before.
    patterns: list[Pattern] = []
    for length in sorted(counts, reverse=True):
        settings.check(length, "the longest block", "cm")
        fresh = Pattern(pieces=counts[length], parts=(), room=settings.usable + settings.kerf)
        filled = _filled([*patterns, fresh], length, counts[length], settings.tolerance + settings.kerf)
        patterns = [pattern for pattern in filled if pattern.parts]
    return CuttingPlan(settings=settings, patterns=tuple(patterns))


def _filled(patterns: Sequence[Pattern], length: int, count: int, lost: int) -> Iterator[Pattern]:
    """Yield the patterns in order, each filled with as many parts of a length as fit, until `count` are placed.

    lost: what each part takes besides its length
    """
    # A pattern of many pieces splits in up to three: pieces that are full, one with the rest, and pieces unchanged.
    for pattern in patterns:
        most = pattern.room // (length + lost)
        full = min(pattern.pieces, count // most) if most else 0
        last = min(count - full * most, most) if full < pattern.pieces else 0
        count -= full * most + last
        unchanged = pattern.pieces - full - bool(last)
        for pieces, parts in ((full, most), (int(bool(last)), last), (unchanged, 0)):
            if pieces:
                cut = (*pattern.parts, (length, parts)) if parts else pattern.parts
                yield Pattern(pieces=pieces, parts=cut, room=pattern.room - parts * (length + lost))


@dataclass(frozen=True, kw_only=True, slots=True)
class NumberedPallet:
    """A pallet with its number in build order, from 1, its name and its first block cell in the map."""

    number: int
    name: str
    corner: Cell
    chunk: Chunk

    @property
    def levels(self) -> Levels:
        """Levels of its blocks, shape (n_x, n_y)."""
        return self.chunk.field.blocks


def building_order(scene: Scene) -> tuple[NumberedPallet, ...]:
    """Return the pallets of a map in build order."""
    side = scene.recipe.chunk_size
    chunks = sorted(scene.field.chunks(side), key=lambda chunk: (-chunk.index[1], chunk.index[0]))
    return tuple(
        NumberedPallet(
            number=position, name=name(chunk.index), corner=(chunk.index[0] * side, chunk.index[1] * side), chunk=chunk
        )
        for position, chunk in enumerate(chunks, 1)
    )


def name(chunk: Cell) -> str:
    """Return the name of a pallet as on a chess board: a letter along x, a number along y, A1 in the south-west."""
    letters, column = "", chunk[0] + 1  # as in a spreadsheet: Z is followed by AA
    while column:
        column, letter = divmod(column - 1, 26)
        letters = chr(ord("A") + letter) + letters
    return f"{letters}{chunk[1] + 1}"


def placing_order(levels: Levels) -> Ints:
    """Return the placing order of each block, from 1, shape (n_x, n_y); 0 for no block."""
    as_read = levels.T[::-1]
    order = np.where(as_read > 0, np.cumsum(as_read > 0).reshape(as_read.shape), 0)
    return order[::-1].T


def length_counts(field: StepField) -> Mapping[int, int]:
    """Return the number of blocks of each length [nm], the shortest first."""
    return {length(level, field): count for level, count in field.level_counts().items() if level}


def length(level: int, field: StepField) -> int:
    """Return the length of a block of a level in nanometres."""
    return nanometres(round(level * field.unit * 100, 7))


def frames(recipe: Recipe, play: int = 0) -> dict[int, int]:
    """Return the number of boards of each length [nm] of all frames, the longest first; empty without frames.

    play: of the blocks inside, in nanometres
    """
    if recipe.boundary == "none" or not recipe.frame_height_cm:
        return {}
    (count, (n_x, n_y)), width = _bodies(recipe), nanometres(recipe.block_width_cm)
    # A board is as thick as a block is wide. Two lengths may be equal, so a Counter adds them.
    boards = Counter({(n_x + 2) * width + play: 2 * count})
    boards[n_y * width + play] += 2 * count
    return dict(sorted(boards.items(), reverse=True))


def together(counts: Mapping[int, int]) -> int:
    """Return the length of all of some parts."""
    return sum(length * count for length, count in counts.items())


_METRE = 10**9
"""Nanometres of a metre."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Materials:
    """The cutting plans of blocks and frames, base boards (number, sides in nm), weights [kg] and the total price.

    frames: boards of each length; section: width of a block, and height of a board, in nm
    boards: None if there are none, or if the stock is too short for one
    price: None if none was given
    """

    blocks: CuttingPlan
    frames: Mapping[int, int]
    section: tuple[int, int]
    boards: CuttingPlan | None
    bases: int
    base: tuple[int, int]
    block_weight: float
    frame_weight: float
    price: float | None


def materials(field: StepField, recipe: Recipe, settings: CutSettings) -> Materials:
    """Return the materials of a map."""
    blocks, known = plan_cuts(length_counts(field), settings), frames(recipe, settings.play)
    boards = plan_cuts(known, settings) if known and settings.fits(max(known)) else None
    side, high = recipe.block_width_cm / 100, recipe.frame_height_cm / 100
    # A base board is below each chunk with its frame, or below a map in one frame.
    (bases, (n_x, n_y)), width = _bodies(recipe), nanometres(recipe.block_width_cm)
    rim = 2 * width + settings.play if recipe.boundary != "none" else 0
    # The price is known only if all of its parts are: of boards both their number and the price of a piece.
    price, board_price = settings.price, frame_price(recipe, settings)
    if price is not None:
        price *= blocks.pieces
        if known:
            price = price + boards.pieces * board_price if boards and board_price is not None else None
    return Materials(
        blocks=blocks,
        frames=known,
        section=(width, nanometres(recipe.frame_height_cm)),
        boards=boards,
        bases=bases,
        base=(n_x * width + rim, n_y * width + rim),
        block_weight=blocks.timber / _METRE * side**2 * settings.density,
        frame_weight=together(known) / _METRE * side * high * settings.density,
        price=price,
    )


def _bodies(recipe: Recipe) -> tuple[int, Cell]:
    """Return the number of parts that are moved as one, and their blocks along x and y: a framed map, or chunks."""
    m_x, m_y = recipe.chunks
    return (1, recipe.grid.shape) if recipe.boundary == "outer" else (m_x * m_y, (recipe.chunk_size,) * 2)


def frame_price(recipe: Recipe, settings: CutSettings) -> float | None:
    """Return the price of a piece of stock for frames: as for blocks if none is given and the sections are equal."""
    same = recipe.frame_height_cm == recipe.block_width_cm
    return settings.price if settings.frame_price is None and same else settings.frame_price


def losses(settings: CutSettings, written: TimberLengths) -> str:
    """Return what cuts and parts cost besides their lengths: 3 mm per cut + 0.5 mm per part."""
    return f"{written.cut(settings.kerf)} per cut + {written.cut(settings.tolerance)} per part"


def too_short(needed: Materials, written: TimberLengths) -> Iterator[str]:
    """Yield, in lines, that the stock is too short for boards, if it is, and which one is too long."""
    settings = needed.blocks.settings
    if needed.frames and needed.boards is None:
        yield f"{written.stock(settings.stock)} of stock is too short for them:"
        yield f"give {written.at_least(settings.least_stock(max(needed.frames)))} or more (--stock-cm)"


def unknown_price(needed: Materials) -> str:
    """Return why frames have no price."""
    return "no price given (--frame-price)" if needed.boards else "the stock is too short"
