"""The page in an output cell of a notebook, served by this process."""

from __future__ import annotations

from html import escape
from pathlib import Path

from rsegen.page.host import Host
from rsegen.page.host import open as open_document
from rsegen.page.model.session import Session
from rsegen.page.service import Service
from rsegen.recipe.recipe import Recipe


class Gui:
    """A page that edits a recipe, shown in an output cell; `recipe` is what it has become.

    Its server ends with `close`, in a `with` statement at its end, and with the notebook's kernel.
    """

    def __init__(self, service: Service, doc: str) -> None:
        self._service, self._doc = service, doc
        service.start()

    @property
    def url(self) -> str:
        """The address of the page, with its token; browsers on this machine can open it too."""
        return self._service.url(self._doc)

    @property
    def recipe(self) -> Recipe:
        """The recipe as it is on the page now; the last valid one, if it is not."""
        return self._service.host.opened(self._doc).session.recipe

    def close(self) -> None:
        """End the server, and with it what it runs."""
        self._service.close()

    def __enter__(self) -> Gui:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return the page in a frame, which notebooks show."""
        frame = 'width="100%" height="760" style="border: 0" allow="clipboard-write; fullscreen"'
        return f'<iframe {frame} src="{escape(self.url)}"></iframe>'


def gui(shown: Recipe | str | Path | None = None, *, folder: str | Path = ".", port: int | None = None) -> Gui:
    """Return a page that edits a recipe: `rsegen.gui(recipe)` in a cell of Jupyter.

    shown: a recipe, the path of a file in `folder`, the name of an example, or nothing, which is a new recipe; folder:
    where the page reads and writes files; port: of its address, of which a remote machine's must be forwarded. A
    UserError if it cannot be had.
    """
    host = Host(folder=Path(folder).resolve())
    if isinstance(shown, Recipe):
        doc = host.open(Session.of(shown)).id
    else:
        doc = open_document(host, what=str(shown or ""))["doc"]
    return Gui(Service(host=host, port=port, keep=True), doc)
