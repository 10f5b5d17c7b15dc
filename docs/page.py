"""The picture of a page of `rsegen view` in the manual: `python -m docs.page [FILE]`, with Chromium."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import rsegen
from rsegen.recipe.examples import EXAMPLES
from tests.support.browser import chromium, resize, screenshot

DOCS = Path(__file__).parent
EXAMPLE = "mixed-course"


def main(picture: Path) -> int:
    """Show the example, and keep what is seen."""
    with TemporaryDirectory() as folder, chromium() as browser:
        page = rsegen.view(rsegen.load(EXAMPLES[EXAMPLE])).save(Path(folder) / "map.html")
        resize(browser, 1280, 900)
        browser.get(page.as_uri())
        time.sleep(1)
        screenshot(browser, picture)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "pictures" / "view.png"))
