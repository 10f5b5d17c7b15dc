"""Documents: what is on disk is never lost, neither what a person edits nor what somebody else wrote."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from base64 import b64decode
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Peak, Random, Recipe, load
from rsegen.errors import FileError, ParameterError, UserError
from rsegen.page import documents as calls
from rsegen.page.calls import Question
from rsegen.page.commands import _place
from rsegen.page.host import MOST_DOCUMENTS, Host, Opened
from rsegen.page.model.session import Session
from rsegen.page.scenes import DocumentMap, ghost, scene
from rsegen.recipe.building import build, owners

PEAK = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}
TEXT = "# mine\nseed: 3\nname: course\nobstacles:\n  - {kind: random, levels: 3} # rough\n"


@pytest.fixture
def host(tmp_path: Path) -> Host:
    (tmp_path / "course.yaml").write_text(TEXT)
    return Host(folder=tmp_path)


@pytest.fixture
def opened(host: Host) -> Opened:
    return host.opened(calls.open(host, what="course.yaml")["doc"])


def act(opened: Opened, *actions: Mapping[str, Any], index: int = 0) -> calls.EditedState:
    return calls.edit(opened, actions=[dict(action) for action in actions], index=index)


def drafts(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*")) if folder.exists() else []


# Files.


def test_a_file_is_one_document_for_all_pages_that_open_it(host: Host, opened: Opened) -> None:
    assert calls.open(host, what="./course.yaml")["doc"] == opened.id
    assert calls.open(host, what="")["doc"] != calls.open(host, what="")["doc"]


def test_the_folder_of_a_map_is_opened_and_another_folder_is_worked_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (made,) = rsegen.generate(Recipe(seed=1), "worlds").maps
    assert _place(str(made.folder)) == (tmp_path, str(made.folder))
    assert _place("worlds") == (tmp_path / "worlds", "")


def test_a_document_is_not_saved_over_another_that_is_open(host: Host, opened: Opened) -> None:
    (host.folder / "other.yaml").write_text(TEXT)
    calls.open(host, what="other.yaml")
    act(opened, {"do": "add", "entry": PEAK})
    with pytest.raises(UserError, match=r"other\.yaml: is open as another document; choose another name"):
        calls.save(host, doc=opened.id, path="other.yaml", replace=True)
    assert (host.folder / "other.yaml").read_text() == TEXT
    assert not calls.save(host, doc=opened.id, path="course.yaml")["unsaved"]


def test_switched_off_rows_and_comments_are_saved(host: Host, opened: Opened) -> None:
    state = act(opened, {"do": "enable", "row": 0, "enabled": False})
    assert (state["unsaved"], state["rows"][0]["enabled"]) == (True, False)
    assert not calls.save(host, doc=opened.id)["unsaved"]
    saved = (host.folder / "course.yaml").read_text()
    assert saved.startswith("# mine\n")
    assert "enabled: false" in saved
    assert load(host.folder / "course.yaml") == opened.session.recipe


def test_what_somebody_else_wrote_is_noticed_and_not_overwritten(host: Host, opened: Opened) -> None:
    act(opened, {"do": "set", "name": "unit_cm", "value": 5})
    path = host.folder / "course.yaml"
    path.write_text("seed: 4\n")
    assert opened.document.check_file()
    assert not opened.document.check_file()
    with pytest.raises(Question) as asked:
        calls.save(host, doc=opened.id)
    assert asked.value.kind == "changed"
    assert path.read_text() == "seed: 4\n"
    assert calls.state(opened)["changed_on_disk"]
    assert not calls.save(host, doc=opened.id, replace=True)["changed_on_disk"]
    assert load(path).unit_cm == 5


def test_a_file_of_another_time_with_the_same_text_has_not_changed(opened: Opened) -> None:
    assert opened.document.path
    os.utime(opened.document.path, (1, 1))
    assert not opened.document.check_file()
    assert not opened.document.changed_on_disk


def test_what_was_in_a_file_that_is_removed_is_not_saved_until_it_is_again(
    host: Host, opened: Opened, state_folder: Path
) -> None:
    path = host.folder / "course.yaml"
    text = path.read_text()
    path.unlink()
    assert opened.document.check_file()
    assert not opened.document.check_file()
    state = calls.state(opened)
    assert (state["unsaved"], state["file_is_gone"], state["changed_on_disk"]) == (True, True, False)
    assert drafts(state_folder)
    path.write_text(text)  # it comes back
    assert opened.document.check_file()
    state = calls.state(opened)
    assert (state["unsaved"], state["file_is_gone"], state["changed_on_disk"]) == (False, False, False)
    assert not drafts(state_folder)
    path.unlink()
    assert opened.document.check_file()
    state = calls.save(host, doc=opened.id)
    assert (state["unsaved"], state["file_is_gone"], path.read_text()) == (False, False, text)


def test_a_file_is_read_again_and_undo_takes_that_back(host: Host, opened: Opened) -> None:
    act(opened, {"do": "set", "name": "unit_cm", "value": 5})
    (host.folder / "course.yaml").write_text("seed: 4\n")
    state = calls.reload(opened)
    assert (state["values"]["seed"], state["unsaved"], state["changed_on_disk"]) == (4, False, False)
    assert act(opened, {"do": "undo"})["values"]["unit_cm"] == 5


def test_a_broken_file_is_not_taken_over(host: Host, opened: Opened) -> None:
    (host.folder / "course.yaml").write_text("seed: [")
    with pytest.raises(FileError):
        calls.reload(opened)
    assert opened.session.recipe.seed == 3


def test_another_file_is_asked_about_before_it_is_replaced(host: Host, opened: Opened) -> None:
    (host.folder / "other.yaml").write_text("seed: 9\n")
    with pytest.raises(Question, match=r"other\.yaml exists already"):
        calls.save(host, doc=opened.id, path="other.yaml")
    assert (host.folder / "other.yaml").read_text() == "seed: 9\n"
    assert calls.save(host, doc=opened.id, path="other.yaml", replace=True)["title"] == "other.yaml"


def test_maps_are_called_as_their_file_unless_they_have_a_name(host: Host) -> None:
    opened = host.open(Session.of(Recipe(seed=1)))
    assert calls.save(host, doc=opened.id, path="hills.yaml")["name"] == "hills"
    assert calls.save(host, doc=opened.id, path="dunes.json")["name"] == "dunes"
    act(opened, {"do": "set", "name": "name", "value": "mine"})
    assert calls.save(host, doc=opened.id, path="more.yaml")["name"] == "mine"
    assert json.loads((host.folder / "dunes.json").read_text())["name"] == "dunes"


@pytest.mark.parametrize("path", ["../out.yaml", "/etc/out.yaml", "sub/../../out.yaml", "no/such.yaml", ".hidden.yaml"])
def test_nothing_is_written_outside_the_folder(host: Host, opened: Opened, path: str) -> None:
    with pytest.raises(FileError):
        calls.save(host, doc=opened.id, path=path)
    with pytest.raises(FileError):
        calls.save(host, doc=opened.id, path="course.txt")


def test_links_lead_nowhere(host: Host, opened: Opened, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside")
    (host.folder / "link").symlink_to(outside)
    (host.folder / "loop").symlink_to("loop")
    for path in ("link/out.yaml", "loop", "loop/out.yaml"):
        with pytest.raises(FileError):
            calls.save(host, doc=opened.id, path=path)
        with pytest.raises(FileError):
            calls.open(host, what=path)


def test_an_example_is_opened_as_a_copy(host: Host) -> None:
    opened = host.opened(calls.open(host, what="figure-7")["doc"])
    state = calls.state(opened)
    assert (state["title"], state["path"], state["unsaved"]) == ("copy of figure-7", None, False)
    with pytest.raises(UserError, match="choose a name"):
        calls.save(host, doc=opened.id)
    calls.save(host, doc=opened.id, path="mine.yaml")
    assert (host.folder / "mine.yaml").read_text().startswith("# The field that the paper built")


def test_a_misspelt_example_is_named(host: Host) -> None:
    with pytest.raises(FileError, match="did you mean 'figure-7'"):
        calls.open(host, what="figur-7")


def test_what_was_sent_is_opened_as_a_copy(host: Host) -> None:
    (host.uploads / "sent.yaml").write_text(TEXT)
    opened = host.opened(calls.open(host, what=str(host.uploads / "sent.yaml"))["doc"])
    host.close()
    assert (calls.state(opened)["path"], calls.state(opened)["title"]) == (None, "copy of sent.yaml")


def test_a_map_of_a_data_set_is_opened(host: Host) -> None:
    rsegen.make_dataset(Recipe(seed=1, maps=3, obstacles=[Random(levels=3)]), host.folder / "maps")
    state = calls.state(host.opened(calls.open(host, what="maps#2")["doc"]))
    assert (state["title"], state["path"], state["first_map"]) == ("maps#2", None, 2)
    assert state["data_set"] == {"folder": "maps", "place": 2, "maps": 3}


def test_a_drive_is_opened_as_a_drive_and_its_map(host: Host) -> None:
    drive = host.folder / "a drive"
    drive.mkdir()
    rsegen.save(Recipe(seed=1), drive / "recipe.json")
    assert calls.open(host, what="a drive")["play"] == ""
    (drive / "drive.json").write_text("{}")
    for what in ("a drive", "a drive/recipe.json", str(drive)):
        assert calls.open(host, what=what)["play"] == "a drive"


@pytest.mark.parametrize("what", ["", "mixed-course", "mine.yaml", "maps#2"])
def test_what_opened_a_document_opens_it_again_in_another_server(what: str, host: Host) -> None:
    rsegen.make_dataset(Recipe(seed=1, maps=3), host.folder / "maps")
    rsegen.save(Recipe(seed=7), host.folder / "mine.yaml")
    opened = host.opened(calls.open(host, what=what)["doc"])
    state = calls.state(opened)
    assert state["opens"] == what
    later = Host(folder=host.folder)
    again = calls.state(later.opened(calls.open(later, what=state["opens"])["doc"]))
    assert (again["title"], again["maps"], again["first_map"]) == (state["title"], state["maps"], state["first_map"])
    assert again["doc"] != state["doc"], "an address of the first server names no document of the second"
    calls.save(host, doc=opened.id, path="saved.yaml")
    assert calls.state(opened)["opens"] == "saved.yaml"


def test_an_invalid_draft_is_not_saved(host: Host, opened: Opened) -> None:
    state = act(opened, {"do": "set", "name": "unit_cm", "value": -1})
    assert state["problem"]
    assert state["problem"]["where"] == "unit_cm"
    with pytest.raises(ParameterError):
        calls.save(host, doc=opened.id)
    assert (host.folder / "course.yaml").read_text() == TEXT


def test_many_documents_are_refused_only_if_none_can_be_closed(host: Host) -> None:
    for _ in range(MOST_DOCUMENTS + 5):
        host.open(Session.of(Recipe(seed=1)))
    assert len(host.documents) == MOST_DOCUMENTS
    for opened in host.documents.values():
        act(opened, {"do": "add", "entry": PEAK})
    with pytest.raises(UserError, match="save or close some"):
        host.open(Session.of(Recipe(seed=1)))


# The journal.


def test_a_draft_is_on_disk_as_long_as_it_is_not_in_its_file(host: Host, opened: Opened, state_folder: Path) -> None:
    assert drafts(state_folder) == []
    act(opened, {"do": "add", "entry": PEAK})
    assert len(drafts(state_folder)) == 1
    act(opened, {"do": "undo"})
    assert drafts(state_folder) == []
    act(opened, {"do": "redo"})
    calls.save(host, doc=opened.id)
    assert drafts(state_folder) == []
    act(opened, {"do": "add", "entry": PEAK})
    calls.close(host, doc=opened.id)
    assert drafts(state_folder) == []


_EDITOR = """
import os, signal, sys
from pathlib import Path
from rsegen.page import documents as calls
from rsegen.page.host import Host

