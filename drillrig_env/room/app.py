"""The server: the page's files, and a websocket that is a room. Nothing else can be asked of it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, MutableMapping
from contextlib import suppress
from typing import Any

from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from drillrig_env.room.client import TOO_MANY, Beginning, Client
from drillrig_env.room.door import COOKIE, Door
from drillrig_env.room.limits import Limits
from drillrig_env.room.page import PageFile
from drillrig_env.room.stock import Stock

_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}

ROOM = "/room"
"""Where the websocket is."""

_Scope = MutableMapping[str, Any]
_Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
_Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]


class Guarded:
    """An application behind a door: nobody gets further without the right Host, Origin and token.

    `visits` are the tasks in which clients are served.
    """

    def __init__(self, app: Any, door: Door, visits: set[asyncio.Task[Any]]) -> None:
        self._app, self._door, self._visits = app, door, visits

    def end(self) -> None:
        """Let all clients go, whatever they wait for."""
        for visit in self._visits:
            visit.cancel()

    async def __call__(self, scope: _Scope, receive: _Receive, send: _Send) -> None:
        """Let a request through, or answer 403."""
        if scope["type"] in ("http", "websocket") and (why := self._why_not(scope)):
            if scope["type"] == "websocket":
                await WebSocket(scope, receive, send).close(1008, why)
            else:
                await PlainTextResponse(f"{why}\n", 403)(scope, receive, send)
            return
        await self._app(scope, receive, send)

    def _why_not(self, scope: _Scope) -> str:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self._door.refuses_host(host):
            return "this host is not served here"
        if scope["type"] == "websocket" and self._door.refuses_origin(headers.get("origin"), host):
            return "a page from elsewhere"
        if not self._door.knows(scope["query_string"].decode("latin-1"), headers.get("cookie", "")):
            return "a token is needed: open the address that the server printed"
        return ""


def room_app(
    stock: Stock, files: dict[str, PageFile], beginning: Beginning, door: Door, limits: Limits | None = None
) -> Guarded:
    """The application. `files` are the page's, by the path at which they are served."""
    limits = limits or Limits()
    visits: set[asyncio.Task[Any]] = set()

    async def serve(request: Request) -> Response:
        if request.query_params.get("token") and door.token is not None:
            answer: Response = RedirectResponse(request.url.path, 303, _HEADERS)
            answer.set_cookie(COOKIE, door.token, httponly=True, samesite="strict")
            return answer
        file = files[request.url.path]
        return Response(file.content, media_type=file.kind, headers=_HEADERS)

    async def room(websocket: WebSocket) -> None:
        if len(visits) >= limits.clients:
            await websocket.accept()
            await websocket.close(TOO_MANY, f"{limits.clients} pages are open here already; close one of them")
            return
        visit: Any = asyncio.current_task()
        visits.add(visit)
        try:
            with suppress(asyncio.CancelledError):  # the server ends
                await Client(websocket, stock, beginning, limits).serve()
        finally:
            visits.discard(visit)

    routes = [Route(path, serve, methods=["GET"]) for path in files]
    return Guarded(Starlette(routes=[*routes, WebSocketRoute(ROOM, room)]), door, visits)
