"""Answers to pages about robots on a map are what rsegen.poses, its reach and its ways say."""

from __future__ import annotations

import json
import threading
from base64 import b64decode
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import rsegen
from rsegen.driving import page as drives
from rsegen.driving.planning import predictions
from rsegen.driving.prediction import Prediction
from rsegen.errors import ParameterError, UnknownName, UserError
from rsegen.page import documents as hosting
from rsegen.page import host as page_host
from rsegen.page.hello import hello
from rsegen.page.host import Asker, Host, Listener, asked_by
from rsegen.page.model.session import Session
from rsegen.robots import page as robots
from rsegen.robots.base import ROBOTS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import EMBEDDED
from rsegen.standing import reach
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import REASONS

RECIPE = rsegen.Recipe(
    name="field", chunk_size=6, boundary="none", unit_cm=5, seed=3, obstacles=[rsegen.Random(levels=4)], maps=2
)
FIELD = rsegen.build(RECIPE)


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Host:
    return Host(folder=tmp_path_factory.mktemp("folder"))


@pytest.fixture(scope="module")
def doc(host: Host) -> str:
    rsegen.save(RECIPE, host.folder / "field.yaml")
    name: str = hosting.open(host, what=str(host.folder / "field.yaml"))["doc"]
    return name


@pytest.mark.parametrize("kind", ["burger", "jackal"])
def test_a_pose_is_that_of_python(host: Host, doc: str, kind: str) -> None:
    for x, y, heading in ((0.0, 0.0, 0.0), (0.11, -0.12, 0.7), (-0.2, 0.14, 2.0)):
        told = robots.pose(host, doc=doc, index=0, robot=kind, x=x, y=y, heading=heading)
        known = rsegen.poses(FIELD, kind, x, y, heading)
        for name in ("x", "y", "z", "roll", "pitch", "yaw", "tilt") if known.stands[0] else ():
            assert told[name] == pytest.approx(float(getattr(known, name)[0]), abs=1e-9)
        assert told["margin"] == pytest.approx(float(known.tip_angle[0]), abs=1e-9)
        assert told["stable"] == rsegen.stable_poses(FIELD, kind, x, y, heading).count[0]
        assert told["reason"] == REASONS[int(known.reason[0])]
        assert (told["stands"], told["holds"], told["pushes"]) == (known.stands[0], known.holds[0], known.pushes[0])
        assert json.dumps(told, allow_nan=False)


def test_a_support_polygon_goes_round_the_contacts_and_the_centre_of_mass(host: Host, doc: str) -> None:
    told = robots.pose(host, doc=doc, index=0, robot="crawler", x=0.05, y=0.02, heading=0.4)
    assert told["stands"]
    corners = np.array(told["polygon"])[:, :2]
    after = np.roll(corners, -1, axis=0)
    for x, y, _ in told["contacts"]:
        turns = (after - corners)[:, 0] * (y - corners[:, 1]) - (after - corners)[:, 1] * (x - corners[:, 0])
        assert (turns >= -1e-5).all(), "counterclockwise, with each contact inside or on it"


def test_a_robot_that_tips_over_is_level_on_the_highest_block_below_it(host: Host, doc: str) -> None:
    places = np.random.default_rng(1).uniform(-0.3, 0.3, (40, 2)).tolist()
    poses = [robots.pose(host, doc=doc, index=0, robot="burger", x=x, y=y, heading=0.5) for x, y in places]
    tipping = [pose for pose in poses if not pose["stands"]]
    assert tipping
    points, (c, s) = ROBOTS["burger"].body.points, (np.cos(0.5), np.sin(0.5))
    for pose in tipping:
        assert (pose["roll"], pose["pitch"], pose["yaw"]) == (0, 0, 0.5)
        x, y = pose["x"] + c * points[:, 0] - s * points[:, 1], pose["y"] + s * points[:, 0] + c * points[:, 1]
        above = pose["z"] + points[:, 2] - PaddedGround.of(FIELD, 0.1).below(x, y)
        assert above.min() == pytest.approx(0, abs=1e-9)


