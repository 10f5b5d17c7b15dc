"""Data that a page asks for first, and that are the same for all documents: forms, kinds, robots, formats, metrics."""

from __future__ import annotations

from typing import Any, TypedDict

from rsegen import __version__
from rsegen.measuring.catalogue import METRICS, OF_A_ROBOT, UNITS
from rsegen.page.calls import call_of_host
from rsegen.page.command_forms import DescribedCommand, command_forms
from rsegen.page.forms import Group, Kind, global_groups, kinds, metric_title
from rsegen.page.host import Host
from rsegen.page.places import names_in
from rsegen.params.capabilities import known_words
from rsegen.params.registry import summary_of_class
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import load


class Described(TypedDict):
    """An example or a format."""

    name: str
    description: str


class Titled(TypedDict):
    """A robot or a metric."""

    name: str
    title: str


class Hello(TypedDict):
    """Data that are the same for all documents."""

    version: str
    folder: str  # in which files may be read and written
    read_only: str  # why nothing can be saved in it; empty: it can
    globals: list[Group]  # the parameters of a map
    kinds: list[Kind]
    examples: list[Described]
    robots: list[Titled]
    commands: list[DescribedCommand]
    formats: list[Described]
    metrics: list[Titled]  # by which maps can be sorted


def _title_of_robot(name: str, robot: Any) -> str:
    """Return a robot's name with what it is like and its size."""
    size = " × ".join(f"{100 * side:.0f}" for side in robot.size)  # noqa: RUF001  # a page has the sign
    return f"{name}: {robot.title}, {size} cm"


@call_of_host
def hello(host: Host) -> Hello:
    """Return what is the same for all documents: forms, kinds, robots, formats, metrics that need no robot."""
    metrics = [name for name in (*UNITS, *METRICS) if name not in OF_A_ROBOT]
    robots = {name: _title_of_robot(name, robot) for name, robot in dict(known_words().get("robot", dict)()).items()}
    robots |= {name: name for name in names_in(host.folder) if name.endswith((".sdf", ".urdf", ".xacro"))}
    return {
        "version": __version__,
        "folder": str(host.folder.resolve()),
        "read_only": host.read_only,
        "globals": global_groups(),
        "kinds": kinds(),
        "examples": [{"name": name, "description": load(path).description} for name, path in EXAMPLES.items()],
        "robots": [{"name": name, "title": title} for name, title in robots.items()],
        "commands": [form.described() for form in command_forms().values()],
        "metrics": [{"name": name, "title": metric_title(name)} for name in metrics],
        "formats": [
            {"name": name, "description": summary_of_class(cls)}
            for name, cls in dict(known_words().get("formats", dict)()).items()
        ],
    }
