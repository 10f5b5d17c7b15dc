"""Robots that drive over maps in a simulator: routes, recordings, and what is measured on them."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="drives of robots over maps, and what is measured on them",
    needs=("pictures", "robots", "simulators", "standing"),
    commands=(
        Command(
            "drive",
            "drive a robot",
            "drive a robot over a map, in MuJoCo or Gazebo, and report how far it got",
            "rsegen.driving.commands",
            "drive",
            title="Drive over a map",
            also=("simulate", "run", "go", "cross"),
        ),
        Command(
            "predict",
            "drive a robot",
            "predict how surely a robot gets across a map",
            "rsegen.driving.commands",
            "predict",
            title="Predict a crossing",
            also=("crossable", "certainty"),
        ),
        Command(
            "drives",
            "drive a robot",
            "drive a robot over many maps, and count how many it crosses",
            "rsegen.driving.commands",
            "drive_many",
            title="Drive over many maps",
            also=("batch", "benchmark"),
        ),
    ),
    public={
        "rsegen.driving.commands": ("drive", "drive_many", "predict"),
        "rsegen.driving.drive": ("DriveResult",),
        "rsegen.driving.many": ("ManyDrives",),
        "rsegen.driving.certainty": ("with_certainty",),
        "rsegen.driving.prediction": ("Outcome", "Prediction"),
    },
    predictor="rsegen.driving.planning:predictions",
    certainty="rsegen.driving.certainty:with_certainty",
    calls=("rsegen.driving.page",),
    manual="driving",
)
