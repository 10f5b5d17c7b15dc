"""The page in an output cell of a notebook."""

from __future__ import annotations

import re
from functools import partial
from http.server import HTTPServer, SimpleHTTPRequestHandler
from pathlib import Path
from threading import Thread

import pytest

import rsegen
from rsegen import Recipe
from tests.page.client import Client
from tests.support.browser import chromium, complaints


def test_the_page_is_shown_and_gives_the_recipe_back(tmp_path: Path) -> None:
    with rsegen.gui(Recipe(seed=8), folder=tmp_path, port=0) as gui:
        html = gui._repr_html_()
        assert gui.url.replace("&", "&amp;") in html
        ((port, token, doc),) = re.findall(r":(\d+)/\?token=([\w-]+)(?:&open=[^&]*)?&doc=(d[\w-]+)", gui.url)
        Client(int(port), token).call("edit", doc=doc, actions=[{"do": "set", "name": "unit_cm", "value": 5}])
        assert (gui.recipe.seed, gui.recipe.unit_cm) == (8, 5)


def test_a_path_or_nothing_is_opened_too(tmp_path: Path) -> None:
    (tmp_path / "course.yaml").write_text("seed: 3\n")
    for what, seed in (("course.yaml", 3), ("figure-7", 7)):
        with rsegen.gui(what, folder=tmp_path, port=0) as gui:
            assert gui.recipe.seed == seed
    with rsegen.gui(folder=tmp_path, port=0) as gui:
        assert gui.recipe.obstacles == ()
    with pytest.raises(rsegen.UserError, match="neither a file"):
        rsegen.gui("nothing.yaml", folder=tmp_path)


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that says nothing."""

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.mark.slow
def test_a_browser_shows_it_inside_of_a_page_of_jupyter_s_server(tmp_path: Path) -> None:
    with rsegen.gui(Recipe(seed=8), folder=tmp_path, port=0) as gui, chromium() as browser:
        (tmp_path / "cell.html").write_text(f"<!doctype html><title>cell</title>{gui._repr_html_()}")
        jupyter = HTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path)))
        Thread(target=jupyter.serve_forever, daemon=True).start()
        try:
            browser.get(f"http://localhost:{jupyter.server_port}/cell.html")
            browser.switch_to.frame(0)
            assert browser.execute_script("return document.getElementById('page').childElementCount") > 0
            assert not [line for line in complaints(browser) if "Content" in line and "Policy" in line]
        finally:
            jupyter.shutdown()
            jupyter.server_close()
