"""The page: a server on this machine, and what it lets a browser do with recipes, maps, robots and commands."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="maps on a page in the browser, to edit and to look at",
    needs=("measuring", "pictures"),
    commands=(
        Command(
            "gui",
            "make worlds",
            "edit maps on a page in the browser",
            "rsegen.page.commands",
            also=("page", "edit", "editor", "web", "browser", "ui", "play", "replay"),
        ),
        Command(
            "view",
            "measure",
            "write maps as an HTML page with a 3D view and heights",
            "rsegen.page.commands",
            title="Page to send",
            also=("visualise", "visualize", "html", "show"),
        ),
    ),
    public={"rsegen.page.service": ("Gui", "gui"), "rsegen.page.view": ("View", "view")},
    manual="page",
)
