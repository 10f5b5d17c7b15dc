"""A capability: a command, a public name, and a file next to each world. It names modules, and imports none of them."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="blocks, counted",
    needs=("pictures",),
    commands=(Command("tally", "measure", "count the blocks of a map", "rsegen_demo.tally", "tally"),),
    public={"rsegen_demo.tally": ("tally",)},
    sidecars=("rsegen_demo.tally:Tally",),
)