host = Host(folder=Path(sys.argv[1]))
opened = host.opened(calls.open(host, what=sys.argv[2])["doc"])
print(calls.state(opened)["recovered"], flush=True)
calls.edit(opened, actions=[{"do": "set", "name": "unit_cm", "value": 5}, {"do": "clear"}])
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
@pytest.mark.parametrize("what", ["course.yaml", ""])
def test_changes_survive_a_kill(host: Host, what: str, state_folder: Path) -> None:
    words = [sys.executable, "-c", _EDITOR, str(host.folder), what]
    killed = subprocess.run(words, check=False, capture_output=True, text=True)
    assert (killed.returncode, killed.stdout) == (-signal.SIGKILL, "None\n"), killed.stderr
    assert (host.folder / "course.yaml").read_text() == TEXT
    opened = host.opened(calls.open(host, what=what)["doc"])
    state = calls.state(opened)
    assert state["recovered"]
    assert (state["values"]["unit_cm"], state["unsaved"], state["rows"]) == (5, True, [])
    state = act(opened, {"do": "undo"})
    assert (state["values"]["unit_cm"], state["unsaved"], state["recovered"]) == (10, False, None)
    assert drafts(state_folder) == []


@pytest.mark.slow
def test_changes_of_an_example_are_brought_back_there_and_in_a_new_recipe_and_nowhere_else(host: Host) -> None:
    words = [sys.executable, "-c", _EDITOR, str(host.folder), "peak"]
    subprocess.run(words, check=False, capture_output=True)

    def recovered(what: str) -> bool:
        state = calls.state(host.opened(calls.open(host, what=what)["doc"]))
        assert bool(state["recovered"]) == state["unsaved"] == (state["values"]["unit_cm"] == 5)
        return state["unsaved"]

    assert not recovered("mixed-course")
    assert recovered("peak")
    subprocess.run(words, check=False, capture_output=True)
    host.documents.clear()
    assert recovered("")


