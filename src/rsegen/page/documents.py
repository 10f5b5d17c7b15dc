"""Calls of pages about documents: open, show, edit, save and close them, and list the files that can be opened."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypedDict

from rsegen.errors import FileError, UserError, did_you_mean
from rsegen.input_files import regular_content
from rsegen.page.calls import call_of_document, call_of_host
from rsegen.page.host import Host, Opened, State, state_of
from rsegen.page.model.actions import Action, act
from rsegen.page.model.document import session_of_file
from rsegen.page.model.session import Session
from rsegen.page.model.texts import command_line, python_code, text_after
from rsegen.page.places import Kind, kind_of, names_in
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import recipe_in
from rsegen.writing.target_worlds import recipe_files


class EditedState(State):
    """The state after a change."""

    selected: int  # the row that the last action was about; -1: none


class OpenedDocument(TypedDict):
    """The id of a document, and the folder of the drive that plays over it, if a drive was opened; else empty."""

    doc: str
    play: str


class ListedFile(TypedDict):
    """A file or folder, as a list of files has it."""

    name: str
    path: str
    kind: Kind


class Listing(TypedDict):
    """The content of a folder."""

    folder: str
    entries: list[ListedFile]


class Texts(TypedDict):
    """A document as YAML or JSON, as Python, and as a command line."""

    recipe: str
    python: str
    shell: str


@call_of_host
def open(host: Host, *, what: str = "") -> OpenedDocument:  # noqa: A001  # its name on the page
    """Open a new recipe, a file, an example, a map of a data set, or a drive with its map."""
    # In this order: a new recipe, a map of a data set (DIR#17), an example or a file; a file of the page's folder is
    # edited, any other one is only the beginning of a document without a file.
    if not what:
        return {"doc": host.open().id, "play": ""}
    name, sharp, place = what.rpartition("#")
    path = host.places.inside(name if sharp and place.isdecimal() else what)
    if sharp and place.isdecimal():
        opened = host.open(Session.of(recipe_in(f"{path}#{place}")), what)
        opened.what = what
        opened.data_set = {"folder": name, "place": int(place), "maps": _maps_in(path)}
        return {"doc": opened.id, "play": ""}
    is_example = what in EXAMPLES and not path.exists()
    if not is_example and not path.exists():
        raise FileError(
            f"{what}: neither a file in {host.folder} nor the name of an example{did_you_mean(what, EXAMPLES)}"
        )
    file = EXAMPLES[what] if is_example else recipe_files(str(path))[0].resolve()
    if file.is_relative_to(host.folder.resolve()):
        play = str(host.places.relative(file.parent)) if (file.parent / "drive.json").is_file() else ""
        return {"doc": host.open_file(file).id, "play": play}
    title = f"copy of {what if is_example else file.name}"
    opened = host.open(session_of_file(file), title, file.read_text("utf-8"))
    opened.what = what if is_example else ""
    return {"doc": opened.id, "play": ""}


def _maps_in(data_set: Path) -> int:
    """Return the number of maps of a data set whose manifest has been read without complaint."""
    manifest = regular_content(data_set / "manifest.json", _MOST_MANIFEST)
    return int(json.loads(manifest or b"{}").get("maps", 0))


_MOST_MANIFEST = 2**26
"""Bytes of a manifest at most: some hundred for each of up to a hundred thousand files of maps."""


@call_of_host
def files(host: Host, *, folder: str = "") -> Listing:
    """List a folder: recipes, folders of maps with their recipe, data sets, drives, folders and other files."""
    place = host.places.inside(folder)
    below = host.places.relative(place)
    entries: list[ListedFile] = [
        {"name": name, "path": str(below / name), "kind": kind_of(place / name)} for name in names_in(place)
    ]
    return {"folder": "" if below == Path() else str(below), "entries": entries}


@call_of_document
def state(opened: Opened, *, page: str = "", index: int | None = None) -> State:
    """Return all that pages show of a document; index: the map that the page shows."""
    return state_of(opened, opened.index_of(page, index))


@call_of_document
def edit(opened: Opened, *, actions: list[Action], page: str = "", index: int | None = None) -> EditedState:
    """Change a document by some actions, all or none of them, and return its state and the row to select."""
    selected = act(opened.session, actions, opened.index_of(page, index, or_first=True))
    return {**state_of(opened, opened.index_of(page, index, or_first=True)), "selected": selected}


@call_of_document
def reload(opened: Opened, *, page: str = "") -> State:
    """Take over what is in the file."""
    opened.document.reload()
    return state(opened, page=page)


@call_of_document
def texts(opened: Opened) -> Texts:
    """Return the document as the text of its file, as Python, and as a command line."""
    document, recipe = opened.document, opened.session.recipe
    is_json = document.path is not None and document.path.suffix.lower() == ".json"
    return {
        "recipe": text_after("" if is_json else document.text, recipe, ".yaml"),
        "python": python_code(recipe, recipe.name),
        "shell": command_line(recipe, recipe.name),
    }


@call_of_host
def save(host: Host, *, doc: str, path: str = "", replace: bool = False, page: str = "") -> State:
    """Write a document to its file, or to another one in the folder."""
    opened = host.opened(doc)
    target = host.places.inside(path) if path else None
    if target is not None and not target.parent.is_dir():
        raise FileError(f"{path}: there is no folder {target.parent.name}")
    with opened.lock:
        if target and any(other.document.path == target for other in host.all() if other is not opened):
            raise UserError(f"{path}: is open as another document; choose another name")
        opened.document.save(target, replace=replace)
        return state(opened, page=page)


@call_of_host
def close(host: Host, *, doc: str) -> None:
    """Close a document, and discard what is not saved; one that another page has open stays."""
    opened = host.opened(doc)
    if opened.pages <= 1:
        opened.document.journal.remove()
        del host.documents[doc]
