"""The host of all documents that pages have open: recipes that are edited, each with its history."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from rsegen.errors import UserError
from rsegen.gui.model.document import Document
from rsegen.gui.model.session import Session
from rsegen.page.calls import call, call_of_host
from rsegen.page.jobs import Jobs
from rsegen.recipe.examples import or_example


@dataclass(kw_only=True)
class Opened:
    """A document that pages have open; `revision` counts its changes."""

    id: str
    document: Document
    revision: int = 0


@dataclass(kw_only=True)
class Host:
    """All documents by their ids, the folder in which files may be read and written, and the commands that run."""

    folder: Path
    jobs: Jobs = field(default_factory=Jobs)
    documents: dict[str, Opened] = field(default_factory=dict)
    _ids: Any = field(default_factory=lambda: count(1))

    def opened(self, name: str) -> Opened:
        """Return a document by its id."""
        if name not in self.documents:
            raise UserError(f"document {name} is not open here any more: reload the page")
        return self.documents[name]

    def open(self, session: Session) -> Opened:
        """Open a session as a document."""
        document = Document(Session.new())
        document.open(session)
        opened = Opened(id=f"d{next(self._ids)}", document=document)
        self.documents[opened.id] = opened
        return opened


@call_of_host
def open(host: Host, *, what: str = "") -> dict[str, Any]:  # noqa: A001  # its name on the page
    """Open a new recipe, a file, or an example."""
    session = Session.opened(Path(or_example(what))) if what else Session.new()
    return {"doc": host.open(session).id}


@call
def state(opened: Opened) -> dict[str, Any]:
    """Return all that pages show of a document."""
    session = opened.document.session
    problem = session.problem
    return {
        "doc": opened.id,
        "revision": opened.revision,
        "title": session.title,
        "path": str(session.path) if session.path else None,
        "unsaved": session.unsaved,
        "can_undo": session.can_undo,
        "can_redo": session.can_redo,
        "values": dict(session.draft.values),
        "rows": [{"entry": dict(row.entry), "enabled": row.enabled} for row in session.draft.rows],
        "problem": {"where": problem.where, "text": problem.problem} if problem else None,
        "maps": session.recipe.maps,
        "name": session.recipe.name,
    }


@call
def edit(opened: Opened, *, actions: list[dict[str, Any]]) -> dict[str, Any]:
    """Change a document by some actions, and return its state."""
    session = opened.document.session
    for action in actions:
        match action.pop("do"):
            case "set":
                session.set(action["name"], action["value"], gesture=action.get("gesture"))
            case "reroll":
                session.reroll()
            case "add":
                session.add(action["entry"], action.get("at"))
            case "change":
                session.change(action["row"], action["entry"], gesture=action.get("gesture"))
            case "remove":
                session.remove(action["row"])
            case "clear":
                session.clear()
            case "move":
                session.move(action["row"], action["to"])
            case "enable":
                session.enable(action["row"], enabled=action["enabled"])
            case "duplicate":
                session.duplicate(action["row"])
            case "move_end":
                opened.document.move_end(action["row"], action["end"], tuple(action["cell"]))
            case "paint":
                opened.document.selected = action.get("row", -1)
                cells = [tuple(cell) for cell in action["cells"]]
                opened.document.paint(cells, action["level"], action.get("gesture", 0))
            case "undo":
                session.undo()
            case "redo":
                session.redo()
            case other:
                raise UserError(f"unknown action {other!r}")
    opened.revision += 1
    return state(opened) | {"selected": opened.document.selected}
