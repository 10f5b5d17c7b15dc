"""A real Chromium for tests of pages: without a screen, without the internet, with a new profile each time."""

from __future__ import annotations

import json
from base64 import b64decode
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from tests.support.missing import missing
from tests.support.patience import until

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

_QUIET = (
    *("headless=new", "no-sandbox", "disable-gpu", "use-angle=swiftshader", "enable-unsafe-swiftshader"),
    *("disable-quic", "no-first-run", "disable-background-networking", "disable-component-update", "disable-sync"),
    *("disable-dev-shm-usage", "hide-scrollbars"),
)

BLURRED = 0.5
"""Sharpness of pages of which nobody looks at the picture: without a graphics card each pixel takes time."""


@contextmanager
def chromium(*flags: str) -> Iterator[Chrome]:
    """A browser that Python drives, with more flags; the test is skipped, and in CI fails, if there is none.

    `find_element` waits until there is one, as a page draws what changed in its next frame; `find_elements` does not.
    """
    browser = next(filter(None, map(which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = which("chromedriver")
    if not browser or not driver:
        missing("no Chromium: apt-get install chromium chromium-driver")
    from selenium.webdriver import Chrome, ChromeOptions, ChromeService
    from selenium.webdriver.remote.webelement import WebElement

    class PatientChrome(Chrome):
        def find_element(self, *how: Any, **named: Any) -> WebElement:
            until(lambda: self.find_elements(*how, **named))
            return super().find_element(*how, **named)

    options = ChromeOptions()
    options.binary_location = browser
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*_QUIET, *flags, f"user-data-dir={profile}"):
            options.add_argument(f"--{flag}")
        opened = PatientChrome(options=options, service=ChromeService(executable_path=driver))
        try:
            yield opened
        finally:
            opened.quit()


def resize(browser: Chrome, width: int, height: int, *, dark: bool = False, sharpness: float = 1) -> None:
    """Give the page this size in CSS pixels, so many pixels of the screen along each, and light or dark colours."""
    size = {"width": width, "height": height, "deviceScaleFactor": sharpness, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})


def requests(browser: Chrome) -> list[str]:
    """The addresses that pages have asked for since the last call."""
    messages = (json.loads(entry["message"])["message"] for entry in _log(browser, "performance"))
    return [each["params"]["request"]["url"] for each in messages if each["method"] == "Network.requestWillBeSent"]


def complaints(browser: Chrome) -> list[str]:
    """Warnings and errors on the console since the last call, but for those of software that draws for a card."""
    found = [entry["message"] for entry in _log(browser, "browser") if entry["level"] in ("WARNING", "SEVERE")]
    return [message for message in found if "GL Driver Message (OpenGL, Performance" not in message]


def _log(browser: Chrome, name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = browser.get_log(name)  # type: ignore[no-untyped-call]  # selenium's
    return found


def screenshot(browser: Chrome, path: Path) -> None:
    """Keep what the page shows, all of its height."""
    height = browser.execute_script("return document.documentElement.scrollHeight")
    width = browser.execute_script("return innerWidth")
    clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
    found = browser.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    path.write_bytes(b64decode(found["data"]))
