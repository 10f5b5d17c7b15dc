"""The frozen page in a browser: silent, without the internet, obedient to nobody; tests/page judges the rest."""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from pypdf import PdfReader

import rsegen
from rsegen.recipe.examples import EXAMPLES
from tests.page.browser.test_page import HOSTILE
from tests.support.browser import chromium, complaints, requests

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.slow
FRAMED = rsegen.load(EXAMPLES["framed-2x2"])


@pytest.fixture(scope="module")
def opened() -> Iterator[Chrome]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def browser(opened: Chrome) -> Chrome:
    """A browser with an empty page, and nothing in its logs."""
    opened.switch_to.default_content()
    opened.get("about:blank")
    requests(opened), complaints(opened)
    return opened


def show(browser: Chrome, html: str | bytes, folder: Path) -> Path:
    path = folder / "map.html"
    path.write_bytes(html if isinstance(html, bytes) else html.encode())
    browser.get(path.as_uri())
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    return path


def test_a_page_is_shown_without_a_complaint_or_a_request(browser: Chrome, tmp_path: Path) -> None:
    path = show(browser, rsegen.view(FRAMED).html, tmp_path)
    assert browser.execute_script("return document.getElementById('page').childElementCount") > 0
    assert complaints(browser) == []
    assert {address for address in requests(browser) if not address.startswith(("data:", "blob:"))} == {path.as_uri()}


def test_a_page_without_scripts_says_what_it_needs(browser: Chrome, tmp_path: Path) -> None:
    (tmp_path / "page.html").write_bytes(rsegen.view(FRAMED).html)
    show(browser, '<!doctype html><title>mail</title><iframe sandbox src="page.html"></iframe>', tmp_path)
    pdf = b64decode(browser.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert "This page needs JavaScript" in PdfReader(BytesIO(pdf)).pages[0].extract_text()


def test_a_hostile_recipe_is_text(browser: Chrome, tmp_path: Path) -> None:
    show(browser, rsegen.view(replace(FRAMED, description=HOSTILE)).html, tmp_path)
    assert browser.execute_script("return window.hurt") is None
    assert browser.execute_script("return JSON.parse(document.getElementById('data').textContent).maps.length") == 1
    assert complaints(browser) == []


def test_a_script_that_somebody_put_into_the_page_does_not_run(browser: Chrome, tmp_path: Path) -> None:
    html = rsegen.view(FRAMED).html.replace(b"<body>", b"<body onload='hurt=1'><script>window.hurt = 1</script>")
    show(browser, html, tmp_path)
    assert browser.execute_script("return window.hurt") is None
    assert len(complaints(browser)) >= 2


def test_a_notebook_s_frame_shows_the_map(browser: Chrome, tmp_path: Path) -> None:
    show(browser, f"<!doctype html><title>cell</title>{rsegen.view(FRAMED)._repr_html_()}", tmp_path)
    browser.switch_to.frame(0)
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    assert browser.execute_script("return document.title") == FRAMED.map_name(0)
    assert browser.execute_script("return document.getElementById('page').childElementCount") > 0
