"""Contract of all live worlds: in real servers, and over the transport library of Gazebo Sim alone."""

from __future__ import annotations

import os
import re
import secrets
import socket
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import astuple
from pathlib import Path
from types import SimpleNamespace

import pytest

import rsegen
from rsegen.cli.edge import main
from rsegen.errors import NothingRuns, ParameterError, SimulatorFailed
from rsegen.gazebo import sdf
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.gazebo_sim import SimWorld, _by_id
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import Patience
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import running_server
from rsegen.simulators.sim_transport import SERVICES, Discovery, Event, transport_client
from rsegen.simulators.wire import SIM
from tests.real.conftest import gazebo_classic, gazebo_sim
from tests.simulators.transport import NEEDS_ENGINE, connected_to, transport_world
from tests.support.complaints import the_line
from tests.support.patience import PATIENCE

__all__ = ["gazebo_classic", "gazebo_sim"]

BURGER = robot_of_kind("burger")
THERE, ELSEWHERE = Pose(x=1, y=-2, z=0.5, yaw=1.0), Pose(x=-1.5, y=0.25, z=1.0, yaw=-0.5)


@pytest.fixture(params=["sim", "classic", pytest.param("transport", marks=NEEDS_ENGINE)])
def live(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[LiveWorld]:
    """A world with the ground alone, which stands still: in a server, or in the transport of Gazebo Sim alone."""
    if request.param == "transport":
        with transport_world("rse_0000") as address, connected_to(address) as world:
            yield world
        return
    here = request.getfixturevalue(f"gazebo_{request.param}")
    file = tmp_path / "ground.world"
    file.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(rsegen.Recipe(seed=1)), ()))))
    with running_server(here, file) as server, server.connect() as world:
        yield world


def model(name: str, live: LiveWorld) -> str:
    return BURGER.file(name, live.backend)


@pytest.mark.slow
def test_a_model_is_put_moved_and_taken(live: LiveWorld) -> None:
    live.spawn(model("one", live), THERE)
    live.spawn(model("other", live), Pose(x=0, y=0, z=0))
    assert set(live.poses()) == {"ground_plane", "one", "other"}
    assert live.movable() == {"one", "other"}
    assert astuple(live.poses()["one"]) == pytest.approx(astuple(THERE))
    live.move("one", ELSEWHERE)
    assert astuple(live.poses()["one"]) == pytest.approx(astuple(ELSEWHERE))
    assert astuple(live.poses()["other"]) == pytest.approx((0,) * 6)
    live.delete("one")
    assert set(live.poses()) == {"ground_plane", "other"}
    with pytest.raises(SimulatorFailed, match="no model one to move"):
        live.move("one", THERE)


@pytest.mark.slow
def test_time_goes_by_steps_or_by_itself(live: LiveWorld) -> None:
    assert (live.clock().steps, live.clock().paused) == (0, True)
    live.step(1250)
    assert (live.clock().steps, live.clock().simulated, live.clock().paused) == (1250, 1.25, True)
    live.unpause()
    assert not live.clock().paused
    live.pause()
    assert live.clock().paused


@pytest.mark.slow
def test_a_model_of_the_worlds_own_name_is_taken_and_put_again(live: LiveWorld) -> None:
    world = "rse_0000"
    live.spawn(model("other", live), ELSEWHERE)
    live.spawn(model(world, live), THERE)
    live.delete(world)
    assert set(live.poses()) == {"ground_plane", "other"}
    live.spawn(model(world, live), Pose(x=2, y=0, z=0))
    assert live.poses()[world].x == pytest.approx(2)
    assert set(live.poses()) == {"ground_plane", "other", world}


# Gazebo Sim.


def test_a_command_is_received_when_it_has_been_sent(sim_address: Mapping[str, str]) -> None:
    with connected_to(sim_address) as live:
        assert live.backend == "fortress"
        robots = [f"burger_{number}" for number in range(8)]
        for name in robots:
            live.spawn(model(name, live), THERE)
        for number, name in enumerate(robots):
            live.send_command(BURGER.command(name, 0.001 * number, -0.5, live.backend))
        live.step(50)
        assert [live.poses()[name].x for name in robots] == pytest.approx([0.001 * number for number in range(8)])


def test_poses_are_recorded_as_often_as_a_robot_publishes_them(sim_address: Mapping[str, str]) -> None:
    with connected_to(sim_address) as live:
        live.spawn(model("burger", live), THERE)
        live.record(["burger"])
        live.step(500)
        live.step(500)
        record = live.recorded()
    assert [second for second, _ in record] == pytest.approx([0.05 * (number + 1) for number in range(20)])
    assert record[-1][1]["burger"] == pytest.approx(list(astuple(THERE)))


