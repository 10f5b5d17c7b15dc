"""Ratings of robots: how hard a field they cross, as a number with its interval.

ROBOT --fresh fields, one for each trial--> outcomes --psychometric curve--> the level at which half are crossed
"""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="how hard a field a robot crosses, as a number with its interval",
    needs=("driving", "pictures", "robots", "simulators", "standing"),
    commands=(
        Command(
            "rate",
            "drive a robot",
            "find how hard a field a robot crosses, with a 95 % interval",
            "rsegen.rating.commands",
            "rate",
            title="Rate a robot",
            also=("rating", "score", "difficulty"),
        ),
    ),
    public={
        "rsegen.rating.commands": ("rate",),
        "rsegen.rating.rating": ("Curve", "Rating"),
        "rsegen.rating.reliability": ("ReliabilityTest", "failures_allowed"),
    },
    calls=("rsegen.rating.page",),
    manual="rating",
)
