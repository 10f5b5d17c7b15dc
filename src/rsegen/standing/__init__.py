"""Robots on a field: their bodies, poses at rest, and ways across.

body --settle--> at rest --force_margin--> can it push itself on --drive--> lanes --Lattice--> reach, ways

A body is made from collision shapes by rsegen.robots.
"""

from rsegen.params.capabilities import Capability

CAPABILITY = Capability(
    summary="how a robot stands on a field: poses, lanes, ways, spots",
    needs=("pictures",),
    public={
        "rsegen.standing.outlines": ("Spot",),
        "rsegen.standing.resting": ("Poses",),
        "rsegen.standing.stable": ("StablePoses",),
    },
    offers={"rsegen.formats": {"posture": "rsegen.standing.posture"}},
    manual="poses",
)
