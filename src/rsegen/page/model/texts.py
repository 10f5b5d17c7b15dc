"""The texts of a recipe: its file after edits, and the command line and the Python program that make the same maps.

A hand-written YAML keeps its comments, its order and its lines:

    text as read --ruamel.yaml--> tree --changed--> tree --ruamel.yaml--> text, of which only changed lines are taken

ruamel.yaml writes a tree with its comments, but not every line as it was: quotes and blanks may differ. So the tree is
written before and after the changes, and the difference of these two is what is changed in the text as read.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable, Sequence
from difflib import SequenceMatcher
from io import StringIO
from pathlib import Path
from typing import Any

from rsegen.errors import RsegenError
from rsegen.page.model.session import Entry, draft_of
from rsegen.params.registry import is_own
from rsegen.params.sorts import Json, parameters
from rsegen.recipe.codec import decode, row_text, to_json
from rsegen.recipe.map_design import without_derived_keys
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import parse_yaml, to_yaml

_LONGEST = 500_000
"""Letters of a YAML that is edited: ruamel.yaml takes some ten seconds for them. A longer one is written anew."""


def text_after(before: str, recipe: Recipe, suffix: str) -> str:
    """Return the text of a recipe for a file that had another one before, or none; JSON if the suffix is .json."""
    if "\r\n" in before:
        return text_after(before.replace("\r\n", "\n"), recipe, suffix).replace("\n", "\r\n")
    if suffix.lower() == ".json":
        return _json_after(before, recipe)
    if before.strip() and len(before) <= _LONGEST:
        from ruamel.yaml.error import YAMLError

        try:
            edited = _yaml_after(before, recipe)
        except (RsegenError, YAMLError, RecursionError, ValueError, TypeError, AttributeError, KeyError, IndexError):
            edited = None  # an unusual file, such as one with aliases: it is written anew, and nothing is lost
        if edited is not None:
            return edited
    return to_yaml(recipe)


def _json_after(before: str, recipe: Recipe) -> str:
    """Return the JSON of a recipe, which keeps the schema that its file names for editors."""
    text = to_json(recipe, derived_keys=False)
    try:
        schema = json.loads(before)["$schema"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return text
    return text.replace("{\n", '{\n  "$schema": ' + json.dumps(schema) + ",\n", 1)


def _yaml_after(before: str, recipe: Recipe) -> str | None:
    """Return a YAML with the values of a recipe in place of those that differ; None if it cannot be edited so."""
    start = decode(parse_yaml(before, Path()))
    unchanged = _written(before, lambda tree: None)

    def edit(tree: Any) -> None:
        _set_values(tree, start, recipe)
        _set_rows(tree, start, recipe)

    def edit_with_keys(tree: Any) -> None:
        edit(tree)  # keys that follow from rows may depend on their place in the list
        for node, obstacle in zip(tree.get("obstacles") or (), recipe.obstacles, strict=True):
            node["key"] = obstacle.key

    for change in (edit, edit_with_keys):
        changed = _written(before, change)
        for text in (_patched(before, unchanged, changed), changed):
            if _says(text, recipe):
                return text
    return None


def _written(text: str, change: Callable[[Any], None]) -> str:
    """Return a YAML as ruamel.yaml writes it after a change of its tree, which it can write once only."""
    from ruamel.yaml import YAML
    from ruamel.yaml.emitter import RoundTripEmitter

    class Emitter(RoundTripEmitter):
        """The emitter of ruamel.yaml, which forgets a line break after a row `- {...}  # with a comment`."""

        def expect_flow_mapping_key(self) -> None:
            super().expect_flow_mapping_key()
            if not self.flow_context:
                self.no_newline = False

    tool = YAML(typ="rt", pure=True)
    tool.Emitter = Emitter
    tool.preserve_quotes = True
    tool.width = 120
    # ruamel.yaml has one indentation of lists for the whole file: that of the first list is kept.
    dashes = re.search(r"^( *)- ", text, re.MULTILINE)
    before_dash = len(dashes[1]) if dashes else 0
    tool.indent(mapping=2, sequence=before_dash + 2, offset=before_dash)
    tree, stream = tool.load(text), StringIO()
    change(tree)
    tool.dump(tree, stream)
    return stream.getvalue()


def _says(text: str, recipe: Recipe) -> bool:
    """Return whether a YAML is this recipe, keys of random streams included."""
    try:
        return decode(parse_yaml(text, Path())) == recipe
    except RsegenError:
        return False


def _set_values(tree: Any, before: Recipe, recipe: Recipe) -> None:
    """Change the global parameters of a tree that differ; new ones come before the obstacles."""
    old, new, entry = before.values(), recipe.values(), recipe.entry()
    for name in {**old, **new}:
        if name not in new:
            tree.pop(name, None)
        elif name not in old or old[name] != new[name] or (name == "seed" and name not in tree):
            if name in tree:
                tree[name] = _node(new[name])
            elif name in entry:
                place = list(tree).index("obstacles") if "obstacles" in tree else len(tree)
                tree.insert(place, name, _node(new[name]))


def _set_rows(tree: Any, before: Recipe, recipe: Recipe) -> None:
    """Give a tree the rows of a recipe; rows that stay keep their comments."""
    from ruamel.yaml.comments import CommentedSeq

    rows = tree.get("obstacles")
    if not recipe.obstacles:
        tree.pop("obstacles", None)
        return
    if not rows:
        rows = tree["obstacles"] = CommentedSeq()
    old_places = _rows_before(rows, before, recipe)
    entries = [obstacle.entry() for obstacle in without_derived_keys(recipe.obstacles)]
    # A row that stays keeps its node, in which most of its comments are; those between rows are moved with it.
    nodes, comments = [], {}
    block = not any(row.fa.flow_style() for row in rows)
    for place, obstacle in enumerate(recipe.obstacles):
        old_place, entry = old_places[place], entries[place]
        if old_place is None:
            nodes.append(_row(entry, block=block and bool(rows)))
            continue
        node = rows[old_place]
        _set_row(node, before.obstacles[old_place].entry(), obstacle.entry() if "key" in node else entry)
        nodes.append(node)
        if old_place in rows.ca.items:
            comments[place] = rows.ca.items[old_place]
    if len(nodes) == len(rows) and all(old is new for old, new in zip(rows, nodes, strict=True)):
        return
    between_rows = rows.ca.items
    between_rows.clear()
    rows[:] = []
    rows.extend(nodes)
    between_rows.update(comments)


def _rows_before(rows: Any, before: Recipe, recipe: Recipe) -> list[int | None]:
    """Return which row of a file each obstacle of a recipe was; None for a new one.

    It is known by its key. A row without one in the file has another key with each change: it is taken for the next row
    of its kind that is not found.
    """
    by_key = {obstacle.key: place for place, obstacle in enumerate(before.obstacles)}
    old_places = [by_key.get(obstacle.key) for obstacle in recipe.obstacles]
    left = [place for place in sorted({*by_key.values()} - {*old_places}) if "key" not in rows[place]]
    for place, obstacle in enumerate(recipe.obstacles):
        alike = [old for old in left if before.obstacles[old].kind == obstacle.kind]
        if old_places[place] is None and alike:
            old_places[place] = alike[0]
            left.remove(alike[0])
    return old_places


def _set_row(node: Any, before: dict[str, Json], after: dict[str, Json]) -> None:
    """Change the parameters of a row that differ; it gets a key if it has one that does not follow from them."""
    differ = {name for name in {**before, **after} if before.get(name) != after.get(name)}
    for name in [name for name in before if name not in after]:
        node.pop(name, None)
    for name, value in after.items():
        if name in differ or (name == "key" and name not in node):
            node[name] = _node(value)


def _row(entry: dict[str, Json], *, block: bool) -> Any:
    """Return a new row: over several lines as the others, or on one."""
    from ruamel.yaml.comments import CommentedMap

    row = CommentedMap({name: _node(value) for name, value in entry.items()})
    if not block:
        row.fa.set_flow_style()
    return row


def _node(value: Json) -> Any:
    """Return a value as a node: lists on one line, as people write places; texts of several lines of a matrix apart."""
    if not isinstance(value, list):
        return value
    from ruamel.yaml.comments import CommentedSeq

    node = CommentedSeq([_node(part) for part in value])
    if not any(isinstance(part, str) and " " in part for part in value):
        node.fa.set_flow_style()
    return node


def _patched(text: str, unchanged: str, changed: str) -> str:
    """Return a text with the changes from `unchanged` to `changed`, of which the first has the same content as it."""
    lines, old, new = (version.splitlines(keepends=True) for version in (text, unchanged, changed))
    places = _places(old, lines)
    result: list[str] = []
    at = 0
    for tag, low, high, start, stop in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag == "equal":
            continue
        result += [*lines[at : places[low]], *new[start:stop]]
        at = places[high]
    if result and not result[-1].endswith("\n"):
        result[-1] += "\n"
    return "".join([*result, *lines[at:]])


def _places(old: Sequence[str], lines: Sequence[str]) -> list[int]:
    """Return the line of `lines` at which each line of `old` begins, and at last the one where it ends."""
    places = [0] * (len(old) + 1)
    for tag, low, high, start, stop in SequenceMatcher(None, old, lines, autojunk=False).get_opcodes():
        for line in range(low, high):
            # Lines that are written otherwise belong together one by one, as far as they go.
            places[line] = start + (line - low if tag == "equal" else min(line - low, stop - start))
    places[len(old)] = len(lines)
    return places


def command_line(recipe: Recipe, folder: str) -> str:
    """Return the command that generates the maps of a recipe."""
    return shlex.join(["rsegen", "generate", "-o", folder, *recipe_flags(recipe)])


def recipe_flags(recipe: Recipe) -> list[str]:
    """Return the flags that make a recipe, in words: one for each parameter that is not its default, and obstacle."""
    words = []
    for name, value in _stated(recipe).items():
        words += [f"--{name.replace('_', '-')}", parameters(Recipe)[name].format(value)]
    for obstacle in without_derived_keys(recipe.obstacles):
        words += ["--obstacle", row_text(obstacle)]
    return words


def stated_names(recipe: Recipe) -> set[str]:
    """Return the names of the parameters for which `recipe_flags` has flags."""
    return {*_stated(recipe), *(["obstacle"] if recipe.obstacles else [])}


def python_code(recipe: Recipe, folder: str) -> str:
    """Return the program that generates the maps of a recipe."""
    imports = set[str]()
    calls = []
    for obstacle in without_derived_keys(recipe.obstacles):
        cls, entry = type(obstacle), obstacle.entry()
        name = f"rsegen.{cls.__name__}"
        if not is_own(cls):
            name = cls.__name__
            imports.add(f"from {cls.__module__} import {name}")
        calls.append(f"        {name}({', '.join(_arguments({key: entry[key] for key in entry if key != 'kind'}))}),")
    parameters = [f"    {argument}," for argument in _arguments(_stated(recipe))]
    lines = ["import rsegen", *sorted(imports), "", "recipe = rsegen.Recipe(", *parameters, "    obstacles=[", *calls]
    return "\n".join([*lines, "    ],", ")", f"rsegen.generate(recipe, {folder!r})", ""])


def _stated(recipe: Recipe) -> Entry:
    """Return the seed, and the global parameters that differ from their defaults."""
    values, default = draft_of(recipe).values, draft_of(Recipe(seed=0)).values
    return {name: value for name, value in values.items() if value != default.get(name) or name == "seed"}


def _arguments(values: Entry) -> list[str]:
    return [f"{name}={tuple(value) if isinstance(value, list) else value!r}" for name, value in values.items()]