@pytest.mark.slow
def test_a_draft_does_not_go_over_a_file_that_changed_since(host: Host, state_folder: Path) -> None:
    words = [sys.executable, "-c", _EDITOR, str(host.folder), "course.yaml"]
    subprocess.run(words, check=False, capture_output=True)
    newer = TEXT.replace("seed: 3", "seed: 6")
    (host.folder / "course.yaml").write_text(newer)
    opened = host.opened(calls.open(host, what="course.yaml")["doc"])
    state = calls.state(opened)
    assert state["recovered"]
    assert (state["values"]["unit_cm"], state["changed_on_disk"]) == (5, True)
    act(opened, {"do": "set", "name": "unit_cm", "value": 7})
    with pytest.raises(Question, match="changed by another program after you opened it"):
        calls.save(host, doc=opened.id)
    assert (host.folder / "course.yaml").read_text() == newer
    # A second crash does not make it forget.
    left, own = sorted(drafts(state_folder), key=lambda name: f"-{os.getpid()}." in name)
    (state_folder / own).replace(state_folder / left)
    again = host.__class__(folder=host.folder)
    assert calls.state(again.opened(calls.open(again, what="course.yaml")["doc"]))["changed_on_disk"]
    # What the file has now, taken over or reached by undo, is no conflict any more.
    assert calls.reload(opened)["changed_on_disk"] is False
    assert calls.save(host, doc=opened.id)["values"]["seed"] == 6


