"""Messages of both Gazebos as bytes and as the text of `gz topic`."""

from __future__ import annotations

import re
import select
import socket
import sys
from contextlib import suppress
from dataclasses import astuple
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rsegen.errors import NoMessage, NothingRuns, SimulatorFailed, shown
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.classic_transport import transport_client
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Pose
from rsegen.simulators.sim_transport import TOPICS, Discovery, Event, interfaces
from rsegen.simulators.sim_transport import transport_client as transport_client_of_sim
from rsegen.simulators.wire import CLASSIC, SIM, MessageTypes, parse_text, pose_message, pose_of

PLAIN: dict[object, st.SearchStrategy[Any]] = {
    int: st.integers(-(2**31), 2**31 - 1),
    float: st.floats(allow_nan=False),
    bool: st.booleans(),
    str: st.text(),
    bytes: st.binary(),
}


def value_of(types: MessageTypes, kind: Any) -> st.SearchStrategy[Any]:
    if isinstance(kind, list):
        return st.lists(value_of(types, kind[0]), min_size=1, max_size=3)
    return PLAIN[kind] if kind in PLAIN else message_of(types, str(kind))


def message_of(types: MessageTypes, type_name: str) -> st.SearchStrategy[dict[str, Any]]:
    optional = {name: value_of(types, kind) for name, (_, kind) in types.types[type_name].items()}
    return st.fixed_dictionaries({}, optional=optional)


EVERY = [(types, name) for types in (CLASSIC, SIM) for name in types.types]


@pytest.mark.slow
@pytest.mark.parametrize(("types", "type_name"), EVERY, ids=[name for _, name in EVERY])
@settings(max_examples=20)
@given(data=st.data())
def test_every_message_comes_back_from_its_bytes(types: MessageTypes, type_name: str, data: st.DataObject) -> None:
    message = data.draw(message_of(types, type_name))
    assert types.decode(type_name, types.encode(type_name, message)) == message


def test_messages_have_the_bytes_of_protocol_buffers() -> None:
    assert CLASSIC.encode("Time", {"sec": 300, "nsec": 1}) == bytes([0x08, 0xAC, 0x02, 0x10, 0x01])
    assert CLASSIC.encode("GzString", {"data": "rse"}) == b"\x0a\x03rse"
    assert CLASSIC.encode("Vector3d", {"x": 1.0}) == b"\x09" + b"\0" * 6 + b"\xf0\x3f"


def test_a_field_that_is_not_known_is_skipped() -> None:
    content = CLASSIC.encode("Model", {"name": "one", "id": 3, "pose": {"position": {"z": 2.0}}})
    assert CLASSIC.decode("GzString", content) == {"data": "one"}


def test_a_text_that_is_not_in_utf_8_is_read_as_far_as_it_is() -> None:
    """Names in worlds of others may be in Latin-1."""
    assert CLASSIC.decode("GzString", b"\x0a\x04caf\xe9") == {"data": "caf\ufffd"}


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_a_pose_in_a_message_has_the_quaternion_of_its_angles(roll: float, pitch: float, yaw: float) -> None:
    pose = Pose(x=1, y=-2, z=0.5, roll=roll, pitch=pitch, yaw=yaw)
    message = pose_message(pose)
    own = np.array([message["orientation"][name] for name in "xyzw"])
    turn = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat()  # about fixed axes, as SDF has them
    assert abs(float(own @ turn)) == pytest.approx(1, abs=1e-9)
    assert astuple(pose_of(message)) == pytest.approx(astuple(pose), abs=1e-6)


@given(v=st.floats(-0.2, 0.2), w=st.floats(-2, 2))
def test_a_command_for_a_robot_is_a_message(v: float, w: float) -> None:
    command = robot_of_kind("burger").command("burger", v, w)
    type_name = command.type.rpartition(".")[2]
    message = CLASSIC.decode(type_name, CLASSIC.encode(type_name, parse_text(command.text)))
    assert message["position"]["x"] == pytest.approx(v, abs=1e-6)


def test_a_server_that_does_not_answer_is_reported() -> None:
    with (
        pytest.raises(NothingRuns, match=r"no answer from 127.0.0.1:1 \(Connection refused\)"),
        transport_client(("127.0.0.1", 1), Patience()),
    ):
        pass


@given(content=st.binary(max_size=80))
def test_bytes_that_are_no_message_raise_one_of_the_errors_that_are_named(content: bytes) -> None:
    for types, name in EVERY:
        with suppress(NoMessage):
            assert isinstance(types.decode(name, content), dict)


@pytest.mark.parametrize(("types", "type_name"), EVERY, ids=[name for _, name in EVERY])
@pytest.mark.parametrize("wire_type", range(8))
def test_no_length_and_no_number_hangs_the_decoder(types: MessageTypes, type_name: str, wire_type: int) -> None:
    """A length of -11 once led back to its own beginning; a number without end has no value."""
    backwards, endless = b"\xf5" + b"\xff" * 8 + b"\x01", b"\xff" * 40
    for number in (1, 2, 15, 400):
        for value in (backwards, endless, b"\x80", b"\x7f", b""):
            key = number << 3 | wire_type
            content = (bytes([key]) if key < 128 else bytes([key & 127 | 128, key >> 7])) + value
            with suppress(NoMessage):
                assert isinstance(types.decode(type_name, content), dict)


