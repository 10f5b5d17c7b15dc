"""Answers of the server are of the types of which the page's protocol.ts is made."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypedDict, Union, get_args, get_origin, get_type_hints, is_typeddict

import pytest

import rsegen
from docs import protocol
from rsegen.page import calls
from rsegen.page.calls import load_calls
from rsegen.page.host import Event, Host, Listener
from rsegen.page.model.actions import actions
from rsegen.page.server import answer
from tests.page.test_files import drive

RECIPE = rsegen.Recipe(
    name="field", chunk_size=3, boundary="divided", unit_cm=5, seed=3, obstacles=[rsegen.Random(levels=4)], maps=2
)
OF_ROBOT = {"index": 0, "robot": "burger"}
ASKED: Mapping[str, Mapping[str, Any]] = {
    "hello": {},
    "files": {},
    "playback": {"path": "a"},
    "open": {"what": "field.yaml"},
    "state": {},
    "edit": {"actions": [{"do": "add", "entry": {"kind": "peak", "levels": 3}}]},
    "ghost": {"entry": {"kind": "pit", "levels": 2}},
    "scene": {},
    "results": {},
    "texts": {},
    "variants": {"count": 2},
    "maps": {"first": 0, "count": 2, "by": "steps.rms"},
    "measure": OF_ROBOT,
    "robot": {"robot": "jackal"},
    "pose": OF_ROBOT | {"x": 0.0, "y": 0.0, "heading": 0.0},
    "tilt": OF_ROBOT | {"heading": 0.0},
    "reach": OF_ROBOT,
    "crossing": OF_ROBOT,
    "way": OF_ROBOT | {"start": [-1, 0], "goal": [1, 0]},
    "stop": {"of": "reach"},
    "save": {},
    "run": {"command": "metrics", "values": {}},
    "jobs": {},
    "rating": {"path": "rate"},
    "drive_trial": {"path": "rate", "judge": "the prediction by its poses", "trial": 0},
    "cancel": {"job": 1},
    "shell_line": {"command": "metrics", "values": {}},
    "example_maps": {},
    "made_maps": {"paths": ["field.yaml"]},
    "show_folder": {"path": "field.yaml"},
    "reload": {},
    "close": {},
}
"""Arguments with which each call is tried, in an order in which all of them can be answered."""


def fits(value: Any, hint: Any) -> bool:
    """Return whether a JSON value is of a type."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return fits(value, parts[1] if isinstance(parts[1], type) else parts[0])
    if origin in (Union, UnionType):
        return any(fits(value, part) for part in parts)
    if origin is Literal:
        return value in parts
    if origin in (list, tuple):
        kinds = parts if origin is tuple and Ellipsis not in parts else (parts[0],) * len(value)
        return isinstance(value, list) and len(value) == len(kinds) and all(map(fits, value, kinds))
    if is_typeddict(hint) or is_dataclass(hint):
        hints = get_type_hints(hint, include_extras=True)
        needed = getattr(hint, "__required_keys__", hints)
        is_whole = isinstance(value, dict) and set(needed) <= set(value) <= set(hints)
        return is_whole and all(fits(value[name], hints[name]) for name in value)
    plain: Mapping[Any, Any] = {Any: object, float: (int, float), dict: dict, Mapping: dict}
    return isinstance(value, plain.get(origin or hint, hint))


@pytest.fixture
def host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Host]:
    rsegen.save(RECIPE, tmp_path / "field.yaml")
    drive(tmp_path / "a", [[0.1 * at, 0.01 * at, 0, 0, 0, 0, 0] for at in range(40)], crossed=3.0)
    rsegen.rate("burger", seed=7, trials=8, by="prediction", output=tmp_path / "rate")
    load_calls()
    host = Host(folder=tmp_path)
    monkeypatch.setenv("PATH", "")  # no file manager is opened
    yield host
    host.close()


@pytest.mark.slow
def test_answers_and_events_are_of_their_types(host: Host) -> None:
    doc, events = answer(host, "open", {"what": "field.yaml"})["doc"], list[Any]()
    host.opened(doc).add(Listener(page="p", send=events.append))
    for name, arguments in ASKED.items():
        function: Callable[..., Any] = {**calls.OF_HOST, **calls.OF_DOCUMENT}[name]
        of = {"doc": doc} if name in calls.OF_DOCUMENT or "doc" in calls.keywords(function)[0] else {}
        answered = json.loads(json.dumps(answer(host, name, {"page": "p", **of, **arguments})))
        assert fits(answered, get_type_hints(function, include_extras=True)["return"]), (name, answered)
    assert {event["event"] for event in events} >= {"state", "progress", "job"}
    assert all(fits(json.loads(json.dumps(event)), Event) for event in events)
    assert not fits({"event": "state", "page": "p"}, Event)


def test_every_call_is_tried() -> None:
    load_calls()
    assert set(ASKED) == {*calls.OF_HOST, *calls.OF_DOCUMENT}


def test_every_call_and_action_is_in_the_protocol() -> None:
    text = protocol.protocol()
    assert all(f"\n  {name}: {{ args: " in text for name in (*calls.OF_HOST, *calls.OF_DOCUMENT))
    assert all(f'{{ do: "{name}"' in text for name in actions())
    assert protocol.FILE.read_text("utf-8") == text


def test_types_are_written_as_typescript_has_them() -> None:
    types = protocol.Interfaces()
    assert types.type_of(list[int | None]) == "(number | null)[]"
    assert types.type_of(tuple[str, float]) == "[string, number]"
    assert types.type_of(tuple[bool, ...]) == "boolean[]"
    assert types.type_of(dict[str, Any]) == "{ [name: string]: Json }"
    assert types.type_of(Literal["a", "b"]) == '"a" | "b"'
    assert types.type_of(Annotated[int, "number | bigint"]) == "number | bigint"
    with pytest.raises(TypeError, match="has no type in TypeScript"):
        types.type_of(bytes)


def test_two_classes_of_one_name_are_refused() -> None:
    types = protocol.Interfaces()
    types.type_of(calls.Failure)

    class Failure(TypedDict):
        text: str

    with pytest.raises(TypeError, match="have one name"):
        types.type_of(Failure)
