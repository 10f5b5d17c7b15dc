"""Has libraries read files that may come from anybody: what they raise becomes one line, and they print nothing."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from rsegen.errors import FileError, RsegenError, said_by

_STDERR = 2

_CUT_SHORT = "string or file could not be read to its end"
"""numpy before 2.3 only warns of it, and gives trimesh the numbers up to the wrong one."""

_Content = TypeVar("_Content")


def read_by_library(path: Path, read: Callable[[], _Content]) -> _Content:
    """What `read` makes of a file; FileError for all that a library raises, but an ImportError is the caller's."""
    try:
        with silent_libraries():
            return read()
    except (ImportError, RsegenError):
        raise
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    except Exception as error:  # libraries fail in many ways at files that are none of theirs
        raise FileError(f"{path}: not a {path.suffix[1:].upper()} file that can be read ({said_by(error)})") from None


@contextmanager
def silent_libraries() -> Iterator[None]:
    """Nothing of what libraries warn of, log, or write to file descriptor 2 (as libtiff does) inside is shown.

    Whoever has set up logging still gets the records. Numbers that numpy could not read are an error.
    """
    with ExitStack() as stack:
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", _CUT_SHORT, DeprecationWarning)
        nowhere = logging.NullHandler()  # Python prints records to stderr only if nobody has set up logging
        logging.root.addHandler(nowhere)
        stack.callback(logging.root.removeHandler, nowhere)
        with suppress(OSError):  # nobody hears them if there is no stderr
            before, null = os.dup(_STDERR), os.open(os.devnull, os.O_WRONLY)
            stack.callback(_restore, before)
            os.dup2(null, _STDERR)
            os.close(null)
        yield


def _restore(before: int) -> None:
    os.dup2(before, _STDERR)
    os.close(before)