@pytest.mark.slow
def test_changes_of_a_process_that_still_runs_are_left_to_it(host: Host, state_folder: Path) -> None:
    waits = _EDITOR.replace("os.kill(os.getpid(), signal.SIGKILL)", "print('waits', flush=True); sys.stdin.read()")
    words = [sys.executable, "-c", waits, str(host.folder), "course.yaml"]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout
        assert [other.stdout.readline(), other.stdout.readline()] == ["None\n", "waits\n"]
        opened = host.opened(calls.open(host, what="course.yaml")["doc"])
        assert calls.state(opened)["recovered"] is None
        assert len(drafts(state_folder)) == 1
        other.kill()
        os.waitid(os.P_PID, other.pid, os.WEXITED | os.WNOWAIT)  # it has ended, and nobody has asked how
        assert opened.document.journal.recovered() is not None


def test_what_another_program_left_in_the_journal_is_not_taken(host: Host, opened: Opened, state_folder: Path) -> None:
    act(opened, {"do": "add", "entry": PEAK})
    (written,) = state_folder.iterdir()
    dead = written.with_name(written.name.rpartition("-")[0] + "-999999999.json")
    for content in ("", "[", "5", '{"name": 5}', "[" * 100_000, '{"rows": 1, "values": 2, "name": ""}'):
        dead.write_text(content)
        assert opened.document.journal.recovered() is None or written.exists()
    written.unlink()
    assert opened.document.journal.recovered() is None


