"""The brief manual of the window, with all obstacle kinds and parameters."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from PySide6.QtWidgets import QDialog, QTextBrowser, QVBoxLayout, QWidget

from rsegen.field.obstacles import KINDS
from rsegen.gui.widgets.layouts import named
from rsegen.params.registry import summary
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

_HOW = """
<h2>Random step environments</h2>
<p>A map is a grid of blocks whose heights are multiples of the height step, in chunks (pallets) with frames. Obstacles
are imposed on it from the first of the list to the last; where they overlap, the later one counts unless its blend says
otherwise.</p>
<h3>Make a map</h3>
<p>An empty window shows examples to start from; <b>File, New from example</b> has all of them. Or:</p>
<ol>
<li>Choose the size of a chunk, how many chunks the map has, and the height step.</li>
<li>Choose a type of obstacle, its number of levels (5 gives the heights 0, 1, 2, 3 and 4 steps) and softness, and its
ends with the sliders: it is shown pale where it will be. Press <b>+ Add</b>, or draw it with the mouse.</li>
<li>Click a row of the list, or a handle on the plan, to change an obstacle; drag its ends; <b>- Remove</b> removes it,
<b>Clear</b> all of them; Escape makes the form one for a new obstacle. Drag a row of the list to change the order.
Everything can be undone.</li>
<li><b>Paint cells</b> (P) gives single cells a level: with the mouse, or by typing digits on the plan; they become a
matrix.</li>
<li>A coordinate that is <i>random</i> is drawn anew for every map; <b>Re-roll</b> draws another seed.
While <b>Keep</b> is ticked, Start writes what is shown; otherwise every Start draws another seed first.</li>
<li><b>Start</b> writes the maps as worlds for Gazebo into the folder above it.</li>
</ol>
<p>In the view the left button turns, the middle button (or shift) pans, the wheel zooms; arrow keys, + and - do the
same; a click chooses an obstacle. Ctrl+1, Ctrl+2 and Ctrl+3 look in perspective, from above and from the south. On the
plan the wheel zooms, the middle button (or Space and the left one) pans. Ctrl+0 shows the whole map. The status bar
shows the blocks of each level, size, largest step, and what the map costs.</p>
<p><b>Export</b> writes the maps in formats of other programs. <b>Run, Build sheet</b> writes a build sheet (PDF, CSV)
for building the map in wood; while <b>Build sheets</b> is ticked, Start adds one to every map. <b>File, Open a map of a
data set</b> opens one of its maps.</p>
<p><b>Run, Drive over the map</b> drives robots over it in Gazebo; <b>Run, Experiment</b> measures what maps cost it.
<b>View, All maps of the recipe</b> shows them as pictures, sorted by any metric.</p>
<p><b>Run, Show command line and Python code</b> shows how to make the same maps without the window.</p>
"""


def text() -> str:
    """The manual as HTML."""
    return "\n".join(
        [_HOW, "<h3>Obstacles</h3><dl>", *_kinds(), "</dl><h3>Parameters of the map</h3><dl>", *_map(), "</dl>"]
    )


def show_manual(parent: QWidget) -> None:
    """Open the manual next to the window."""
    dialog = named(QDialog(parent), "manual")
    dialog.setWindowTitle("rsegen: manual")
    dialog.resize(640, 640)
    page = QTextBrowser()
    page.setHtml(text())
    QVBoxLayout(dialog).addWidget(page)
    dialog.show()


def _kinds() -> Iterator[str]:
    for kind, cls in KINDS.items():
        yield f"<dt><b>{escape(kind)}</b></dt><dd>{escape(summary(cls))}</dd>"


def _map() -> Iterator[str]:
    for name, parameter in parameters(Recipe).items():
        yield f"<dt><b>{escape(name)}</b></dt><dd>{escape(parameter.help)}: {escape(parameter.describe())}</dd>"