def test_beside_the_map_a_robot_stands_on_level_ground(host: Host, doc: str) -> None:
    told = robots.pose(host, doc=doc, index=0, robot="burger", x=5.0, y=0.0, heading=1.0)
    assert told["reason"] == ""
    assert told["tilt"] == pytest.approx(0, abs=1e-6)


def test_a_map_of_tilts_has_the_pose_of_each_point(host: Host, doc: str) -> None:
    told = robots.tilt(host, doc=doc, index=1, robot="crawler", heading=0.3)
    n_x, n_y = told["shape"]
    tilt = np.frombuffer(b64decode(told["tilt"]), "<f4").reshape(n_x, n_y)
    reason = np.frombuffer(b64decode(told["reason"]), "u1").reshape(n_x, n_y)
    assert told["reasons"] == list(REASONS)
    for i, j in ((0, 0), (3, 5), (n_x - 1, n_y - 1), (n_x // 2, n_y // 2)):
        x, y = told["low"][0] + i * told["step"], told["low"][1] + j * told["step"]
        pose = robots.pose(host, doc=doc, index=1, robot="crawler", x=x, y=y, heading=0.3)
        assert REASONS[reason[i, j]] == pose["reason"]
        assert np.isnan(tilt[i, j]) if not pose["stands"] else tilt[i, j] == pytest.approx(pose["tilt"], abs=1e-5)


@pytest.mark.slow
def test_a_way_goes_step_by_step_from_its_start_to_its_goal(host: Host, doc: str) -> None:
    start, goal = (-0.25, -0.25), (0.15, 0.25)
    told = robots.way(host, doc=doc, index=0, robot="crawler", start=start, goal=goal)
    poses = np.array(told["poses"])
    assert told["found"]
    moves = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert moves.max() < 0.1
    assert np.hypot(*(poses[[0, -1], :2] - [start, goal]).T).max() < 0.12, "tilted, its origin is a little aside"
    assert told["worst_tilt"] == pytest.approx(np.arccos(np.cos(poses[:, 3]) * np.cos(poses[:, 4])).max(), abs=1e-4)
    assert all(0 <= event["at"] < len(poses) for event in told["events"])
    assert list(told["least_margin_at"]) in poses[:, :2].tolist()


@pytest.mark.slow
def test_the_most_level_way_is_no_steeper_than_the_shortest(host: Host, doc: str) -> None:
    shortest, level = (
        robots.way(host, doc=doc, index=0, robot="crawler", start=(-0.25, 0.05), goal=(0.25, 0.05), best=best)
        for best in ("length", "tilt")
    )
    assert shortest["length"] <= level["length"] + 1e-9
    assert level["worst_tilt"] <= shortest["worst_tilt"] + 0.02


@pytest.mark.slow
def test_a_region_and_ways_are_those_of_the_metrics(host: Host, doc: str) -> None:
    told = robots.reach(host, doc=doc, index=0, robot="crawler")
    found = rsegen.metrics(FIELD, ROBOTS["crawler"]).reach
    region = np.frombuffer(b64decode(told["region"]), "u1").reshape(FIELD.shape)
    assert np.array_equal(region.astype(bool), found.region)
    assert all(way["crosses"] for way in told["ways"]) == (found.west_east.crosses or found.south_north.crosses)
    for way in told["ways"]:
        for x, y, z in way["points"]:
            i, j = np.floor(np.array([x, y]) / FIELD.block_width + np.array(FIELD.shape) / 2 + 1e-9).astype(int)
            around = FIELD.heights[max(i - 1, 0) : i + 1, max(j - 1, 0) : j + 1]
            assert z in {0.0, *around.ravel().tolist()}, "on a block, or on the ground around the map"
    measured = {row[3]: row[1] for row in robots.measure(host, doc=doc, index=0, robot="crawler")["rows"]}
    assert measured["reach.coverage"] == f"{found.coverage:.4g}"
    assert measured["steps.rms"] == f"{rsegen.metrics(FIELD).steps.rms:.4g}"


@pytest.mark.slow
def test_pages_hear_how_far_a_search_is(host: Host, doc: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_host, "_SENT_EVERY", 0.0)
    monkeypatch.setattr(reach, "_MOVES_AT_ONCE", 60)
    heard: list[Any] = []
    listener = Listener(page="p", send=heard.append)
    host.opened(doc).add(listener)
    robots.reach(host, doc=doc, index=1, robot="jackal")
    host.opened(doc).remove(listener)
    shares = [each["share"] for each in heard if each["event"] == "progress" and each["of"] == "reach"]
    assert len(shares) > 5
    assert shares == sorted(shares)
    assert (shares[0] < 0.3, shares[-1]) == (True, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("of", ["reach", "tilt"])
@pytest.mark.parametrize("by", ["a stop", "a newer request", "the end of its page", "the end of its connection"])
def test_a_search_ends_soon_by(
    by: str, of: Literal["reach", "tilt"], host: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    large = rsegen.Recipe(chunk_size=30, chunks=(2, 2), unit_cm=2, obstacles=[rsegen.Random(levels=4)])
    rsegen.save(large, host.folder / "large.yaml", force=True)
    doc = hosting.open(host, what=str(host.folder / "large.yaml"))["doc"]
    begun, ended = threading.Event(), list[str]()
    monkeypatch.setattr(page_host, "_SENT_EVERY", 0.0)
    monkeypatch.setattr(robots, "_AT_ONCE", 1)
    listener = Listener(page="p", send=lambda event: begun.set() if event["event"] == "progress" else None)
    host.opened(doc).add(listener)
    asker = Asker(page="p")

    def search() -> None:
        try:
            with asked_by(asker):
                if of == "reach":
                    robots.reach(host, doc=doc, index=0, robot="crawler")
                else:
                    robots.tilt(host, doc=doc, index=0, robot="crawler", heading=0.3)
        except UserError as error:
            ended.append(str(error))

    first = threading.Thread(target=search)
    first.start()
    assert begun.wait(60)
    if by == "a stop":
        with asked_by(Asker(page="p")):
            robots.stop(host, doc=doc, of=of)
    elif by == "the end of its page":
        host.opened(doc).remove(listener)
    elif by == "the end of its connection":
        asker.has_left = True
    else:
        with asked_by(Asker(page="p")), host.opened(doc).newest_turn(of):
            pass
    first.join(30)  # all of it takes minutes
    host.opened(doc).remove(listener)
    assert ended == ["it was stopped, or a newer request replaced it"]


@pytest.mark.slow
def test_a_way_is_that_of_a_robot_as_its_file_is_now(host: Host, doc: str) -> None:
    found = []
    for kind in ("burger", "crawler"):
        (host.folder / "changed.sdf").write_text(ROBOTS[kind].file("changed"))
        told = robots.way(host, doc=doc, index=0, robot="changed.sdf", start=(-0.25, 0.05), goal=(0.25, 0.05))
        found.append(told["found"])
    assert found == [False, True], "a burger cannot drive there"


@pytest.mark.parametrize("kind", sorted(ROBOTS))
def test_the_drawing_of_a_robot_is_as_large_as_the_robot(host: Host, kind: str) -> None:
    told = robots.robot(host, robot=kind)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in told["parts"]:
        pose, size = np.array(part["pose"]).reshape(4, 4), part["size"]
        half = {"box": size, "cylinder": [2 * size[0]] * 2 + size[-1:], "sphere": [2 * size[0]] * 3}[part["shape"]]
        corners = np.array(np.meshgrid(*([-each / 2, each / 2] for each in half))).reshape(3, -1)
        placed = pose[:3, :3] @ corners + pose[:3, 3:]
        low, high = np.minimum(low, placed.min(axis=1)), np.maximum(high, placed.max(axis=1))
    assert high - low == pytest.approx(told["size"], abs=0.15 * max(told["size"]))
    assert any(part["wheel"] for part in told["parts"])


def drawn(host: Host, robot: str) -> list[list[Any]]:
    """The parts of a robot, rounded to a tenth of a millimetre, in an order of their own."""
    parts = robots.robot(host, robot=robot)["parts"]
    return sorted(
        [part["shape"], part["colour"], part["wheel"], *np.round(part["size"] + part["pose"], 4).tolist()]
        for part in parts
    )


@pytest.mark.parametrize("kind", sorted(ROBOTS))
def test_a_robot_of_a_file_is_drawn_as_its_visuals_are(host: Host, kind: str) -> None:
    (host.folder / "same.sdf").write_text(ROBOTS[kind].file("same"))
    if any(servo.rest for servo in ROBOTS[kind].servos):  # a file has its joints at 0
        assert [part[:-16] for part in drawn(host, "same.sdf")] == [part[:-16] for part in drawn(host, kind)]
    else:
        assert drawn(host, "same.sdf") == drawn(host, kind)


def test_flippers_are_drawn_raised_as_they_are_in_all_poses(host: Host) -> None:
    tips = [part for part in robots.robot(host, robot="crawler")["parts"] if part["size"] == [0.05, 0.04]]
    raised = 0.085 + 0.3 * np.sin(0.25)  # the axle, and a flipper of 30 cm at an angle of 0.25
    assert sorted(part["pose"][11] for part in tips) == pytest.approx([0.085, 0.085, raised, raised])
    assert len(robots.robot(host, robot="crawler")["parts"]) > len(tips)


def test_a_link_whose_visual_is_not_known_is_the_boxes_of_its_collisions(host: Host) -> None:
    text = ROBOTS["burger"].file("other")
    head, visual, tail = text.partition("<visual")
    (host.folder / "other.sdf").write_text(
        head + visual + tail.replace("<box>", "<heightmap>", 1).replace("</box>", "</heightmap>", 1)
    )
    told, known = robots.robot(host, robot="other.sdf")["parts"], robots.robot(host, robot="burger")["parts"]
    assert len(told) < len(known)
    assert {part["shape"] for part in told} > {"box"}


def test_the_centre_of_mass_is_above_where_the_robot_was_put(host: Host, doc: str) -> None:
    told = robots.pose(host, doc=doc, index=0, robot="crawler", x=0.05, y=0.02, heading=0.4)
    body = ROBOTS["crawler"].body
    c, s = np.cos(0.4), np.sin(0.4)
    above = [0.05 + c * body.centre[0] - s * body.centre[1], 0.02 + s * body.centre[0] + c * body.centre[1]]
    assert told["tilt"] > 0
    assert told["centre"][:2] == pytest.approx(above, abs=1e-9)
    assert min(z for _, _, z in told["polygon"]) < told["centre"][2]


def test_a_robot_of_a_file_in_the_folder_rests_as_its_kind(host: Host, doc: str) -> None:
    (host.folder / "mine.sdf").write_text(ROBOTS["burger"].file("mine"))
    assert "mine.sdf" in {each["name"] for each in hello(host)["robots"]}
    burger = robots.pose(host, doc=doc, index=0, robot="burger", x=0.05, y=0.05, heading=0.0)
    assert robots.pose(host, doc=doc, index=0, robot="mine.sdf", x=0.05, y=0.05, heading=0.0)["z"] == pytest.approx(
        burger["z"], abs=2e-3
    )


@pytest.mark.parametrize("robot", ["../mine.sdf", "/etc/passwd.sdf", "link.sdf"])
def test_a_robot_of_a_file_outside_the_folder_is_refused(host: Host, robot: str, tmp_path: Path) -> None:
    (tmp_path / "there.sdf").write_text(ROBOTS["burger"].file("mine"))
    link = host.folder / "link.sdf"
    link.unlink(missing_ok=True)
    link.symlink_to(tmp_path / "there.sdf")
    with pytest.raises(ParameterError, match="is outside"):
        robots.robot(host, robot=robot)


def test_bad_arguments_are_one_line(host: Host, doc: str) -> None:
    with pytest.raises(UnknownName, match="robot"):
        robots.robot(host, robot="burgr")
    with pytest.raises(ParameterError, match=r"index: 2 is outside 0\.\.1"):
        robots.pose(host, doc=doc, index=2, robot="burger", x=0.0, y=0.0, heading=0.0)
    for x in (float("nan"), 1e9):
        with pytest.raises(ParameterError, match="x: "):
            robots.pose(host, doc=doc, index=0, robot="burger", x=x, y=0.0, heading=0.0)


def test_of_requests_that_wait_the_newest_alone_gets_its_turn(tmp_path: Path) -> None:
    begun, may_end = threading.Event(), threading.Event()
    answers: list[str] = []
    opened = Host(folder=tmp_path).open(Session.of())

    def ask(name: str) -> None:
        try:
            with opened.newest_turn("tilt"):
                begun.set()
                may_end.wait(10)
                answers.append(name)
        except UserError:
            answers.append(f"{name} is dropped")

    threads = [threading.Thread(target=ask, args=(name,)) for name in ("first", "second", "third")]
    threads[0].start()
    begun.wait(10)
    for thread in threads[1:]:
        before = opened.searches["tilt", ""]
        thread.start()
        while opened.searches["tilt", ""] is before:
            pass
    may_end.set()
    for thread in threads:
        thread.join(10)
    assert sorted(answers) == ["first", "second is dropped", "third"]
    assert not opened.searches


def test_pages_of_one_document_take_and_stop_no_search_of_each_other(host: Host, doc: str) -> None:
    opened = host.opened(doc)
    heard = dict[str, list[Any]](one=[], other=[])
    listeners = [Listener(page=page, send=events.append) for page, events in heard.items()]
    for listener in listeners:
        opened.add(listener)
    with asked_by(Asker(page="one")), opened.newest_turn("reach") as watch:
        with asked_by(Asker(page="other")):
            opened.searches["reach", "other"] = object()  # one that waits
            robots.stop(host, doc=doc, of="reach")
        opened.remove(listeners[1])
        watch(0.5, "drives")
    steps = {
        page: [(event["step"], event["share"]) for event in events if event["event"] == "progress"]
        for page, events in heard.items()
    }
    assert steps == {"one": [("drives", 0.5)], "other": []}
    opened.remove(listeners[0])


@pytest.mark.slow
@pytest.mark.skipif(not EMBEDDED, reason="the capability mujoco is not here")
def test_a_page_is_told_how_surely_a_robot_gets_across(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    low = rsegen.Recipe(chunk_size=4, boundary="none", unit_cm=1, seed=3, obstacles=[rsegen.Random(levels=2)])
    rsegen.save(low, host.folder / "low.yaml")
    doc = hosting.open(host, what=str(host.folder / "low.yaml"))["doc"]
    made = list[Mapping[str, Prediction]]()

    def predicted(robot: object, scene: Scene) -> Mapping[str, Prediction]:
        """Prediction that is kept, as the drives take seconds."""
        assert robot == ROBOTS["jackal"]
        assert scene.field == rsegen.build(low)
        made.append(predictions(robot, scene))
        return made[-1]

    monkeypatch.setattr(drives, "predictions", predicted)
    told = drives.crossing(host, doc=doc, index=0, robot="jackal")
    (found,) = made
    assert set(found) == {"west_east", "south_north"}
    assert told["text"] == ""
    assert told["simulator"].endswith(f", {found['west_east'].motors} motors")
    assert [side["name"] for side in told["sides"]] == ["west to east", "south to north"]
    for side, prediction in zip(told["sides"], found.values(), strict=True):
        assert (side["crossed"], side["drives"]) == (prediction.crossed, prediction.drives)
        assert (side["probability"], side["seconds"]) == (prediction.probability, prediction.seconds)
        assert [(end["reason"], end["x"], end["y"], end["drives"]) for end in side["ends"]] == list(prediction.ends)
    assert len(told["ways"]) == sum(prediction.drives for prediction in found.values())
    crossing = [way for way in told["ways"] if way["crosses"]]
    assert len(crossing) == sum(prediction.crossed for prediction in found.values()) > 0
    first, last = np.array(crossing[0]["points"])[[0, -1]]
    assert last[0] - first[0] > rsegen.build(low).extent[0]
    assert json.dumps(told, allow_nan=False)
