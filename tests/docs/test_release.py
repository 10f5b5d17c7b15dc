"""Results of scripts/release for README.md and pyproject.toml; `make package` has the wheel."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]
RELEASE = runpy.run_path(str(ROOT / "scripts" / "release"))
HOME = "https://example.com/somebody/rsegen"
TARGETS = r"\]\(([^)]+)\)|<img src=\"([^\"]+)\""


def test_the_readme_of_an_index_has_the_address_of_every_file() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    changed = RELEASE["for_index"](text, HOME, "v1")
    before, after = (["".join(found) for found in re.findall(TARGETS, readme)] for readme in (text, changed))
    assert len(before) == len(after) > 40
    for path, address in zip(before, after, strict=True):
        kind = "raw" if Path(path).suffix in (".webp", ".png") else "blob"
        assert address == f"{HOME}/{kind}/v1/{path}"


def test_addresses_and_anchors_stay() -> None:
    text = "[a](https://example.com/x) [b](#here) ![c](https://example.com/c.png)"
    assert RELEASE["for_index"](text, HOME, "v1") == text


def test_the_urls_of_the_project_come_with_a_release_and_nowhere_else() -> None:
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    assert "[project.urls]" not in text
    changed = RELEASE["with_urls"](text, HOME)
    urls = changed.partition("[project.urls]\n")[2].partition("\n\n")[0].splitlines()
    assert [line.partition(" = ")[0] for line in urls] == ["Homepage", "Documentation", "Changelog", "Issues"]
    assert changed.replace("\n".join(["[project.urls]", *urls, "", ""]), "") == text


def test_worlds_of_other_bytes_are_named(tmp_path: Path) -> None:
    for name, content in (("made", "a"), ("wanted", "b")):
        for file, text in (("same", "x"), ("other", content), (f"only-{name}", ""), (".rsegen.jsonl", content)):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / file).write_text(text)
    assert RELEASE["differences"](tmp_path / "made", tmp_path / "wanted") == ["only-made", "only-wanted", "other"]
