"""The server of the page: one address of this machine, with a token without which nothing is answered."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response
from starlette.routing import Route

from rsegen.errors import ParameterError, UserError
from rsegen.exporters.browser.page import editor_page
from rsegen.page import calls, commands, files, forms, playback, robots, scenes, variants  # noqa: F401  # register their calls
from rsegen.page.host import Host


def application(host: Host, token: str) -> Starlette:
    """Return the application that serves a host."""

    async def index(request: Request) -> Response:
        if not secrets.compare_digest(request.query_params.get("token", ""), token):
            return Response("the address lacks its token: use the one that rsegen gui printed", 403)
        return HTMLResponse(editor_page())

    async def ask(request: Request) -> Response:
        if not secrets.compare_digest(request.headers.get("authorization", ""), f"Bearer {token}"):
            return JSONResponse({"error": {"text": "wrong token"}}, 403)
        name = request.path_params["name"]
        arguments = json.loads(await request.body() or b"{}")
        try:
            return JSONResponse(await run_in_threadpool(_answer, host, name, arguments))
        except UserError as error:
            where = error.where if isinstance(error, ParameterError) else ""
            return JSONResponse({"error": {"where": where, "text": str(error)}}, 400)

    return Starlette(routes=[Route("/", index), Route("/api/{name}", ask, methods=["POST"])])


def _answer(host: Host, name: str, arguments: dict[str, Any]) -> Any:
    function: Callable[..., Any]
    if name in calls.OF_HOST:
        return calls.OF_HOST[name](host, **arguments)
    if name in calls.OF_DOCUMENT:
        return calls.OF_DOCUMENT[name](host.opened(arguments.pop("doc", "")), **arguments)
    raise UserError(f"unknown call {name!r}")
