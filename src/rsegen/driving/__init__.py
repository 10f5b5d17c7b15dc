"""Robots that drive over maps in a simulator: routes, recordings, and what is measured on them."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="drives of robots over maps, and what is measured on them",
    needs=("pictures", "robots", "simulators", "standing"),
    commands=(
        Command(
            "drive",
            "simulation",
            "drive a robot over a map in Gazebo and report how far it got",
            "rsegen.driving.commands",
            "drive",
        ),
    ),
    public={"rsegen.driving.commands": ("drive",), "rsegen.driving.drive": ("DriveResult",)},
    calls=("rsegen.driving.page",),
    manual="driving",
)
