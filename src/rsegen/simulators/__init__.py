"""The simulators that can open worlds; each is one file of this folder, which is imported automatically."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="worlds in Gazebo: servers, windows, transports",
    needs=("robots", "standing"),
    commands=(
        Command(
            "open",
            "simulators",
            "open a world in Gazebo or MuJoCo",
            "rsegen.simulators.commands",
            "open",
            title="Open in a simulator",
            also=("launch", "start", "gazebo", "world", "simulate", "run"),
        ),
        Command(
            "sim",
            "simulators",
            "list the simulators with version and path, or how to install them",
            "rsegen.simulators.commands",
            title="Simulators on this machine",
            also=("simulators", "gz"),
        ),
    ),
    public={"rsegen.simulators.commands": ("open",), "rsegen.simulators.open_world": ("OpenResult",)},
    reads="rsegen.simulators.open_world:reads",
    doctor="rsegen.simulators.installed:finding",
    manual="gazebo",
)
