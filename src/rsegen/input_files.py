"""Files that may come from anybody, opened so that nothing waits for ever, grows without end, or prints by itself.

Whoever reads a file of a user opens it by `open_regular` or `read_start`, and by no other `open`: a pipe that nobody
writes to is an error like any other. Texts are read up to a size; XML without document types and entities, of which
bombs are made. What a library raises becomes a FileError of one line, and what it warns of or logs is not shown. Files
that rsegen wrote are known by their size and SHA-256 checksum.
"""

from __future__ import annotations

import builtins
import errno
import hashlib
import logging
import os
import re
import select
import stat
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rsegen.errors import FileError, RsegenError, library_message, shown, system_reason

if TYPE_CHECKING:
    import xml.etree.ElementTree as ET


_SECONDS_FOR_A_WRITER = 2.0
"""A program that is started together with rsegen, as by `<(...)`, opens its end of a pipe within this time."""

_SECONDS_OF_SILENCE = 60.0
"""A program that writes into a pipe may work this long before it writes more; with less, a slow one is cut off."""

_PIECE = 2**26
"""Bytes for which memory is taken at once, of a file that may have fewer: a piece is most files, and is not copied."""

_AT_ONCE = 2**20
"""Bytes that are read at once: more than this reads no faster, and only takes memory."""


def open_regular(path: str | Path) -> BufferedReader:
    """Return a regular file, opened to be read; OSError for anything else, such as a folder, a pipe or a device."""
    file = _opened(path)
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise OSError(errno.EINVAL, "not a regular file", str(path))


def read_start(path: str | Path, most: int) -> bytes:
    """Return up to `most` bytes of a file, a device, or a pipe that somebody writes to; OSError if it is unreadable."""
    with _opened(path) as file:
        descriptor = file.fileno()
        kind = os.fstat(descriptor).st_mode
        if stat.S_ISFIFO(kind):
            return _read_pipe(descriptor, most)
        if not stat.S_ISREG(kind):
            os.set_blocking(descriptor, True)  # a terminal, at which a person types
        # In pieces, as `most` may be far more than the file has, and `read` would take memory for all of it at once.
        pieces, left = list[bytes](), most
        while piece := file.read(min(left, _PIECE)):
            pieces.append(piece)
            left -= len(piece)
        return b"".join(pieces)


def regular_content(path: str | Path, most: int) -> bytes | None:
    """Return up to `most` bytes of a regular file; None if the path has no such file, or it cannot be read."""
    try:
        with open_regular(path) as file:
            return file.read(most)
    except (OSError, ValueError):  # the second for a name with a null character
        return None


_POINTER = b"version https://git-lfs.github.com/spec/"
"""Begin of the text that stands for a large file in a repository."""


def refuse_pointer(path: Path, content: bytes | None = None) -> None:
    """Raise a FileError for a pointer of Git LFS, which a clone without Git LFS has in place of a large file.

    content: of the file, where it has been read
    """
    if content is None:
        content = regular_content(path, len(_POINTER)) or b""
    if content.startswith(_POINTER):
        raise FileError(f"{path}: a pointer of Git LFS, and not the file itself; run `git lfs pull` in its clone")


_STARTS = {
    "a PNG image": (b"\x89PNG\r\n",),
    "a JPEG image": (b"\xff\xd8\xff",),
    "a TIFF image": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "a PGM image": (b"P2\n", b"P5\n"),
    "a numpy array": (b"\x93NUMPY",),
    "a PLY file": (b"ply\n", b"ply\r"),
    "a PCD file": (b"# .PCD", b"VERSION 0.7\nFIELDS", b"VERSION .7\nFIELDS"),
    "a LAS or LAZ file": (b"LASF",),
    "an E57 file": (b"ASTM-E57",),
    "a GLB file": (b"glTF",),
    "a PDF file": (b"%PDF-",),
    "a ZIP archive": (b"PK\x03\x04",),
}
"""The first bytes of files of a type."""

_ROOTS = {
    b"robot": "a robot in URDF",
    b"mujoco": "a model in MJCF",
    b"sdf": "an SDF file",
    b"COLLADA": "a COLLADA file",
}
"""The first elements of XML files of a type."""


def file_type(start: bytes) -> str:
    """Return what a file is by its first bytes, as `a PNG image`; an empty text if they do not say it."""
    for name, starts in _STARTS.items():
        if start.startswith(starts):
            return name
    root = re.match(rb"\s*(<\?.*?\?>|<!--.*?-->|\s)*<(\w+)", start, re.DOTALL)
    return _ROOTS.get(root[2], "an XML file") if root else ""


