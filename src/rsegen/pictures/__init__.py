"""Pictures of maps: previews and plans, and what all plots share."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="pictures of maps, plots, and fields in notebooks",
    commands=(
        Command(
            "preview",
            "measure",
            "draw a map: plan with heights, and a view in 3D",
            "rsegen.pictures.commands",
            title="Draw a preview",
            also=("plot", "draw", "render", "picture", "image", "visualise", "visualize", "show"),
        ),
    ),
    public={"rsegen.pictures.preview": ("preview",)},
    sidecars=("rsegen.pictures.sidecar:Preview",),
    notebook="rsegen.pictures.notebook:register_formatters",
)