def test_a_full_disk_ends_nobodys_work(opened: Opened, state_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/nowhere")
    assert act(opened, {"do": "clear"})["rows"] == []
    assert "cannot be kept" in opened.document.journal.failed
    assert drafts(state_folder) == []


# Actions.


def test_actions_are_applied_all_or_none(opened: Opened) -> None:
    before = opened.session.draft
    for wrong in (
        {"do": "nothing"},
        {"do": "remove", "row": 7},
        {"do": "remove", "row": -1},
        {"do": "remove", "row": True},
        {"do": "remove"},
        {"do": "remove", "row": 0, "more": 1},
        {"do": "set", "name": "nothing", "value": 1},
        {"do": "move_end", "row": 0, "end": "middle", "cell": [1, 1]},
        {"do": "move_end", "row": 0, "end": "last", "cell": [10, 1]},
        {"do": "paint", "row": -1, "cells": [[0, 0]], "level": 32768},
        {"do": "paint", "row": -1, "cells": [[0]], "level": 1},
        {"do": ["add"]},
    ):
        with pytest.raises(ParameterError) as refused:
            act(opened, {"do": "clear"}, wrong)
        assert refused.value.where.startswith("actions[1]")
        assert opened.session.draft == before
        assert not opened.session.can_undo


def test_each_action_does_what_its_name_says(opened: Opened) -> None:
    state = act(opened, {"do": "add", "entry": PEAK}, {"do": "duplicate", "row": 1}, {"do": "move", "row": 2, "to": 0})
    assert ([row["entry"]["kind"] for row in state["rows"]], state["selected"]) == (["peak", "random", "peak"], 0)
    assert len({row["entry"]["key"] for row in state["rows"]}) == 3
    state = act(opened, {"do": "change", "row": 0, "entry": {**PEAK, "levels": 9}}, {"do": "remove", "row": 2})
    assert [row["entry"]["levels"] for row in state["rows"]] == [9, 3]
    state = act(opened, {"do": "paint", "row": 0, "cells": [[0, 0], [1, 0]], "level": 2, "gesture": "a"})
    state = act(opened, {"do": "paint", "row": state["selected"], "cells": [[2, 0]], "level": 2, "gesture": "a"})
    assert state["rows"][2]["entry"]["rows"] == ["2 2 2"]
    state = act(opened, {"do": "undo"})
    assert len(state["rows"]) == 2
    state = act(opened, {"do": "redo"}, {"do": "reroll"})
    assert (len(state["rows"]), state["values"]["seed"] == 3) == (3, False)


def test_ends_are_those_of_the_map_shown_and_are_fixed_there(opened: Opened) -> None:
    act(opened, {"do": "set", "name": "maps", "value": 9}, {"do": "add", "entry": {"kind": "peak", "levels": 3}})
    ends = [calls.state(opened, index=index)["rows"][1]["ends"] for index in range(9)]
    assert len({json.dumps(each) for each in ends}) > 1
    before = build(opened.session.recipe, 4)
    state = act(opened, {"do": "fix", "row": 1, "index": 4}, index=4)
    assert {name: state["rows"][1]["entry"][name] for name in ("first", "last")} == ends[4]
    assert build(opened.session.recipe, 4) == before


# Scenes.


def _owners(shown: DocumentMap) -> Any:
    return np.frombuffer(b64decode(shown["owners"]), dtype="<i2").reshape(shown["cells"])


def test_blocks_know_the_row_that_made_them(opened: Opened) -> None:
    act(opened, {"do": "set", "name": "boundary", "value": "none"}, {"do": "add", "entry": PEAK})
    act(opened, {"do": "enable", "row": 0, "enabled": False})
    shown = scene(opened)
    alone = build(replace(opened.session.recipe, obstacles=opened.session.recipe.obstacles[1:])).levels
    assert np.array_equal(_owners(shown), np.where(alone > 0, 1, -1))
    assert [handle["row"] for handle in shown["handles"]] == [1]


def test_the_owner_is_the_last_that_replaced_or_changed_a_level() -> None:
    floor, low, high = Random(levels=2), Peak(levels=2, blend="max"), Peak(levels=9, blend="max")
    recipe = Recipe(seed=1, obstacles=[floor, *(replace(each, first=(2, 2), last=(7, 7)) for each in (low, high, low))])
    found = owners(recipe, 0)
    assert set(np.unique(found)) <= {0, 1, 2}
    assert np.array_equal(found == 2, build(recipe).blocks > 1)
    assert owners(replace(recipe, difficulty=0.2, max_step=1), 0).tolist() == found.tolist()
    assert (owners(Recipe(seed=1), 0) == -1).all()


def test_an_invalid_draft_shows_the_last_valid_map(opened: Opened) -> None:
    before = scene(opened)
    act(opened, {"do": "set", "name": "chunk_size", "value": 0}, {"do": "clear"})
    after = scene(opened)
    assert (after["content"], after["revision"]) == (before["content"], 2)
    assert set(_owners(after).ravel()) == {-1}


@pytest.mark.slow
def test_large_maps_are_shown_coarser(host: Host) -> None:
    opened = host.open(Session.of(Recipe(seed=1, chunk_size=900, obstacles=[Random(levels=3)])))
    shown = scene(opened)
    assert shown["factor"] == 3
    assert shown["cells"] == (300, 300)
    assert shown["block_width"] == pytest.approx(0.3)
    assert sum(each["count"] for each in shown["palette"] if each["level"] is not None) == 900 * 900
    assert _owners(shown).shape == (300, 300)


def test_a_map_that_is_too_large_is_refused(host: Host) -> None:
    opened = host.open(Session.of(Recipe(seed=1, chunk_size=1000, chunks=(10**6, 10**6), obstacles=[Random(levels=3)])))
    with pytest.raises(rsegen.UserError, match="chunks: a map of"):
        scene(opened)


def test_a_ghost_is_the_map_as_it_is_when_the_obstacle_is_added(host: Host) -> None:
    opened = host.open(Session.of(Recipe(seed=1, chunk_size=12, obstacles=[Random(levels=3)])))
    entry = {"kind": "peak", "levels": 5}
    before = opened.session.draft
    shown = ghost(opened, entry=entry)
    assert opened.session.draft == before
    act(opened, {"do": "add", "entry": entry})
    added = scene(opened)
    assert {name: shown[name] for name in ("content", "owners", "handles")} == {
        name: added[name] for name in ("content", "owners", "handles")
    }


def test_instead_of_a_map_that_another_page_took_away_the_first_is_shown(host: Host) -> None:
    opened = host.open(Session.of(Recipe(seed=1, first_map=4, maps=2)))
    assert scene(opened, index=5, page="one")["index"] == 5
    act(opened, {"do": "set", "name": "maps", "value": 1})
    assert scene(opened, index=5, page="one")["index"] == 4


def test_texts_say_the_same_in_three_languages(host: Host, opened: Opened) -> None:
    act(opened, {"do": "enable", "row": 0, "enabled": False})
    texts = calls.texts(opened)
    assert texts["recipe"].startswith("# mine\n")
    assert "enabled=no" in texts["shell"]
    assert "enabled=False" in texts["python"]
