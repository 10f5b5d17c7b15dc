"""Every public function and class has a plain signature, and a numpydoc section that describes all parameters."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from inspect import Parameter, getdoc, isfunction, signature
from typing import Annotated, Any

import pytest

import rsegen
from rsegen.params.command import Declared, Shell, command, declared
from rsegen.params.docstrings import described, without_flags
from rsegen.params.sorts import Choice, Flag, Float, Reference


def is_called(public: Any) -> bool:
    """Return whether it is a function, or a class that is made by calling it with parameters of its own."""
    return any(map(isfunction, (public.__init__, public.__new__) if isinstance(public, type) else (public,)))  # type: ignore[misc]


CALLED = [name for name in dir(rsegen) if name in rsegen.__all__ and is_called(getattr(rsegen, name))]
DECLARING = [name for name in CALLED if is_dataclass(public := getattr(rsegen, name)) or hasattr(public, "__wrapped__")]


def described_parameters(public: Any) -> Mapping[str, tuple[str, str]]:
    """Return what numpydoc sections say of each parameter: type with default, and text in one line."""
    parts = re.split(r"^([A-Z][a-z]+)\n---+\n", getdoc(public) or "", flags=re.MULTILINE)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    text = sections.get("Parameters", "") + (sections.get("Attributes", "") if isinstance(public, type) else "")
    entries = re.findall(r"^(\S[^:\n]*?)(?: : (.*))?\n((?:(?: .*)?\n)+)", f"{text}\n", flags=re.MULTILINE)
    return {
        name.lstrip("*"): (type_, " ".join(body.split()))
        for names, type_, body in entries
        for name in names.split(", ")
    }


@pytest.mark.parametrize("name", CALLED)
def test_a_signature_has_plain_types(name: str) -> None:
    text = str(signature(getattr(rsegen, name)))
    assert "Annotated" not in text
    assert "<function" not in text
    for parameter in signature(getattr(rsegen, name)).parameters.values():
        assert parameter.annotation is not Parameter.empty
        assert "'" not in repr(parameter.annotation).replace("Literal['random']", "")  # a text in quotation marks


@pytest.mark.parametrize("name", CALLED)
def test_every_parameter_is_described(name: str) -> None:
    public = getattr(rsegen, name)
    entries = described_parameters(public)
    known = set(signature(public).parameters)
    assert known <= set(entries), f"{name}: {known - set(entries)} not described"
    for parameter in known:
        type_, text = entries[parameter]
        assert type_
        assert text.endswith("."), f"{name}.{parameter}: {text}"
    if isfunction(public):
        assert set(entries) == known


@pytest.mark.parametrize("name", DECLARING)
def test_unit_range_default_and_help_of_a_declaration_are_in_the_docstring(name: str) -> None:
    public = getattr(rsegen, name)
    entries, arguments = described_parameters(public), signature(public).parameters
    for parameter in declared(public).values():
        type_, text = entries[parameter.name]
        assert without_flags(parameter.sort.help)[1:] in text
        assert all(value in f"{type_} {text}" for value in values_of(parameter))
        default = arguments[parameter.name].default
        assert type_.endswith((f", default {default!r}", ", optional", f", default {str(default)!r}")) == (
            default is not Parameter.empty
        )


def values_of(parameter: Declared) -> Sequence[str]:
    """Return the values that a parameter takes as its declaration has them; empty if its help says them."""
    sort = parameter.sort
    return getattr(sort, "values", ()) if isinstance(sort, Choice | Flag | Reference) else (sort.describe(),)


def test_a_declared_parameter_is_put_between_those_that_a_docstring_describes() -> None:
    @command
    def brew(
        water: object,
        heat: Annotated[float | None, Float(20, 100, unit="C", help="temperature"), Shell(default="boiling")] = None,
        kind: Annotated[str, Choice(("green", "black"), help="kind of tea")] = "black",
        *,
        milk: object = None,
    ) -> int:
        """Make tea.

        Parameters
        ----------
        water : Jug
            Water
            in litres.
        milk : Jug, optional
            Milk.

        Returns
        -------
        int
            Cups.
        """
        return 0

    assert getdoc(described(brew)) == (
        "Make tea.\n\n"
        "Parameters\n----------\n"
        "water : Jug\n    Water\n    in litres.\n"
        "heat : float | None, optional\n    Temperature (20..100 C); by default boiling.\n"
        "kind : {'black', 'green'}, default 'black'\n    Kind of tea.\n"
        "milk : Jug, optional\n    Milk.\n\n"
        "Returns\n-------\nint\n    Cups."
    )
    assert str(signature(brew)) == (
        "(water: object, heat: float | None = None, kind: str = 'black', *, milk: object = None) -> int"
    )


@pytest.mark.parametrize("name", DECLARING)
def test_flags_are_parameters_in_docstrings(name: str) -> None:
    for _, text in described_parameters(getattr(rsegen, name)).values():
        assert not re.search(r"(?<![\w-])--[a-z]", text.replace("`rsegen metrics --csv`", "")), text
