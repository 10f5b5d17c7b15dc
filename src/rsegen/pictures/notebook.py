"""Small plans of fields and scenes in notebooks: formatters that IPython asks for by the type of a cell's value.

`import rsegen` registers them if IPython runs, and `%load_ext rsegen.pictures.notebook` does it later.
Types are given by their names, so nothing is imported before the first plan is drawn. Views, scans and comparisons draw
themselves (`_repr_html_`, `_repr_png_`), as all that they need is below them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rsegen.field.stepfield import StepField
    from rsegen.scene.scene import Scene

_SHOWN_AS_PLANS = (("rsegen.field.stepfield", "StepField"), ("rsegen.scene.scene", "Scene"))


def load_ipython_extension(shell: Any) -> None:
    """Register the formatters with an IPython shell, which calls this by its name for `%load_ext`."""
    formatter = shell.display_formatter.formatters["image/png"]
    for module, name in _SHOWN_AS_PLANS:
        formatter.for_type_by_name(module, name, _small_plan)


def register_formatters() -> None:
    """Register the formatters with the IPython shell of this process, if one runs."""
    from IPython.core.getipython import get_ipython  # already imported: see rsegen/__init__.py

    shell = get_ipython()
    if shell is not None:
        load_ipython_extension(shell)


def _small_plan(shown: StepField | Scene) -> bytes:
    from rsegen.pictures.preview import thumbnail

    return thumbnail(shown)