def _opened(path: str | Path) -> BufferedReader:
    """Open a file at once: without O_NONBLOCK the system waits until somebody writes to a pipe."""
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0)))


def _read_pipe(descriptor: int, most: int) -> bytes:
    """Read a pipe until `most` bytes are read or every writer has closed it."""
    content, had_a_writer = bytearray(), False
    while len(content) < most:
        try:
            piece = os.read(descriptor, min(most - len(content), _AT_ONCE))
        except BlockingIOError:  # a writer has it open, and has not written more yet
            _wait(descriptor, _SECONDS_OF_SILENCE)
            had_a_writer = True
            continue
        # A pipe at its end, and one whose writer has not opened it yet, both read as nothing.
        if not piece and had_a_writer:
            break
        if not piece:
            _wait(descriptor, _SECONDS_FOR_A_WRITER)
        content += piece
        had_a_writer = True
    return bytes(content)


def _wait(descriptor: int, seconds: float) -> None:
    """Return as soon as there is something to read, or a writer has closed the pipe; OSError if neither happens."""
    if not select.select([descriptor], [], [], seconds)[0]:
        raise OSError(errno.ETIMEDOUT, f"a pipe to which nobody writes, for {seconds:g} seconds")


_DEEPEST = 200
"""Levels of elements in each other; an SDF file has some ten."""


def first_inside(path: Path, is_wanted: Callable[[Path], bool]) -> Path | None:
    """Return the first wanted file in a folder, by its name; None if it has no such file, or is no folder."""
    return min(filter(is_wanted, path.iterdir()), default=None) if path.is_dir() else None


def unreadable(path: Path, error: OSError) -> str:
    """Return the message of a file that cannot be read; if a relative path leads nowhere, with the current folder."""
    is_lost = isinstance(error, FileNotFoundError) and not path.is_absolute()
    return f"{path}: {system_reason(error)}{f' in {Path.cwd()}' if is_lost else ''}"


def text_of(path: Path, mib: int, too_large: str) -> str:
    """Return the text of a file of at most `mib` MiB; FileError if it cannot be read, is larger, or is not UTF-8."""
    try:
        content = read_start(path, mib * 2**20 + 1)
    except OSError as error:
        raise FileError(unreadable(path, error)) from None
    except ValueError as error:  # a name with a null character
        raise FileError(f"{shown(str(path))}: {error}") from None
    if len(content) > mib * 2**20:
        raise FileError(f"{path}: larger than {mib} MiB, too large for {too_large}")
    refuse_pointer(path, content)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: not a text in UTF-8") from None


def xml_root(text: str, where: str) -> ET.Element:
    """Return the root of an XML text; a document type and entities are refused, as bombs are made of them.

    What is no strict XML, but is read by the parser of Gazebo and ROS, is read too: blanks before the declaration,
    prefixes that are not bound, -- in comments, and & on its own.
    """
    import xml.etree.ElementTree as ET

    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise FileError(f"{where}: contains a DOCTYPE or entities, which are not allowed")
    try:
        try:
            root = ET.fromstring(text)  # noqa: S314  # without a document type it can only be plain elements
        except ET.ParseError:
            text = _strict(text)
            root = ET.fromstring(text)  # noqa: S314  # as above
    except (ET.ParseError, LookupError, ValueError) as error:  # the last two for an encoding that is none
        raise FileError(f"{where}: not XML ({error})") from None
    for prefix, uri in _BOUND.findall(text)[:_MOST_PREFIXES]:
        if not re.fullmatch(r"ns\d+|xml", prefix):  # which ElementTree gives by itself
            ET.register_namespace(prefix, uri)  # so that it is written again under the name that Gazebo knows
    # Level by level, not by recursion, which a file of a million nested elements would exhaust.
    level, depth = [root], 0
    while level := [child for element in level for child in element]:
        depth += 1
        if depth >= _DEEPEST:  # ElementTree could not write them again
            raise FileError(f"{where}: nested too deeply, in more than {_DEEPEST} levels")
    return root


_BOUND = re.compile(r"""\sxmlns:([A-Za-z_][\w.-]*)\s*=\s*["']([^"']+)["']""")
_USED = re.compile(r"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*(?=[\s=/>])")
"""A prefix of a name where it is bound, and where it is used: gz:expressed_in, controller:gazebo_ros_laser."""

_MOST_PREFIXES = 50
"""Prefixes that are bound; files have one or two."""


