"""The build sheet: instructions for building a map in wood, as PDF or CSV."""

from rsegen.params.capabilities import Capability, Command

CAPABILITY = Capability(
    summary="how to build a map in wood",
    needs=("heights", "pictures"),
    commands=(
        Command(
            "sheet",
            "build it in wood",
            "write a build sheet (PDF, CSV) for building a map in wood",
            "rsegen.build_sheets.commands",
            title="Build sheet",
            also=("pdf", "print", "plan", "cut"),
        ),
    ),
    public={"rsegen.build_sheets.cut_settings": ("CutSettings",), "rsegen.build_sheets.document": ("sheet",)},
    sidecars=("rsegen.build_sheets.sidecar:BuildSheet",),
    manual="sheet",
)