@pytest.mark.parametrize("types", [CLASSIC, SIM])
def test_a_type_that_is_not_known_is_no_message(types: MessageTypes) -> None:
    """A server of Gazebo Sim names the type of its response itself."""
    for name in ("B}olean", "", "a\x1b"):
        with pytest.raises(NoMessage, match=f"^a simulator sent a message of the type {re.escape(shown(name))}, which"):
            types.decode(name, b"")


def test_a_field_that_is_longer_than_its_message_is_refused() -> None:
    for content in (b"\x0a\x05rse", b"\x0a\xff\xff\xff\xff\x0f", b"\x0b", b"\x0d\x01"):
        with pytest.raises(NoMessage, match="a field of"):
            CLASSIC.decode("GzString", content)


@pytest.mark.parametrize("address", ["10.9.9.9", "here", "", "256.1.1.1", "127.0.0.5"])
def test_an_address_that_this_computer_has_not_is_127_0_0_1(address: str) -> None:
    (found, *others) = interfaces({"IGN_IP": address})
    assert found == (address if address.startswith("127.") else "127.0.0.1") or not address
    assert bool(others) == (not address)
    with (
        transport_client_of_sim({"IGN_IP": address, "GZ_DISCOVERY_MSG_PORT": "many"}, Patience()) as client,
        pytest.raises(SimulatorFailed, match="no server offers /nothing"),
    ):
        client.offers("/nothing", Patience(seconds=0.3))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a socket cannot be bound to a group")
@pytest.mark.parametrize("kinds", [("Pose", "Pose_V"), ("Pose_V", "Pose")], ids="then".join)
def test_of_two_types_on_a_topic_the_subscribed_one_is_registered(kinds: tuple[str, str]) -> None:
    """A server sends only that; Harmonic tells of a robot's Pose_V first, and its poses were missed in records."""
    port = str(free_udp_port())
    environment = {"GZ_PARTITION": "types", "GZ_IP": "127.0.0.1", "GZ_DISCOVERY_MSG_PORT": port}
    server = Discovery(TOPICS, "server", environment)
    topic = {"topic": "@/types@/pose", "address": "tcp://127.0.0.1:1", "node_uuid": "server"}
    try:
        with transport_client_of_sim(environment, Patience()) as client:
            client.subscribe("/pose", "Pose")
            for kind in kinds:
                server.send(Event.ADVERTISE, pub={**topic, "msg_pub": {"ctrl": "", "msg_type": f"gz.msgs.{kind}"}})
            client.wait_for_publisher("/pose", Patience(seconds=5.0, sign=5.0))
            registered: list[str] = []
            while not registered and select.select([server.receiver], [], [], 5)[0]:
                message = server.receive() or {}
                if message.get("type") == Event.NEW_CONNECTION:
                    registered.append(message["pub"]["msg_pub"]["msg_type"])
    finally:
        server.close()
    assert registered == ["gz.msgs.Pose"]


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a socket cannot be bound to a group")
def test_discovery_listens_only_where_the_user_said() -> None:
    environment = {"GZ_IP": "127.0.0.1", "GZ_DISCOVERY_MSG_PORT": str(free_udp_port())}
    ours, theirs = (Discovery(TOPICS, name, environment) for name in ("us", "them"))
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            for host in {"127.0.0.1", *interfaces({})}:
                other.sendto(b"to one of our addresses", (host, int(environment["GZ_DISCOVERY_MSG_PORT"])))
        theirs.send(Event.BYE)
        select.select([ours.receiver], [], [], 5)
        message = ours.receive()
        assert message is not None
        assert message["type"] == Event.BYE
    finally:
        ours.close()
        theirs.close()


def test_datagrams_of_others_are_passed_over() -> None:
    port = str(free_udp_port())
    environment = {"GZ_IP": "127.0.0.1", "GZ_DISCOVERY_MSG_PORT": port}
    ours, theirs = (Discovery(TOPICS, name, environment) for name in ("us", "them"))
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            for junk in (b"", b"x", b"\xff\xff", b"\x02\x00\x1a\xff", b"\x03\x00abc"):
                other.sendto(junk, ("127.0.0.1", int(port)))
        ours.send(Event.HEARTBEAT)
        theirs.send(Event.ADVERTISE, pub={"topic": "@/p@/t"})
        messages: list[dict[str, Any]] = []
        while not messages:
            select.select([ours.receiver], [], [], 5)
            messages += [message] if (message := ours.receive()) else []
        assert messages[0]["pub"] == {"process_uuid": "them", "scope": 2, "topic": "@/p@/t"}
    finally:
        ours.close()
        theirs.close()


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.parametrize(("types", "type_name"), [(SIM, "Model"), (CLASSIC, "Model")])
def test_a_number_that_is_sent_in_eight_bytes_is_no_id(types: MessageTypes, type_name: str) -> None:
    number, _ = types.types[type_name]["id"]
    with pytest.raises(NoMessage, match="id is of another kind"):
        types.decode(type_name, bytes([number << 3 | 1]) + b"\0" * 8)
