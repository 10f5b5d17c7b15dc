"""The metrics of a map: roughness, and traversability for a robot; every module computes one family of them.

StepField --metrics--> Metrics, in metres; docs/metrics.md has every formula with its source.
"""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="how rough maps are, and what a robot can do on them",
    needs=("pictures",),
    commands=(
        Command(
            "metrics",
            "measure",
            "measure how rough maps are, and what a robot can do on them",
            "rsegen.measuring.commands",
            title="Measure maps",
            also=("measure", "analyse", "analyze", "evaluate", "roughness", "statistics", "stats"),
        ),
    ),
    public={"rsegen.measuring.catalogue": ("Metric", "Metrics", "metric", "metrics")},
    manual="metrics",
)
