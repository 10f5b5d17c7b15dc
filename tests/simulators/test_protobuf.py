"""The bytes of messages, judged by protobuf's own library with the same tables of fields (decision 16)."""

from __future__ import annotations

import random
from contextlib import suppress
from math import isnan
from typing import Any

import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import DecodeError
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen.errors import NoMessage
from rsegen.simulators.wire import CLASSIC, MessageTypes
from tests.fuzz.damage import damaged_bytes
from tests.simulators.test_messages import EVERY, message_of

Field = descriptor_pb2.FieldDescriptorProto
PLAIN: dict[Any, Any] = {
    int: Field.TYPE_INT64,
    float: Field.TYPE_DOUBLE,
    bool: Field.TYPE_BOOL,
    str: Field.TYPE_BYTES,
    bytes: Field.TYPE_BYTES,
}
"""Types of fields; texts are bytes, as the library refuses those that are no Unicode."""


def classes(types: MessageTypes, package: str) -> dict[str, Any]:
    """The library's own class of each message type."""
    file = descriptor_pb2.FileDescriptorProto(name=f"{package}.proto", package=package, syntax="proto2")
    for type_name, fields in types.types.items():
        message = file.message_type.add(name=type_name)
        for name, (number, kind) in fields.items():
            is_list = isinstance(kind, list)
            one = kind[0] if isinstance(kind, list) else kind
            label = Field.LABEL_REPEATED if is_list else Field.LABEL_OPTIONAL
            field = message.field.add(name=name, number=number, label=label)
            field.type = PLAIN.get(one, Field.TYPE_MESSAGE)
            if one not in PLAIN:
                field.type_name = f".{package}.{one}"
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    names = {name: pool.FindMessageTypeByName(f"{package}.{name}") for name in types.types}
    return {name: message_factory.GetMessageClass(found) for name, found in names.items()}


CLASSES = {
    id(types): classes(types, f"judge{at}") for at, types in enumerate({id(own): own for own, _ in EVERY}.values())
}


def plain(message: Any) -> dict[str, Any]:
    """The fields of a message of the library that are set."""
    return {field.name: _plain(value) for field, value in message.ListFields()}


def _plain(value: Any) -> Any:
    if hasattr(value, "ListFields"):
        return plain(value)
    return value if isinstance(value, (int, float, bytes)) else [_plain(one) for one in value]


def alike(message: Any) -> Any:
    """A message in one order, with bytes as texts: as ours gives those, and as a NaN is like another."""
    if isinstance(message, dict):
        return {name: alike(value) for name, value in sorted(message.items())}
    if isinstance(message, list):
        return [alike(value) for value in message]
    if isinstance(message, float) and isnan(message):
        return "nan"
    return message.decode(errors="replace") if isinstance(message, bytes) else message


@pytest.mark.slow
@pytest.mark.parametrize(("types", "type_name"), EVERY, ids=[name for _, name in EVERY])
@settings(max_examples=10)
@given(data=st.data())
def test_the_library_reads_what_we_write_and_we_read_what_it_writes(
    types: MessageTypes, type_name: str, data: st.DataObject
) -> None:
    message = data.draw(message_of(types, type_name))
    read = CLASSES[id(types)][type_name].FromString(types.encode(type_name, message))
    assert alike(plain(read)) == alike(message)
    assert types.decode(type_name, read.SerializeToString()) == message


@pytest.mark.slow
@pytest.mark.parametrize(("types", "type_name"), EVERY, ids=[name for _, name in EVERY])
@settings(max_examples=25)
@given(data=st.data(), seed=st.integers(0, 2**32))
def test_of_damaged_bytes_both_read_the_same_or_one_refuses(
    types: MessageTypes, type_name: str, data: st.DataObject, seed: int
) -> None:
    """The library passes over fields of another kind, and over groups, which Gazebo has not; we refuse the message."""
    message = data.draw(message_of(types, type_name))
    content = damaged_bytes(random.Random(seed), types.encode(type_name, message))  # noqa: S311  # no secret
    with suppress(NoMessage, DecodeError):
        ours = types.decode(type_name, content)
        assert alike(ours) == alike(plain(CLASSES[id(types)][type_name].FromString(content)))


def test_a_message_in_parts_has_the_fields_of_all_of_them() -> None:
    parts = ({"name": "a", "position": {"x": 1.0}}, {"id": 2, "position": {"y": 3.0}})
    content = b"".join(CLASSIC.encode("Factory", {"pose": part}) for part in parts)
    whole = {"pose": {"name": "a", "id": 2, "position": {"x": 1.0, "y": 3.0}}}
    assert CLASSIC.decode("Factory", content) == whole
    assert alike(plain(CLASSES[id(CLASSIC)]["Factory"].FromString(content)))["pose"] == whole["pose"]
