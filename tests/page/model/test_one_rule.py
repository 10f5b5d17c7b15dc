"""The same list of obstacles makes the same bytes, whether it is made on the page, in a shell, in Python or in YAML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

import rsegen
from rsegen import Recipe, build, load
from rsegen.cli.edge import main
from rsegen.page.model.actions import act
from rsegen.page.model.document import Document, DraftFile, session_of_file
from rsegen.page.model.session import Session, draft_of
from rsegen.page.model.texts import command_line, python_code, text_after
from rsegen.recipe.codec import decode_obstacle, row_text
from rsegen.recipe.examples import EXAMPLES
from tests.support.runs import contents

Rows = Sequence[Mapping[str, Any]]

PEAK: Mapping[str, Any] = {"kind": "peak", "levels": 5, "softness": 60}
BARRIER: Mapping[str, Any] = {"kind": "diagonal_barrier", "levels": 3}
LISTS: Mapping[str, Rows] = {
    "random blocks": [{"kind": "random", "levels": 5}],
    "all that is left to chance": [
        {"kind": "normal_random", "levels": 4, "spread": 0.3},
        BARRIER,
        {"kind": "peak", "levels": 5, "first": ["random", 3], "last": "random", "blend": "add"},
        {"kind": "pallet", "levels": 4, "first": "random", "last": "random"},
    ],
    "twins": [PEAK, {"kind": "random", "levels": 2}, PEAK, PEAK, {**PEAK, "levels": 4}],
    "one that is switched off": [PEAK, {**PEAK, "enabled": False}, PEAK],
    "given places": [{"kind": "horizontal_barrier", "levels": 4, "first": [2, 0], "last": [2, 9]}],
}
SEED = 4711


def recipe_of(rows: Rows) -> Recipe:
    """The list in Python."""
    return Recipe(seed=SEED, chunks=(2, 1), obstacles=[decode_obstacle(row) for row in rows])


def added(rows: Rows) -> Session:
    session = Session.of(Recipe(seed=SEED, chunks=(2, 1)))
    for row in rows:
        session.add({name: value for name, value in row.items() if name != "enabled"})
        if "enabled" in row:
            session.enable(row=len(session.draft.rows) - 1, enabled=row["enabled"])
    return session


def edited(rows: Rows) -> Session:
    """Other rows first, which become those of the list one parameter after the other, as sliders are moved."""
    session = added([{"kind": "peak", "levels": 9} for _ in rows])
    for at, row in enumerate(rows):
        session.change(row=at, entry={"kind": row["kind"], "levels": 7})
        session.change(row=at, entry={**row, "levels": 1})  # is refused, and shown
        assert session.problem
        for levels in range(2, 9):
            session.change(row=at, entry={**row, "levels": levels}, gesture="slider")
        session.change(row=at, entry=row)
        session.enable(row=at, enabled=row.get("enabled", True))
    return session


def moved(rows: Rows) -> Session:
    """From the last to the first, each moved up."""
    session = added([])
    for row in reversed(rows):
        act(session, [{"do": "add", "entry": {name: row[name] for name in row if name != "enabled"}}], 0)
        session.enable(row=len(session.draft.rows) - 1, enabled=row.get("enabled", True))
        session.move(row=len(session.draft.rows) - 1, to=0)
    return session


def saved_and_opened(rows: Rows, folder: Path, suffix: str) -> Session:
    """Half of it, saved, opened again, and completed."""
    document = Document(session=added(rows[: len(rows) // 2]), journal=DraftFile(name=str(folder)))
    document.save(folder / f"list{suffix}")
    session = session_of_file(folder / f"list{suffix}")
    for row in rows[len(rows) // 2 :]:
        session.add(row)
        session.enable(row=len(session.draft.rows) - 1, enabled=row.get("enabled", True))
    session.set(name="name", value=None)
    return session


@pytest.mark.parametrize("what", LISTS)
def test_the_page_makes_the_maps_of_a_list_in_python(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    rows = LISTS[what]
    expected = recipe_of(rows)
    for session in (
        added(rows),
        edited(rows),
        moved(rows),
        saved_and_opened(rows, tmp_path, ".yaml"),
        saved_and_opened(rows, tmp_path, ".json"),
    ):
        assert session.problem is None
        assert session.recipe == expected
        for index in range(3):
            assert (build(session.recipe, index).levels == build(expected, index).levels).all()
    assert what == "given places" or (build(expected, 0).levels != build(expected, 1).levels).any()


@pytest.mark.parametrize("what", LISTS)
def test_page_shell_python_and_yaml_write_the_same_bytes(what: str, tmp_path: Path) -> None:
    rows = LISTS[what]
    page = added(rows).recipe
    rsegen.generate(page, tmp_path / "page")
    rsegen.generate(recipe_of(rows), tmp_path / "python")
    shell = [word for row in rows for word in ("--obstacle", row_text(decode_obstacle(row)))]
    assert not any("key=" in word for word in shell)
    assert main(["generate", "--seed", str(SEED), "--chunks", "2x1", *shell, "-o", str(tmp_path / "shell")]) == 0
    by_hand = tmp_path / "by_hand.yaml"
    by_hand.write_text(yaml.safe_dump({"seed": SEED, "chunks": [2, 1], "obstacles": [dict(row) for row in rows]}))
    rsegen.generate(load(by_hand), tmp_path / "yaml")
    of_page = contents(tmp_path / "page")
    assert len(of_page) > 4
    assert contents(tmp_path / "python") == of_page
    assert contents(tmp_path / "shell") == of_page
    assert contents(tmp_path / "yaml") == of_page


@pytest.mark.parametrize("what", LISTS)
@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_what_the_page_writes_is_the_list_as_people_write_it(what: str, suffix: str, tmp_path: Path) -> None:
    recipe = added(LISTS[what]).recipe
    text = text_after("", recipe, suffix)
    assert "key" not in text
    assert "key" not in command_line(recipe, "worlds") + python_code(recipe, "worlds")
    (tmp_path / f"a{suffix}").write_text(text)
    assert load(tmp_path / f"a{suffix}") == recipe


def test_rows_that_have_keys_keep_theirs_through_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    path = tmp_path / "mine.yaml"
    keys = ["obstacle-1", recipe_of([PEAK]).obstacles[0].key]  # of an earlier page; and one that it would have anyway
    rows = [{**BARRIER, "key": keys[0]}, {**PEAK, "key": keys[1]}, {"kind": "random", "levels": 2}]
    path.write_text(yaml.safe_dump({"seed": SEED, "obstacles": rows}, sort_keys=False))
    document = Document.of_file(path)
    before = document.session.recipe
    free = before.obstacles[2].key
    for at, row in enumerate(rows):
        document.session.change(row=at, entry={**row, "levels": 3 + at})
    assert [row["key"] for row in document.session.draft.rows[:2]] == keys
    assert document.session.draft.rows[2]["key"] != free
    document.save()
    again = load(path)
    assert [obstacle.key for obstacle in again.obstacles[:2]] == keys
    assert path.read_text().count("key:") == 2
    ends = [rsegen.recipe.building.placed(recipe, recipe.obstacles[1], 0)[:2] for recipe in (before, again)]
    assert ends[0] == ends[1]


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_that_is_opened_is_the_example(name: str) -> None:
    recipe = load(EXAMPLES[name])
    session = session_of_file(EXAMPLES[name])
    assert session.recipe == recipe
    assert session.draft.own == ({"wandering-peak"} if name == "mixed-course" else frozenset())
    session.add(PEAK)
    session.remove(row=len(recipe.obstacles))
    assert session.recipe == recipe


def test_a_draft_after_a_crash_has_the_keys_that_were_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    draft = draft_of(Recipe(seed=1, obstacles=[rsegen.Peak(levels=5, key="mine"), rsegen.Peak(levels=4)]))
    assert draft.own == {"mine"}
    DraftFile(name="a").write(draft, "")
    recovered = DraftFile(name="a").recovered()
    assert recovered is not None
    assert recovered[0] == draft
