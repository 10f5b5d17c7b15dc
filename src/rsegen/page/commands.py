"""The commands of the page: gui, which serves it, and view, which writes it as a file."""

from __future__ import annotations

import argparse
import json
import os
import shlex
import socket
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import (
    add_input,
    add_target_flags,
    add_target_recipe_flags,
    has_recipe_flags,
    maps_of_flags,
    recipe_from,
)
from rsegen.cli.generate import SHOWN
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, checked_flags
from rsegen.errors import FileError
from rsegen.params.command import Shell, add_flags, flags_in_errors
from rsegen.params.sorts import FilePath, Flag, Integer, Text
from rsegen.writing.user_state import user_name

if TYPE_CHECKING:
    from rsegen.page.service import Service


@dataclass(frozen=True, kw_only=True, slots=True)
class _Serving:
    """Serve a page to edit maps and to drive on them, and open it in the browser."""

    host: Annotated[
        str,
        Text(r"[^\x00-\x20]{1,255}", "an address", help="address to listen on; others let other machines connect"),
        Shell(("--host",), "ADDRESS"),
    ] = "127.0.0.1"
    port: Annotated[
        int | None, Integer(0, 65535, help="port to listen on; 0: any free one"), Shell(("--port",), "N")
    ] = None
    no_browser: Annotated[bool, Flag(help="do not open a browser")] = False
    keep: Annotated[bool, Flag(help="keep the server running after the last page is closed")] = False


def add_gui(command: Parser) -> None:
    """Add the flags of `rsegen gui`."""
    command.explain(_Serving.__doc__)
    where = "YAML or JSON file, the name of an example, a folder, that of a drive, or DIR#17 of a data set"
    add_input(command, where, metavar="RECIPE-or-DIR")
    add_flags(command.group("server"), _Serving)
    add_target_recipe_flags(command)


def run_gui(arguments: argparse.Namespace) -> None:
    """Serve the page until it is closed, or the command is stopped."""
    from rsegen.page.documents import OpenedDocument
    from rsegen.page.documents import open as open_document
    from rsegen.page.host import Host
    from rsegen.page.model.session import Session
    from rsegen.page.service import Service

    serving = _Serving(**checked_flags(_Serving, arguments))
    folder, to_open = _place(arguments.recipe)
    host = Host(folder=folder)
    if has_recipe_flags(arguments):
        opened: OpenedDocument = {"doc": host.open(Session.of(recipe_from(arguments))).id, "play": ""}
    else:
        opened = open_document(host, what=to_open)
    with flags_in_errors(_Serving):
        service = Service(host=host, address=serving.host, port=serving.port, keep=serving.keep)
    service.keep_token()
    _show_address(service, service.url(opened["doc"], opened["play"]), arguments)
    service.run()


def _place(given: str | None) -> tuple[Path, str]:
    """Return the folder in which the page reads and writes, and what it opens: a file is opened in its own folder."""
    working_folder = Path.cwd()
    if given is None:
        return working_folder, ""
    path = Path(given)
    if path.is_dir() and not (path / "recipe.json").exists():
        return path.resolve(), ""
    name, sharp, place = given.rpartition("#")  # a map of a data set
    file = Path(name) if sharp and place.isdecimal() and not path.exists() else path
    if not file.exists() or file.resolve().is_relative_to(working_folder.resolve()):
        return working_folder, given
    target = file.resolve()
    return target.parent, target.name + (f"#{place}" if file != path else "")


def _show_address(service: Service, url: str, arguments: argparse.Namespace) -> None:
    """Print the address, and open a browser if the user can see it."""
    from rsegen.writing.programs import has_screen

    if arguments.json:
        print(json.dumps({"url": url}), flush=True)
    else:
        end = "press Ctrl-C" if arguments.keep else "close the page or press Ctrl-C"
        print(f"{url}\nThe page edits files in {service.host.folder}. To stop, {end}.", flush=True)
        print(*_maps_in(arguments.recipe), sep="", end="", flush=True)
    if service.host.read_only:
        _warn(service.host.read_only)
    if service.is_open_to_others:
        _warn("others can read the traffic, and the token in it; ssh -L is safer")
    # Over SSH the user sits at another machine, where a browser opened here would not be seen.
    if os.environ.get("SSH_CONNECTION"):
        port = service.listening_port
        tunnel = f"ssh -L {port}:localhost:{port} {user_name()}@{socket.gethostname()}"
        print(f"From your own machine: {tunnel}, then open the address there.", flush=True)
    elif not arguments.no_browser and has_screen():
        import webbrowser

        try:
            webbrowser.open(service.write_door(url).as_uri())
        except FileError as error:
            _warn(str(error))


def _warn(text: str) -> None:
    print(f"warning: {text}", file=sys.stderr, flush=True)


def _maps_in(given: str | None) -> Iterator[str]:
    """Yield the command that opens each map in a given folder of maps, a line each: the page opens none of them."""
    from rsegen.writing.target_worlds import recipe_files_in

    if given is None or not Path(given).is_dir() or Path(given, "recipe.json").exists():
        return
    maps = [file.parent for file in recipe_files_in(Path(given))]
    if maps:
        yield f"No map is open. Maps in {given}:\n"
    yield from (f"  rsegen gui {shlex.quote(str(folder))}\n" for folder in maps[:SHOWN])
    if len(maps) > SHOWN:
        yield f"  and {len(maps) - SHOWN} more\n"


@dataclass(frozen=True, kw_only=True, slots=True)
class _Page:
    """Write maps as one HTML file with a 3D view, the plan, heights, metrics and the recipe; it needs no internet."""

    output: Annotated[str, FilePath("a file", help="HTML file"), Shell(("-o", "--output"), "FILE", required=True)]
    force: Force = False


def add_view(command: Parser) -> None:
    """Add the flags of `rsegen view`."""
    command.explain(_Page.__doc__)
    add_target_flags(command, "all, to choose from on the page")
    add_flags(command.group("output"), _Page)
    add_target_recipe_flags(command)


def run_view(arguments: argparse.Namespace) -> Report:
    """Write the page of all maps."""
    from rsegen.page.view import html_path, view_all
    from rsegen.writing.store import refuse_taken_file

    path = html_path(arguments.output)
    refuse_taken_file(path, force=bool(arguments.force))
    recipes = [*maps_of_flags(arguments)]
    page = view_all(recipes)
    page.save(path, force=bool(arguments.force))
    maps, size = sum(recipe.maps for recipe in recipes), len(page.html)
    first = recipes[0]
    named = f"{first.map_name(first.first_map)}, seed {first.seed}" if maps == 1 else f"{maps} maps"
    content = {"file": str(path), "maps": maps, "bytes": size}
    return Report(lines=[f"{path}: {named}, {size:,} bytes"], content=content)
