"""Pages see the folder of their server and nothing else; drives that they play are those of the files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen.driving import page as playback
from rsegen.errors import FileError
from rsegen.page import documents as hosting
from rsegen.page import places, scenes
from rsegen.page.host import Host


@pytest.fixture
def host(tmp_path: Path) -> Host:
    return Host(folder=tmp_path)


def test_a_folder_is_listed_with_what_each_thing_is(host: Host, tmp_path: Path) -> None:
    rsegen.save(rsegen.Recipe(seed=1), tmp_path / "mine.yaml")
    rsegen.generate(rsegen.Recipe(seed=1), tmp_path / "worlds")
    rsegen.make_dataset(rsegen.Recipe(seed=1), tmp_path / "data")
    (tmp_path / "drive").mkdir()
    (tmp_path / "drive" / "drive.json").write_text("{}")
    (tmp_path / ".hidden").write_text("")
    (tmp_path / "out").symlink_to(tmp_path.parent)
    (tmp_path / "note.txt").write_text("")
    assert {each["path"]: each["kind"] for each in hosting.files(host)["entries"]} == {
        "data": "dataset",
        "drive": "drive",
        "mine.yaml": "recipe",
        "note.txt": "other",
        "worlds": "folder",
    }
    assert hosting.files(host, folder="worlds") == {
        "folder": "worlds",
        "entries": [{"name": "rse_0000", "path": "worlds/rse_0000", "kind": "recipe"}],
    }


@pytest.mark.parametrize("folder", ["..", "/", "/etc", "a/../..", "out", "a\0", "missing"])
def test_no_other_folder_is_listed(folder: str, host: Host, tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path.parent)
    with pytest.raises(FileError):
        hosting.files(host, folder=folder)


def test_a_listing_is_bounded(host: Host, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "MOST", 5)
    for number in range(9):
        (tmp_path / f"{number}.yaml").write_text("")
    assert [each["name"] for each in hosting.files(host)["entries"]] == [f"{number}.yaml" for number in range(5)]


def drive(folder: Path, rows: Any, **robot: Any) -> None:
    """Write a drive as rsegen drive does."""
    folder.mkdir()
    known = {"name": "burger_0", "kind": "burger", "crossed": None, "touched": {}, **robot}
    told = {"map": "field_0000", "simulator": "Gazebo Classic 11", "route": "straight", "robots": [known]}
    (folder / "drive.json").write_text(json.dumps(told))
    lines = [",".join(map(repr, row)) for row in np.asarray(rows, float).tolist()]
    (folder / "burger_0.csv").write_text("\n".join(["t,x,y,z,roll,pitch,yaw", *lines]) + "\n")


def test_a_drive_is_played_as_it_was_recorded(host: Host, tmp_path: Path) -> None:
    t = np.arange(0, 3, 0.05)
    rows = np.stack([t, 0.2 * t, 0 * t, np.where(t < 1, 0.3, 0.1), np.where(t < 2, 0, 1.5), 0 * t, 0 * t], axis=1)
    drive(tmp_path / "a", rows, crossed=2.5, touched={"wheel": 0.9, "belly": 0.1})
    contacts = ["t,robot,part,other,x,y,z", "0.4,burger_0,wheel,field,0,0,0", "0.8,burger_0,belly,field,0,0,0"]
    (tmp_path / "a" / "contacts.csv").write_text("\n".join(contacts) + "\n")
    told = playback.playback(host, path="a")
    (robot,) = told["robots"]
    assert told["title"] == "field_0000, straight"
    assert np.array_equal(np.column_stack([robot["seconds"], robot["poses"]]), rows)
    assert told["duration"] == rows[-1, 0]
    assert [(round(event["second"], 2), event["text"], event["kind"]) for event in robot["events"]] == [
        (0.8, "belly touches field", "contact"),
        (0.8, "falls by 20 cm", "trouble"),
        (2.0, "tips over", "trouble"),
        (2.5, "has crossed the map", "success"),
    ]


def marks(host: Host, folder: Path, contacts: list[tuple[float, str]], x: Any, **robot: Any) -> list[tuple[float, str]]:
    """The events of a drive of some seconds, of the x of each quarter of a second and contacts with the map."""
    x = np.asarray(x, float)
    rows = np.zeros((len(x), 7))
    rows[:, 0], rows[:, 1] = np.arange(len(x)) / 4, x
    drive(folder / "a", rows, **{"touched": {"wheel": 0.9, "belly": 0.1, "arm": 0.2}, **robot})
    lines = [f"{second},burger_0,{part},field,0,0,0" for second, part in contacts]
    (folder / "a" / "contacts.csv").write_text("\n".join(["t,robot,part,other,x,y,z", *lines]) + "\n")
    (told,) = playback.playback(host, path="a")["robots"]
    return [(event["second"], event["text"]) for event in told["events"]]


def test_a_part_that_bounces_is_marked_once_and_again_after_a_pause(host: Host, tmp_path: Path) -> None:
    bounces = [(second, "belly") for second in (1.0, 1.25, 2.5, 4.5, 7.0, 7.25)]
    others = [(1.0, "wheel"), (7.0, "wheel"), (6.0, "arm")]
    moving = 0.1 * np.arange(41)
    assert marks(host, tmp_path, bounces + others, moving) == [
        (1.0, "belly touches field"),
        (6.0, "arm touches field"),
        (7.0, "belly touches field"),
    ]


def test_an_outcome_is_marked_however_many_contacts_come_before_it(
    host: Host, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(playback, "_EVENTS", 3)
    touching = [(second, part) for second in (1.0, 4.0, 7.0) for part in ("arm", "belly")]
    found = marks(host, tmp_path, touching, 0.1 * np.arange(41), crossed=9.5)
    assert found == [(1.0, "arm touches field"), (1.0, "belly touches field"), (9.5, "has crossed the map")]


def test_a_robot_that_stays_where_it_is_hangs_up_on_what_touches_there(host: Host, tmp_path: Path) -> None:
    held = np.minimum(np.arange(41), 12) * 0.1  # from 3 s on
    touching = [(2.75, "belly"), (3.5, "belly"), (4.0, "arm")]
    assert marks(host, tmp_path, touching, held) == [
        (2.75, "belly touches field"),
        (3.0, "hangs up on arm and belly"),
        (4.0, "arm touches field"),
    ]


@pytest.mark.parametrize(
    ("stands", "robot", "text"),
    [
        ((12, 41), {}, ["is stuck"]),
        ((12, 16), {}, []),  # a second, as in a turn
        ((12, 41), {"crossed": 2.5}, ["has crossed the map"]),
    ],
)
def test_standing_still_is_marked_after_two_seconds_before_the_end(
    stands: tuple[int, int], robot: dict[str, Any], text: list[str], host: Host, tmp_path: Path
) -> None:
    steps = np.full(41, 0.1)
    steps[slice(*stands)] = 0
    assert [words for _, words in marks(host, tmp_path, [], np.cumsum(steps), **robot)] == text


def test_rows_that_are_no_numbers_are_left_out(host: Host, tmp_path: Path) -> None:
    drive(tmp_path / "a", [[0, 0, 0, 0, 0, 0, 0], [0.05, np.nan, 0, 0, 0, 0, 0], [0.1, 1, 0, 0, 0, 0, 0]])
    told = playback.playback(host, path="a")
    assert told["robots"][0]["seconds"] == [0, 0.1]
    assert json.dumps(told, allow_nan=False)


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("drive.json", "{"),
        ("drive.json", "[]"),
        ("drive.json", '{"robots": [{"name": 3, "kind": "a"}]}'),
        ("drive.json", '{"robots": [{"name": "../../b", "kind": "a"}]}'),
        ("drive.json", "[" * 100_000),
        ("burger_0.csv", "a,b\n1,2\n"),
        ("burger_0.csv", "t,x,y,z,roll,pitch,yaw\n1,2\n"),
        ("burger_0.csv", "t,x,y,z,roll,pitch,yaw\n"),
        ("burger_0.csv", "t,x,y,z,roll,pitch,yaw\n1,0,0,0,0,0,0\n0,0,0,0,0,0,0\n"),
    ],
)
def test_a_drive_that_is_none_is_one_line(file: str, text: str, host: Host, tmp_path: Path) -> None:
    drive(tmp_path / "a", np.zeros((2, 7)))
    (tmp_path / "a" / file).write_text(text)
    with pytest.raises(FileError) as error:
        playback.playback(host, path="a")
    assert "\n" not in str(error.value)


def test_variants_are_the_recipe_at_other_seeds(host: Host, tmp_path: Path) -> None:
    recipe = rsegen.Recipe(name="field", seed=5, maps=3, obstacles=[rsegen.Random(levels=4)])
    rsegen.save(recipe, tmp_path / "field.yaml")
    doc = hosting.open(host, what=str(tmp_path / "field.yaml"))["doc"]
    shown = scenes.variants(host, doc=doc, count=6)
    assert len({each["seed"] for each in shown} | {recipe.seed}) == 7
    assert len({each["scene"]["content"] for each in shown}) == 6
    own = scenes.maps(host, doc=doc, first=1, count=6)
    assert [(each["seed"], each["index"]) for each in own] == [(5, 1), (5, 2)]
    steps = rsegen.metrics(rsegen.build(recipe, 1)).steps.mean or 0
    assert dict(own[0]["difficulty"])["mean step"] == f"{100 * steps:.3g} cm"
    mean = {index: rsegen.metrics(rsegen.build(recipe, index)).steps.mean or 0 for index in recipe.indices}
    by_step = scenes.maps(host, doc=doc, first=0, count=6, by="steps.mean")
    assert by_step[0]["difficulty"][0][0] == "steps mean"
    assert [each["index"] for each in by_step] == sorted(mean, key=lambda index: mean[index])
    with pytest.raises(rsegen.UserError, match="'size'"):
        scenes.maps(host, doc=doc, first=0, count=6, by="size")
    for count in (0, 25):
        with pytest.raises(rsegen.UserError, match="count: "):
            scenes.variants(host, doc=doc, count=count)


def test_a_large_map_is_shown_coarser(host: Host, tmp_path: Path) -> None:
    recipe = rsegen.Recipe(seed=5, chunk_size=250, obstacles=[rsegen.Random(levels=4)])
    rsegen.save(recipe, tmp_path / "large.yaml")
    doc = hosting.open(host, what=str(tmp_path / "large.yaml"))["doc"]
    (shown,) = scenes.variants(host, doc=doc, count=1)
    assert max(shown["scene"]["cells"]) <= 100
    with pytest.raises(rsegen.UserError, match="take too long to sort"):
        scenes.maps(host, doc=doc, first=0, count=1, by="ruggedness.tri")
    assert [name for name, _ in shown["difficulty"]] == ["mean step", "TRI"]
