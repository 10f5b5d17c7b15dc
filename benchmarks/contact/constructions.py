"""The constructions that are compared, one entry each."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.contact import fields, partitions
from benchmarks.contact.fields import Shapes, boxes, mesh

FIXED = '<joint name="anchor" type="fixed"><parent>world</parent><child>link</child></joint>'
HEAVY = (
    "<gravity>false</gravity><inertial><mass>1000000</mass>"
    "<inertia><ixx>1000000</ixx><iyy>1000000</iyy><izz>1000000</izz></inertia></inertial>"
)
BODY = HEAVY + "<kinematic>true</kinematic>"
"""ODE takes the smaller min_depth of two bodies, and a static model is none: only as a body the field can say 0."""

LIFT = 0.00001
"""A body that stands on the ground plane would touch it at every foot of a wall and in every step."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Construction:
    """A name, what it is in a line, its shapes, and how the simulator holds and touches them.

    kd: damping of contacts for ODE, 0 for Gazebo's own 1; held: how the model is kept in its place; link: what its link
    has beside collisions; lift: how far the collisions are raised, metres; levels: whether it can be more than the bare
    ground; quick: whether it is in the short run, and in the long run on every field instead of one.
    """

    name: str
    says: str
    shapes: Shapes = fields.shipped
    kd: int = 0
    held: str = "<static>true</static>"
    link: str = ""
    lift: float = 0
    levels: bool = True
    quick: bool = True


def _body(name: str, says: str, *, shapes: Shapes = fields.shipped, kd: int = 0, quick: bool = False) -> Construction:
    """A field that is a kinematic body, held by a joint where `kinematic` is not known."""
    return Construction(name=name, says=says, shapes=shapes, kd=kd, held=FIXED, link=BODY, lift=LIFT, quick=quick)


ALL = (
    Construction(name="plane", says="the bare ground: the goal", shapes=lambda _: (), levels=False),
    _body(
        name="body-kd1000",
        says="the merged surface as a kinematic body, kd 1000: shipped as `simulator: classic`",
        kd=1000,
        quick=True,
    ),
    Construction(name="mesh-kd1000", says="the merged surface, kd 1000: what is shipped", kd=1000),
    Construction(
        name="height-map",
        says="floors as a height map, 4 samples a cell; walls and rims as a mesh",
        shapes=fields.height_map(4),
    ),
    Construction(name="mesh", says="the shipped surface"),
    Construction(name="block-mesh", says="a mesh, 8 vertices and 6 faces per block", shapes=fields.block_mesh),
    _body(name="body", says="the shipped surface as a kinematic body"),
    _body(name="body-kd100", says="the shipped surface as a kinematic body, kd 100", kd=100),
    Construction(
        name="held-kd1000",
        says="the shipped surface as a body that a joint alone holds, kd 1000",
        kd=1000,
        held=FIXED,
        link=HEAVY,
        lift=LIFT,
        quick=False,
    ),
    _body(
        name="body-block-mesh-kd1000",
        says="the block mesh as a kinematic body, kd 1000",
        shapes=fields.block_mesh,
        kd=1000,
    ),
    _body(
        name="body-largest-kd1000",
        says="largest rectangles first, as a kinematic body, kd 1000",
        shapes=mesh(partitions.largest_first),
        kd=1000,
    ),
    Construction(name="mesh-kd100000", says="the shipped surface, kd 100000", kd=100000, quick=False),
    Construction(
        name="largest-kd1000",
        says="largest rectangles first, kd 1000",
        shapes=mesh(partitions.largest_first),
        kd=1000,
        quick=False,
    ),
    Construction(
        name="extended-kd1000",
        says="tops that go on under higher blocks, kd 1000",
        shapes=mesh(partitions.extended),
        kd=1000,
        quick=False,
    ),
    Construction(
        name="layers-mesh-kd1000",
        says="tops of all that is as high or higher, kd 1000",
        shapes=mesh(partitions.layered),
        kd=1000,
        quick=False,
    ),
    Construction(
        name="watertight-kd1000",
        says="the watertight mesh, kd 1000",
        shapes=fields.closed,
        kd=1000,
        quick=False,
    ),
    Construction(name="boxes", says="merged boxes", shapes=boxes(partitions.merged), quick=False),
    Construction(
        name="layers",
        says="boxes for each height below all that is as high or higher",
        shapes=boxes(partitions.layered),
        quick=False,
    ),
    Construction(name="cells", says="a box a cell", shapes=boxes(partitions.cells), quick=False),
)
