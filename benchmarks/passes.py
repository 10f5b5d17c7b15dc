"""Share of rsegen that a command passes through: its files, and functions, of which each call of one counts once.

`python -m benchmarks.passes generate peak` prints both, by folder; any command and its flags may be given, and where it
writes if it needs that. Imports are left out: what runs when a module is imported is no step of the way.
"""

from __future__ import annotations

import sys
import threading
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType, FrameType

import rsegen
from rsegen.cli.edge import main

HOUSE = str(Path(rsegen.__file__).parent)


def passed(arguments: list[str]) -> set[CodeType]:
    """Run a command, and return the code of all functions of rsegen that it called, in all threads of this process."""
    seen: set[CodeType] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(HOUSE) and not code.co_name.startswith("<"):
            seen.add(code)

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        main(arguments)
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    # The bodies of classes, which run when a module is imported, are code too.
    return {code for code in seen if code.co_flags & 0x2}


def report(seen: set[CodeType]) -> list[str]:
    """Return the counts in lines: all, and by folder."""
    files = {code.co_filename for code in seen}
    folders = Counter(Path(code.co_filename).relative_to(HOUSE).parts[0] for code in seen)
    lines = [f"{len(files)} files, {len(seen)} functions"]
    return [*lines, *(f"{folder:<16}{count:>5}" for folder, count in folders.most_common())]


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("name a command, such as: python -m benchmarks.passes generate peak")
    with TemporaryDirectory() as folder:
        needs_output = "-o" not in sys.argv and sys.argv[1] in ("generate", "series", "export")
        found = passed([*sys.argv[1:], *(["-o", folder] if needs_output else []), "--quiet"])
    print(*report(found), sep="\n")
