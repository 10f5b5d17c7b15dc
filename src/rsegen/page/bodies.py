"""Bodies of requests: bytes of a bounded size, and JSON of a bounded depth."""

from __future__ import annotations

import json
import re
from typing import Any

from starlette.requests import ClientDisconnect, Request

from rsegen.errors import said_by, shown

_DEEPEST = 60
"""Lists and objects in each other in a call: a recipe has five."""


_DISCARDED = 4
"""Times the most that a body may have up to which it is read to its end, and not kept: the answer to a body that is
still being sent may be lost, as a connection that is closed with unread bytes is reset."""


class Refused(Exception):
    """A request that is not answered: its status, and why."""

    def __init__(self, status: int, text: str, where: str = "", kind: str = "") -> None:
        super().__init__(text)
        self.status = status
        self.failure = {"where": where, "text": text} | ({"kind": kind} if kind else {})


async def body_of(request: Request, most: int) -> bytes:
    """Return the body of a request; one that is larger is refused, and not kept."""
    size = request.headers.get("content-length", "0")
    too_large = Refused(413, f"more than {most // 2**20} MB at once")
    if not size.isdecimal() or len(size) > 15 or int(size) > _DISCARDED * most:
        raise too_large
    body, read = bytearray(), 0
    try:
        async for part in request.stream():
            read += len(part)
            if read > _DISCARDED * most:
                raise too_large
            if read <= most:
                body += part
    except ClientDisconnect:
        raise Refused(400, "the request ended early") from None
    if read > most:
        raise too_large
    return bytes(body)


def parsed(body: bytes) -> dict[str, Any]:
    """Return a JSON object that can be passed on: not nested too deeply, of texts that can be written."""
    try:
        found = json.loads(body or b"{}", parse_constant=_no_constant)
        _check_values(found)
    except (ValueError, RecursionError) as error:
        raise Refused(400, f"not JSON: {said_by(error)}") from None
    if not isinstance(found, dict):
        raise Refused(400, f"{shown(found)} is not an object of arguments")
    return found


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _check_values(value: Any) -> None:
    """Raise a ValueError for values that are nested too deeply, or texts with half a character."""
    level = [value]
    for _ in range(_DEEPEST):
        below: list[Any] = []
        for each in level:
            if isinstance(each, str):
                each.encode()
            elif isinstance(each, dict):
                below += [*each.keys(), *each.values()]
            elif isinstance(each, list):
                below += each
        if not below:
            return
        level = below
    raise ValueError("nested too deeply")


def file_name(given: str) -> str:
    """Return a name for a file that a page sends: the letters, digits and ending of the given one."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", given.replace("\\", "/").rpartition("/")[2]).lstrip(".")[-100:] or "file"