def test_a_robot_and_a_map_are_spawned_respawned_and_removed_in_sim(
    sim_address: Mapping[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    Path("course.yaml").write_text("name: course\nseed: 1\nchunk_size: 4\n")
    for words in (["spawn", "course.yaml"], ["spawn", "burger", "--at", "0,0"], ["respawn", "course.yaml"]):
        assert main([*words, "--simulator", "sim"]) == 0
    out = capsys.readouterr().out
    assert "course_0000 is in Gazebo Sim at 0 0 0" in out
    assert "course_0001 replaces course_0000, at 0 0 0; put on top of it: burger" in out
    assert main(["remove", "burger", "course_0001"]) == 0
    with connected_to(sim_address) as live:
        assert set(live.poses()) == {"ground_plane"}


def test_a_map_of_many_boxes_is_spawned(sim_address: Mapping[str, str]) -> None:
    recipe = rsegen.Recipe(seed=1, chunks=(3, 3), collision="boxes", obstacles=(rsegen.Random(levels=5),))
    assert rsegen.spawn(recipe, simulator="sim").name == "rse_0000"
    assert Path("worlds/rse_0000/model.sdf").stat().st_size > 2**17


def test_a_missing_server_is_reported() -> None:
    with (
        pytest.raises(NothingRuns, match=r"no server answers in the partition no-lab$"),
        SIMULATORS["sim"].connect({"GZ_PARTITION": "no-lab"}, Patience(sign=0.5)),
    ):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="users of Windows have no numbers")
def test_the_default_partition_has_the_name_of_the_user_as_the_system_knows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in NetUtils.cc of gz-transport, whatever USER says; in a container the number may be no user's."""
    monkeypatch.setenv("USER", "somebody-else")
    monkeypatch.setenv("LOGNAME", "somebody-else")
    local = {"GZ_IP": "127.0.0.1", "USER": "somebody-else"}
    users = {os.getuid(): SimpleNamespace(pw_name="ada")}
    monkeypatch.setattr("pwd.getpwuid", users.__getitem__)
    with transport_client(local, Patience()) as client:
        assert client.partition == f"{socket.gethostname()}:ada"
    users.clear()
    with transport_client(local, Patience()) as client:
        assert client.partition == f"{socket.gethostname()}:{os.getuid()}"


def test_of_two_servers_none_is_taken(sim_address: Mapping[str, str]) -> None:
    partition = sim_address["GZ_PARTITION"]
    with connected_to(sim_address), transport_world("other", partition) as address:
        with transport_client(address, Patience()) as client:
            client.offers("/world/other/control")
        problem = (
            f"GZ_PARTITION: 2 servers of Gazebo Sim run in the partition {partition}; set it to that of one server"
        )
        with pytest.raises(ParameterError, match=re.escape(problem)):
            connect_again_and_again(address)


def connect_again_and_again(address: Mapping[str, str]) -> None:
    """On a busy machine the answer of one of several servers may be late."""
    for _ in range(10):
        with connected_to(address):
            pass


def test_a_drive_without_the_poses_that_a_robot_publishes_has_failed() -> None:
    """Its record would else be one of the commands, ten times as coarse."""
    with transport_client({"GZ_PARTITION": "silent", "GZ_IP": "127.0.0.1"}, Patience()) as client:
        told = {"name": "one", "header": {"stamp": {"sec": 1}}}
        world = SimWorld(client=client, name="w", backend="sim", _recorded={"one": [told], "two": []})
        assert [at for at, _ in world.recorded()] == [1.0]
        world._stopped = 2000, 2 * 10**9
        with pytest.raises(SimulatorFailed, match=r"^Gazebo Sim: no pose of two was published$"):
            world.recorded()


def test_of_the_poses_in_a_message_only_those_of_models_are_read() -> None:
    """A message has the poses of hundreds of links; a damaged one of a link harms nobody, one of a model is missing."""
    pose = SIM.encode("Pose", {"name": "one", "id": 7, "position": {"x": 1.5}})
    without_id, damaged = SIM.encode("Pose", {"name": "none"}), SIM.encode("EntityPose", {"id": 9}) + b"\x22\x01\x07"
    content = SIM.encode("Pose_V", {"header": {"stamp": {"sec": 2}}, "pose": [pose, without_id, damaged, b"\x0f"]})
    found = _by_id(SIM.decode("Pose_V", content))
    assert found == {7: pose, 9: damaged}
    with transport_client({"GZ_PARTITION": "poses", "GZ_IP": "127.0.0.1"}, Patience()) as client:
        world = SimWorld(client=client, name="w", backend="sim", _names={7: "one", 9: "damaged", 11: "elsewhere"})
        assert world._by_name(found) == {"one": Pose(x=1.5, y=0, z=0)}


def test_a_server_that_cannot_be_connected_to_is_given_up_and_nothing_hangs() -> None:
    """It was heard, and has gone since: requests are tried again until their time is over."""
    address, service = {"GZ_PARTITION": "gone", "GZ_IP": "127.0.0.1"}, "/world/gone/control"
    kind = {"socket_id": "gone", "request_type": "ignition.msgs.Empty", "response_type": "ignition.msgs.Boolean"}
    gone = {"topic": f"@/gone@{service}", "address": "tcp://127.0.0.1:1", "node_uuid": "gone", "srv_pub": kind}
    server, said = Discovery(SERVICES, "gone", address), []

    def use() -> None:
        with transport_client(address, Patience()) as client:
            server.send(Event.ADVERTISE, pub=gone)
            with pytest.raises(SimulatorFailed) as failed:
                client.request(service, "Empty", {}, Patience(seconds=2.0))
            said.append(str(failed.value))

    using = threading.Thread(target=use, daemon=True)
    using.start()
    using.join(PATIENCE)
    server.close()
    assert said == [f"Gazebo Sim: {service} does not answer within 2 s"]
    assert not using.is_alive()


@pytest.mark.parametrize("runs", [True, False])
def test_a_server_is_current_only_if_it_answers_again(*, runs: bool) -> None:
    """One that was killed has offered its services before, and does not take them back."""
    address = {"GZ_PARTITION": f"current-{secrets.token_hex(4)}", "GZ_IP": "127.0.0.1"}
    own = f"@/{address['GZ_PARTITION']}@/gazebo/worlds"
    offer = {"topic": own, "address": "tcp://127.0.0.1:1", "node_uuid": "one", "srv_pub": {"socket_id": "one"}}
    server, ended = Discovery(SERVICES, "one", address), threading.Event()

    def answer() -> None:
        while not ended.wait(0.01):
            message = server.receive()
            if message and message.get("sub", {}).get("topic") == own:
                server.send(Event.ADVERTISE, pub=offer)

    answering = threading.Thread(target=answer, daemon=True)
    answering.start()
    with transport_client(address, Patience(seconds=PATIENCE if runs else 1.0)) as client:
        client.offers("/gazebo/worlds", Patience(seconds=PATIENCE))
        client.attend("one")
        if not runs:
            ended.set()
            answering.join()
        assert SimWorld(client=client, name="lab", backend="sim").is_current == runs
    ended.set()
    answering.join()
    server.close()


@NEEDS_ENGINE
def test_a_server_that_ends_is_an_error() -> None:
    with ExitStack() as server:
        address = server.enter_context(transport_world("short"))
        with connected_to(address) as live:
            assert set(live.poses()) == {"ground_plane"}
            server.close()
            with pytest.raises(SimulatorFailed, match=r"the server (has ended|does not answer any more)$"):
                live.step(10)


@pytest.mark.parametrize("words", [["spawn", "burger"], ["remove", "burger"]])
def test_without_a_running_simulation_it_is_refused_in_one_line(
    words: list[str], programs: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://127.0.0.1:1")
    monkeypatch.setenv("GZ_PARTITION", "no-lab")
    assert main(words) == 2
    line = the_line(capsys.readouterr().err)
    said = "no simulation runs (Gazebo Sim: no server answers in the partition no-lab; Gazebo Classic: no answer"
    assert said in line


@pytest.mark.parametrize(
    ("simulator", "variable", "value", "problem"),
    [
        ("classic", "GAZEBO_MASTER_URI", "localhost", "is not a host and a port"),
        ("classic", "GAZEBO_MASTER_URI", "http://127.0.0.1:99999", "is not a host and a port"),
        ("sim", "GZ_DISCOVERY_MULTICAST_IP", "nonsense", "is not an address, as in 239.255.0.7"),
    ],
)
def test_an_invalid_address_is_refused(  # two fixtures
    simulator: str,
    variable: str,
    value: str,
    problem: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv(variable, value)
    assert main(["remove", "burger", "--simulator", simulator]) == 2
    assert f"{variable}: '{value}' {problem}" in the_line(capsys.readouterr().err)
