"""Forms of the commands that pages run as jobs: the fields of each, and the command line for values of these.

    parser of a command --CommandForm--> fields, and values --> arguments

A command line is the form of its command: each flag, and each argument besides the recipe, is a field. A flag that is
declared has its sort, bounds and unit; any other takes a text, or is a switch.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypedDict

from rsegen.cli.command_line import parsers
from rsegen.cli.flags import RECIPE
from rsegen.errors import FileError, ParameterError, UnknownName, refuse_unknown
from rsegen.page.forms import BASIC, Field, Schema, field
from rsegen.page.places import Places
from rsegen.params.capabilities import Command, commands
from rsegen.params.command import Declared, declared
from rsegen.params.sorts import FilePath, Flag, Json, Text, plain
from rsegen.recipe.recipe import Recipe

_OF_A_SHELL = ("gui", "info", "examples", "obstacles", "schema", "completion", "man")
"""The commands that a page does not run: it is one of them, and shows what others print."""

_RARE = frozenset({"workers", "scheduler", "sync", "resume", "timeout", "wheels", "tracks", "size", "speed", "turn"})
"""Fields of commands that a form shows only when it is asked for more."""

_LEFT_OUT = frozenset({"help", "json", "quiet", "progress", "plugin", "list", "force", "dry_run", "verify", "rebuild"})
"""Flags that a page gives itself, and those that do something else instead."""

_LEFT_OUT_OF = {"metrics": frozenset({"csv"})}
"""A table as CSV is another form of a report than JSON, which a page reads."""

_RECIPES = ("recipe", "recipes", "target")
"""Names of the argument for which a document stands."""

_INPUTS = ("file", "clouds", "paths")
"""Names of the arguments that are files to read."""

_WORDS_OR_FILES = ("robot", "plan", "inventory", "crossable_by")
"""Names of the parameters that are a word or a file."""

_TITLES_OF = {("rate", "by"): "Judge"}
"""Titles of parameters of single commands."""


class DescribedCommand(TypedDict):
    """A command that may be run."""

    name: str
    title: str  # in a menu: "Drive over a map"
    help: str
    group: str  # what it is for: "drive a robot"
    target: Literal["recipe", "none"]
    fields: list[Field]
    output: Literal["folder", "file", "none"]
    output_help: str
    output_required: bool


@dataclass(frozen=True, kw_only=True)
class CommandForm:
    """The form of a command.

    fields: the actions of its parser that a form has, by name; output: the action of what it writes, if any
    takes_recipe: whether a document stands for one of its arguments
    recipe_flags: the parameters of a recipe that it has flags for, obstacles among them
    """

    name: str
    title: str
    help: str
    group: str
    fields: Mapping[str, argparse.Action]
    output: argparse.Action | None
    takes_recipe: bool
    recipe_flags: frozenset[str]
    can_replace: bool

    @classmethod
    def of(cls, known: Command, parser: Any) -> CommandForm:
        """Return the form of a command from its declaration and its parser."""
        parser.describe_flags()
        # A document stands for the recipe, so flags for recipes are out, as are flags that the page itself decides.
        name = known.name
        actions = {action.dest: action for action in parser.actions}
        arguments = {action.dest for action in parser.actions if not action.option_strings}
        takes_recipe = name == "compare" or not arguments.isdisjoint(_RECIPES)
        of_recipe = {action for part in parser.groups if part.title == RECIPE for action in part.actions}
        output = next((action for action in actions.values() if "--output" in action.option_strings), None)
        left_out = {*_LEFT_OUT, *_LEFT_OUT_OF.get(name, ()), *(_RECIPES if takes_recipe else ())}
        shown = {
            dest: action
            for dest, action in actions.items()
            if dest not in left_out
            and action is not output
            # A document has its own parameters; what makes a new recipe may be given some, but no obstacles as texts.
            and not (action in of_recipe and (takes_recipe or not hasattr(action, "declared")))
        }
        return cls(
            name=name,
            title=known.title or name.capitalize(),
            help=known.help,
            group=known.group,
            fields=shown,
            output=output,
            takes_recipe=takes_recipe,
            recipe_flags=frozenset(action.dest for action in of_recipe),
            can_replace="force" in actions,
        )

    @property
    def needs_output(self) -> bool:
        """Return whether it cannot do without a file or folder to write."""
        # For a data set one of two flags is needed, --output and --verify, and the other is no field.
        return self.output is not None and (self.output.required or self.name == "dataset")

    def described(self) -> DescribedCommand:
        """Return it as pages have it."""
        return {
            "name": self.name,
            "title": self.title,
            "help": self.help,
            "group": self.group,
            "target": "recipe" if self.takes_recipe else "none",
            "fields": [self._described(action) for action in self.fields.values()],
            "output": self._output,
            "output_help": (self.output.help or "").removesuffix(" (required)") if self.output else "",
            "output_required": self.needs_output,
        }

    @property
    def _output(self) -> Literal["folder", "file", "none"]:
        if self.output is None:
            return "none"
        sort = getattr(self.output, "declared", None) and self.output.declared.sort  # type: ignore[attr-defined]
        return "file" if isinstance(sort, FilePath) and sort.meaning != FilePath.meaning else "folder"

    def _described(self, action: argparse.Action) -> Field:
        """Return an action of the parser as a field; one that is not declared is a text or a switch of its help."""
        parameter = _declaration(action)
        basic = action.dest not in _RARE and (action.dest not in declared(Recipe) or action.dest in BASIC)
        made = field(parameter, basic=basic)
        made["title"] = _TITLES_OF.get((self.name, action.dest), made["title"])
        if action.nargs == 0:
            # The help of a flag such as --no-contacts says what happens without it, and a switch is on by default.
            switched_on = parameter.sort.help or made["help"].removeprefix("do not ")
            text = switched_on if made["default"] else made["help"]
            made = {**made, "schema": {"type": "boolean"}, "default": bool(made["default"]), "help": text}
        if action.nargs == "+":
            made = {**made, "schema": {"type": "array", "items": made["schema"], "minItems": 1}}
        if action.required:
            made["missing"] = _missing(made)
        return {**made, "required": action.required}

    def arguments(self, values: Mapping[str, Json], places: Places) -> tuple[list[str], list[str]]:
        """Return the flags and the other arguments for values by name; a ParameterError if one of them is wrong.

        places: in which all files are that are read or written
        """
        refuse_unknown(f"parameter of {self.name}", values, self.fields)
        flags: list[str] = []
        others: list[str] = []
        for name, action in self.fields.items():
            value = values.get(name)
            if value is None or value == []:
                if action.required:
                    raise ParameterError(name, self._described(action)["missing"])
            # A switch is written only if it differs from its default; the last of its flags is the one that says so.
            elif action.nargs == 0:
                is_on = _declaration(action).default is True
                flags += [action.option_strings[-1]] if Flag().check(name, value) != is_on else []
            elif action.option_strings:
                flags += [f"{action.option_strings[-1]}={text}" for text in _texts(action, value, places)]
            else:
                others += _texts(action, value, places)
        return flags, others


def _declaration(action: argparse.Action) -> Declared:
    """Return the declaration of an action; of one that has none, any text."""
    text = (action.help or "").replace("%%", "%")
    undeclared = Declared(action.dest, Text(r"[^\x00-\x1f]+", "a text", help=text), None)
    return getattr(action, "declared", undeclared)


def _texts(action: argparse.Action, value: Json, places: Places) -> Iterator[str]:
    """Yield a value as texts of a command line: several for what may be repeated, else one."""
    parameter: Declared | None = getattr(action, "declared", None)
    name = action.dest
    if parameter is None or hasattr(parameter.sort, "repeats"):
        texts = [str(text) for text in (value if isinstance(value, list) else [value])]
        for text in texts:
            _refuse_unusable(name, text)
        if parameter:
            parameter.sort.check(name, parameter.sort.parse(texts))  # type: ignore[arg-type]  # of all texts
        yield from (_placed(name, text, places) for text in texts)
        return
    if isinstance(value, str):
        value = _placed(name, value, places)  # before it is checked, which may read it
    checked = parameter.sort.check(name, value)
    listed = value if isinstance(value, list) or not isinstance(checked, tuple) else [value]
    # Without the endings of whole numbers that are floats in JSON.
    text = parameter.sort.format([plain(value) for value in listed] if isinstance(listed, list) else plain(listed))
    _refuse_unusable(name, text)
    yield _inside(name, text, places) if isinstance(parameter.sort, FilePath) else text


def _refuse_unusable(name: str, text: str) -> None:
    if not text or "\0" in text or not text.isprintable():
        raise ParameterError(name, f"{text!r} is not a text that a command line takes")


def _placed(name: str, text: str, places: Places) -> str:
    """Return a text that may name a file; a ParameterError if that file is elsewhere."""
    if name in _INPUTS:
        return _inside(name, text, places)
    return places.refuse_outside(name, text) if name in _WORDS_OR_FILES else text


def _inside(name: str, text: str, places: Places) -> str:
    try:
        return str(places.relative(places.inside(text)))
    except FileError as error:
        raise ParameterError(name, str(error)) from None


@cache
def command_forms() -> Mapping[str, CommandForm]:
    """Return the form of every command that a page may run, by its name."""
    return {name: CommandForm.of(commands()[name], own) for name, own in parsers() if name not in _OF_A_SHELL}


def command_form(name: str) -> CommandForm:
    """Return the form of a command; an UnknownName, which lists the commands, for another name."""
    if name not in command_forms():
        raise UnknownName.among("command", "command", name, command_forms())
    return command_forms()[name]


def _missing(made: Field) -> str:
    """Return what to say where a field that is needed is empty."""
    name, schema = made["title"].lower(), made["schema"]
    items = schema.get("items", {})
    if schema.get("type") == "array":
        verb = "Choose" if _has_words(items) else "Enter the name of"
        return f"{verb} at least one {name.removesuffix('s')}."
    article = "an" if name[0] in "aeio" else "a"
    return f"{'Choose' if _has_words(schema) else 'Enter the name of'} {article} {name}."


def _has_words(schema: Schema) -> bool:
    return "enum" in schema or any("enum" in part for part in schema.get("anyOf", []))
