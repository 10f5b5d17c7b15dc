"""Hostile input for every reader and every command: make fuzz FUZZ="--cases 100000 --seed 7".

Cases are made from a seed and a number, so a seed stands for the same cases again. The first that fails of a sort is
made as small as it can be and kept in tests/fuzz/corpus, from where test_fuzz.py runs it ever after.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.fuzz.families import FAMILIES


def main(arguments: Sequence[str]) -> int:
    """Run cases; 1 if any fails."""
    said = _parser().parse_args(arguments)
    if said.worker is not None:
        from tests.fuzz.working import work

        return work(said.worker, said.processes, said.cases, said.seed, said.family)
    if said.replay:
        from tests.fuzz.working import replay

        return replay(said.replay)
    from tests.fuzz.running import run

    first, last = (0, said.cases) if said.number is None else (said.number, said.number + 1)
    return run(range(first, last), said.seed, said.processes, said.family, said.record)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--cases", type=int, default=3000, help="how many (default: 3000)")
    seed = random.SystemRandom().randrange(10**6)
    parser.add_argument("--seed", type=int, default=seed, help="of the cases (default: drawn and printed)")
    count = min(2, os.cpu_count() or 1)
    parser.add_argument("--processes", type=int, default=count, help=f"at the same time (default: {count})")
    parser.add_argument("--family", choices=list(FAMILIES), help="only cases of one sort of input")
    parser.add_argument("--number", type=int, help="only this case of the seed")
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the result into this JSON file")
    parser.add_argument("--replay", type=Path, nargs="*", metavar="FILE", help="the cases in files of the corpus")
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)
    return parser


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
