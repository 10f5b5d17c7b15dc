"""Maps and robots in a simulation that runs: spawn, replace, remove."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="maps and robots in a running simulation",
    needs=("robots", "simulators", "standing"),
    commands=(
        Command(
            "spawn",
            "simulators",
            "spawn a map or a robot in the running simulation",
            "rsegen.spawning.commands",
            "spawn",
            title="Add to a running simulation",
            also=("load", "add", "insert"),
        ),
        Command(
            "respawn",
            "simulators",
            "replace the map of the running simulation by the next one",
            "rsegen.spawning.commands",
            "respawn",
            title="Show the next map",
        ),
        Command(
            "remove",
            "simulators",
            "delete models from the running simulation",
            "rsegen.spawning.commands",
            "remove",
            title="Remove from a running simulation",
            also=("delete", "rm", "unload"),
        ),
    ),
    public={
        "rsegen.spawning.commands": ("remove", "respawn", "spawn"),
        "rsegen.spawning.spawning": ("RemoveResult", "RespawnResult", "SpawnResult"),
    },
    manual="gazebo",
)
