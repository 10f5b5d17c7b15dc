"""How a map is represented in a simulator: meshes, collision shapes, friction, colours."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

from rsegen.errors import ParameterError
from rsegen.params.sorts import Choice, Flag, Float, Integer, ListOf, Text, validate

_FRICTION = Float(0, 1000, help="friction coefficient of blocks, frames and ground")
_COLOUR = Text("#[0-9A-Fa-f]{6}", "#rrggbb, in quotes")


@dataclass(frozen=True, kw_only=True)
class Representation:
    """How a map is represented in a simulator; none of it changes the levels of a block."""

    mesh_type: Annotated[
        str, Choice(("single", "multi", "pallet"), help="one model per map, per block, or per chunk")
    ] = "single"
    simulator: Annotated[
        str,
        Choice(
            ("both", "classic"),
            help="target simulator: both, or classic for smoother floors in Gazebo Classic; a map opens in both",
        ),
    ] = "both"
    mesh: Annotated[
        str,
        Choice(
            ("merged", "watertight", "blocks"),
            help="mesh: the exposed surface in few rectangles, closed and without gaps, or 6 faces per block",
        ),
    ] = "merged"
    collision: Annotated[
        str,
        Choice(
            ("mesh", "boxes", "blocks"),
            help="collision shape: the visual mesh, a few merged boxes, or one box per block",
        ),
    ] = "mesh"
    tile: Annotated[
        int,
        Integer(
            0, 100_000, unit="cells", help="cut the mesh into square parts of this side, one file each; 0: one mesh"
        ),
    ] = 0
    friction: Annotated[float, _FRICTION] = 1.0
    frame_friction: Annotated[float | None, replace(_FRICTION, help="friction of the frames, if different")] = None
    level_friction: Annotated[
        tuple[float, ...] | None,
        ListOf(_FRICTION, help="friction of blocks of level 1, 2, ...; higher levels have that of the map"),
    ] = None
    units: Annotated[
        str,
        Choice(("cm", "in"), help="lengths on build sheets and in reports: centimetres and metres, or inches and feet"),
    ] = "cm"
    look: Annotated[
        str,
        Choice(
            ("plain", "levels", "wood", "friction"),
            help="surface of the blocks: plain, one colour per level; levels, the same with the edges of every block; "
            "wood, pine with end grain and long grain; friction, one colour per coefficient, with edges",
        ),
    ] = "plain"
    shadows: Annotated[bool, Flag(help="cast shadows in the world")] = False
    sky: Annotated[bool, Flag(help="show a sky in the world")] = False
    frame_colour: Annotated[str | None, replace(_COLOUR, help="colour of the frames")] = None
    level_colours: Annotated[
        tuple[str, ...] | None,
        ListOf(_COLOUR, help="colours of blocks of level 1, 2, ...; higher levels keep the default ones"),
    ] = None

    def __post_init__(self) -> None:
        validate(self)
        self.check_representation()

    @property
    def is_textured(self) -> bool:
        """Whether the blocks have textures."""
        return self.look != "plain"

    @property
    def is_of_one_friction(self) -> bool:
        """Whether blocks, frames and ground all have the same coefficient."""
        given = (self.frame_friction, *(self.level_friction or ()))
        return all(friction in (None, self.friction) for friction in given)

    def check_representation(self) -> None:
        """Raise a ParameterError for a shape that models of this mesh type cannot have."""
        if self.mesh_type == "multi" and self.mesh != "merged":
            raise ParameterError("mesh", f"'{self.mesh}' is for mesh_type single and pallet; multi is made of boxes")
        if self.mesh_type == "multi" and self.collision == "boxes":
            raise ParameterError("collision", "'boxes' is for mesh_type single and pallet; in multi every block is one")
        if self.simulator == "classic" and self.mesh_type != "single":
            raise ParameterError("simulator", f"'classic' is for mesh_type single; give both with {self.mesh_type}")
        if self.tile and self.mesh_type != "single":
            raise ParameterError("tile", f"{self.tile} is for mesh_type single; give 0 with mesh_type {self.mesh_type}")
        if self.tile and self.mesh == "watertight":
            raise ParameterError("tile", f"{self.tile} would cut a watertight mesh open; give 0, or mesh merged")
