"""Experiments: what maps cost a simulator while robots drive on them; the paper's tables."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="what maps cost a simulator: the paper's tables",
    needs=("driving", "pictures", "robots", "simulators"),
    commands=(
        Command(
            "experiment",
            "drive a robot",
            "measure what maps cost a simulator while robots drive on them",
            "rsegen.experiments.commands",
            "experiment",
            title="Experiment with a simulator",
            also=("experiments", "paper", "table"),
        ),
    ),
    public={"rsegen.experiments.commands": ("experiment",), "rsegen.experiments.run": ("ExperimentResult",)},
    words={"plan": "rsegen.experiments.plan:PLANS"},
    manual="experiment",
)
