"""The pictures of the page in the manual: `python -m docs.page [FILE]`, with Chromium.

With a FILE it makes the first of them alone, as that file.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from rsegen.page.host import Host
from rsegen.page.host import open as open_document
from rsegen.page.service import Service
from tests.support.browser import chromium, resize, screenshot

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

PICTURES = Path(__file__).parent / "pictures"
EXAMPLE = "mixed-course"
SIZE = 1366, 768
_DRAWN = 3.0
"""Seconds in which everything that was asked for is drawn, without a graphics card."""


@contextmanager
def served() -> Iterator[str]:
    """Serve the page of the example as long as this lasts; gives its address."""
    with TemporaryDirectory() as folder:
        service = Service(host=Host(folder=Path(folder)), keep=True)
        doc = open_document(service.host, what=EXAMPLE)["doc"]
        service.start()
        try:
            yield service.url(doc)
        finally:
            service.close()


def show_robot(browser: Chrome) -> None:
    """Let the crawler stand on the map, with its tilt at every place."""
    browser.execute_script(_ROBOT)


_ROBOT = ""


def main(first: Path | None) -> int:
    """Make the pictures; gives the exit code."""
    with served() as address, chromium() as browser:
        resize(browser, *SIZE)
        browser.get(address)
        time.sleep(_DRAWN)
        screenshot(browser, first or PICTURES / "page.png")
        if first is None:
            show_robot(browser)
            time.sleep(_DRAWN)
            screenshot(browser, PICTURES / "page-robot.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