def _strict(text: str) -> str:
    """Return what is nearly XML as XML, with all lines where they were."""
    # Comments go first, as they may hold anything; their line breaks stay, for the line numbers of errors.
    text = re.sub(r"<!--.*?-->", lambda comment: "\n" * comment[0].count("\n"), text.lstrip(), flags=re.DOTALL)
    text = re.sub(r"&(?!#?\w+;)", "&amp;", text)
    bound = {prefix for prefix, _ in _BOUND.findall(text)} | {"xml", "xmlns"}
    # Prefixes are bound in the root element, to names of our own: nobody looks at what they stand for.
    unbound = [prefix for prefix in dict.fromkeys(_USED.findall(text)) if prefix not in bound][:_MOST_PREFIXES]
    names = "".join(f' xmlns:{prefix}="urn:prefix:{prefix}"' for prefix in unbound)
    return re.sub(r"<[A-Za-z_][\w.-]*", lambda start: start[0] + names, text, count=1)


_STDERR = 2
"""The file descriptor of stderr, by POSIX."""

_CUT_SHORT = "string or file could not be read to its end"
"""numpy before 2.3 only warns of it, and gives trimesh the numbers up to the wrong one."""

_PANIC = "PanicException"
"""Name of the error of libraries in Rust whose code gives up: no Exception, and its class cannot be imported."""

_Content = TypeVar("_Content")


def read_by_library(path: Path, read: Callable[[], _Content]) -> _Content:
    """Return the result of `read`; a FileError for all that a library raises, but an ImportError is the caller's."""
    refuse_pointer(path)
    try:
        with silent_libraries():
            return read()
    except (ImportError, RsegenError):
        raise
    except OSError as error:
        raise FileError(unreadable(path, error)) from None
    except BaseException as error:  # libraries fail in many ways at files that are none of theirs
        if not isinstance(error, Exception) and type(error).__name__ != _PANIC:
            raise
        raise FileError(
            f"{path}: not a {path.suffix[1:].upper()} file that can be read ({library_message(error)})"
        ) from None


_SILENCE = threading.RLock()
"""Held while libraries are silent: of threads whose silence overlaps, the last would put back what another has set."""

if sys.platform != "win32":  # a fork waits, so that its child has neither the lock nor the silence of another thread
    os.register_at_fork(before=_SILENCE.acquire, after_in_parent=_SILENCE.release, after_in_child=_SILENCE.release)


@contextmanager
def silent_libraries() -> Iterator[None]:
    """Hide what libraries warn of, log, or write to file descriptor 2 (as libtiff does) inside; one thread at a time.

    Whoever has set up logging still gets the records. Numbers that numpy could not read are an error.
    """
    with _SILENCE, ExitStack() as stack:
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", _CUT_SHORT, DeprecationWarning)
        nowhere = logging.NullHandler()  # Python prints records to stderr only if nobody has set up logging
        logging.root.addHandler(nowhere)
        stack.callback(logging.root.removeHandler, nowhere)
        with suppress(OSError):  # nobody hears them if there is no stderr
            before, null = os.dup(_STDERR), os.open(os.devnull, os.O_WRONLY)
            stack.callback(os.close, before)
            stack.callback(os.dup2, before, _STDERR)
            os.dup2(null, _STDERR)
            os.close(null)
        yield


JOURNAL = ".rsegen.jsonl"
"""The file of a folder that lists what rsegen wrote there, with sizes and checksums (rsegen.writing.journal)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Checksum:
    """The size and SHA-256 checksum of one file."""

    bytes: int
    sha256: str

    @classmethod
    def of(cls, content: builtins.bytes) -> Checksum:
        """Return the checksum of a file with this content."""
        return cls(bytes=len(content), sha256=hashlib.sha256(content).hexdigest())


def checksum_of(path: Path) -> Checksum | None:
    """Return the checksum of a file, None if it does not exist; OSError if it is no regular file."""
    try:
        with open_regular(path) as file:
            digest = hashlib.sha256()
            while piece := file.read(_AT_ONCE):
                digest.update(piece)
            return Checksum(bytes=file.tell(), sha256=digest.hexdigest())
    except (FileNotFoundError, NotADirectoryError):
        return None


def refuse_duplicates(keys: Iterable[tuple[str, str]]) -> None:
    """Raise a FileError for the first duplicate key; each comes with its place in the file."""
    seen = set()
    for key, where in keys:
        if key in seen:
            raise FileError(f"{where}: the key {shown(key)} is given twice")
        seen.add(key)


def parser_message(error: Exception) -> str:
    """Return the message of a parser, short and without its advice to programmers."""
    if isinstance(error, RecursionError):
        return "nested too deeply"
    if isinstance(error, (AttributeError, LookupError, TypeError)):
        return "a value is not what its tag says"
    return str(getattr(error, "problem", error)).partition(";")[0].partition("\n")[0]
