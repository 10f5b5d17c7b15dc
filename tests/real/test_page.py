"""A page drives a robot in a real Gazebo, plays what was recorded, and leaves nothing when it is stopped."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import psutil
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from rsegen.driving import page as playback
from rsegen.gazebo import sdf
from rsegen.page import documents as hosting
from rsegen.page import runs
from rsegen.page.host import Host
from rsegen.page.service import Service
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import compose
from rsegen.simulators.base import Installation
from rsegen.simulators.poses import DROP_HEIGHT
from rsegen.simulators.server import running_server
from tests.page.test_page import Page
from tests.support.browser import chromium
from tests.support.patience import until

if TYPE_CHECKING:
    from selenium.webdriver import Chrome


@pytest.fixture
def host(tmp_path: Path, gazebo_classic: Installation) -> Any:
    made = Host(folder=tmp_path)
    yield made
    made.jobs.close()


def now(host: Host, job: dict[str, Any]) -> dict[str, Any]:
    return next(each for each in host.jobs.listed() if each["id"] == job["id"])


@pytest.mark.long(reason="a drive in MuJoCo is played in make test")
def test_a_drive_of_a_page_is_played_as_gazebo_recorded_it(host: Host) -> None:
    doc = hosting.open(host, what="peak")["doc"]
    values = {"robot": "burger", "duration": 2, "simulator": "classic", "seed": 3, "predict": False}
    job = runs.run(host, doc=doc, command="drive", values=values, output="drive")
    until(lambda: now(host, job)["state"] != "running")
    done = now(host, job)
    assert (done["state"], done["done"], done["total"]) == ("done", 2, 2)
    assert {"path": "drive", "name": "drive", "kind": "drive"} in done["files"]
    (robot,) = playback.playback(host, path="drive")["robots"]
    recorded = np.loadtxt(host.folder / "drive" / f"{robot['name']}.csv", delimiter=",", skiprows=1)
    assert np.array_equal(np.column_stack([robot["seconds"], robot["poses"]]), recorded)
    assert robot["robot"] == "burger"


@pytest.mark.long(reason="tests/page/test_jobs.py cancels one")
def test_a_drive_that_is_cancelled_leaves_no_server_and_no_folder(host: Host) -> None:
    doc = hosting.open(host, what="peak")["doc"]
    values = {"duration": 500, "simulator": "classic", "predict": False}
    before = set(psutil.Process().children(recursive=True))  # of other tests
    job = runs.run(host, doc=doc, command="drive", values=values, output="drive")
    until(lambda: bool(now(host, job)["done"]))
    runs.cancel(host, job=job["id"])
    until(lambda: now(host, job)["state"] == "cancelled")
    assert set(psutil.Process().children(recursive=True)) <= before
    assert list(host.folder.iterdir()) == []


@pytest.fixture(scope="module")
def chrome() -> Iterator[Chrome]:
    with chromium() as opened:
        yield opened


@pytest.fixture
def page(chrome: Chrome, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    """A page of a server of its own, with a peak."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "folder").mkdir()
    service = Service(host=Host(folder=tmp_path / "folder"), port=0, keep=True)
    service.start()
    yield Page(chrome, service.url(), "peak")
    service.close()


def run(page: Page, command: str, **values: str) -> None:
    """Run a command from the menu by its form, and wait until it has ended well."""
    page.choose("Run", command)
    page.js("document.querySelector('dialog details').open = true")  # the simulator is under More
    started(page, **values)


def started(page: Page, **values: str) -> None:
    for label, value in values.items():
        place = f'dialog [data-field="{label}"]'
        field = page.chrome.find_element(By.CSS_SELECTOR, f"{place} input:not([type=range]), {place} select")
        field.send_keys(value) if field.tag_name == "select" else field.send_keys(Keys.CONTROL, "a", Keys.NULL, value)
    before = page.js("return state.jobs.value.length")
    page.chrome.find_element(By.CSS_SELECTOR, "dialog button[type=submit]").click()
    until(lambda: page.js("return state.jobs.value.length") > before)
    until(lambda: page.js("return state.jobs.value[0].state") != "running")
    assert page.js("return state.jobs.value[0].state") == "done", page.js("return state.jobs.value[0].lines")


@pytest.mark.slow
@pytest.mark.long(reason="a server and a browser more")
@pytest.mark.usefixtures("gazebo_classic")
def test_a_drive_of_the_form_is_played_over_the_blocks(page: Page) -> None:
    run(page, "drive over a map", Duration="2", Simulator="classic")
    page.chrome.find_element(By.CSS_SELECTOR, "dialog footer .primary").click()
    until(lambda: page.js("return state.second.value > 0"))
    assert page.js("return window.rsegen.solid.player.robots.length") == 1
    (drive,) = page.js("return state.playbacks.value")
    assert drive["simulator"].startswith("Gazebo Classic")
    assert drive["duration"] == pytest.approx(2, abs=0.1)
    until(lambda: page.js("return state.second.value === state.playbacks.value[0].duration"))
    x = page.js("return window.rsegen.solid.player.robots[0].position.x")
    assert x == pytest.approx(drive["robots"][0]["poses"][-1][0], abs=1e-6)
    assert x > drive["robots"][0]["poses"][0][0] + 0.05
    page.open_file("drives")
    until(lambda: page.js("return state.playbacks.value.length === 2"))


@pytest.mark.slow
@pytest.mark.long(reason="a server and a browser more")
def test_the_map_and_a_robot_at_its_place_are_sent_into_a_running_gazebo(
    page: Page, gazebo_classic: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(compose(load(EXAMPLES["peak"])), ()))))
    with running_server(gazebo_classic, world) as server, server.connect() as live:
        monkeypatch.setenv("GAZEBO_MASTER_URI", server.environment["GAZEBO_MASTER_URI"])
        run(page, "add to a running simulation", Simulator="classic")
        assert set(live.poses()) == {"ground_plane", "peak_0000"}
        page.js("state.dialog.value = null; state.tab.value = 'robot'; state.chooseRobot('burger')")
        until(lambda: page.js("return Boolean(state.drawing.value)"))
        page.js("state.settle(0.45, 0.05)")
        until(lambda: page.js("return state.pose.value?.stands"))
        page.button("Spawn it in a running Gazebo").click()
        started(page)
        rest, at = page.js("return state.pose.value"), live.poses()["burger"]
        assert (at.x, at.y, at.z) == pytest.approx((rest["x"], rest["y"], rest["z"] + DROP_HEIGHT), abs=1e-3)
        assert set(live.poses()) == {"ground_plane", "peak_0000", "burger"}
