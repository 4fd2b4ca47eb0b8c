"""The live page: read only, on this machine unless asked otherwise, closed to other sites.

Needs starlette and uvicorn (`pip install 'pyport-pointing[serve]'`).
"""

from __future__ import annotations

import asyncio
import hmac
import importlib.resources
import json
import secrets
import threading
from collections.abc import AsyncIterator, Collection
from dataclasses import dataclass, field
from typing import Any

from pyport.errors import BadInput

#: Where the page is served unless asked otherwise.
HOST, PORT = "127.0.0.1", 8765
#: The port that browsers leave out of a host's name.
LEFT_OUT = 80
LOOPBACK = frozenset({"127.0.0.1", "::1", "localhost"})
#: How often a viewer's connection looks for news, and says that it is alive [s].
LOOK_S, ALIVE_S = 0.5, 15.0
#: A connection that has not asked for anything by then is closed: it would hold a place [s].
PATIENCE_S = 10.0
#: Files of the page and what they are.
FILES = {
    "/": ("watch.html", "text/html; charset=utf-8"),
    "/watch.css": ("watch.css", "text/css; charset=utf-8"),
    "/watch.js": ("watch.js", "text/javascript; charset=utf-8"),
}
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass
class Live:
    """What viewers are shown: the watch puts it here whole, connections read it."""

    text: str = "{}"
    version: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def show(self, payload: dict[str, Any]) -> None:
        """Replace what is shown."""
        text = json.dumps(payload, allow_nan=False)
        with self.lock:
            self.text, self.version = text, self.version + 1

    def now(self) -> tuple[int, str]:
        """Return the version and what is shown."""
        with self.lock:
            return self.version, self.text


def app(live: Live, host: str, port: int, token: str) -> Any:  # noqa: ANN401 - starlette's
    """Return the application.

    Requests for another host, as a rebound name makes them, are refused, and those that do not
    carry the token as `?token=`, where there is one.
    """
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import PlainTextResponse, Response, StreamingResponse
    from starlette.routing import Route

    named = {host, "localhost", "127.0.0.1", "[::1]"} if host in LOOPBACK else set()
    hosts = frozenset(f"{one}:{port}" for one in named)
    if port == LEFT_OUT:
        hosts |= named

    def guarded(answer: Any) -> Any:  # noqa: ANN401 - an endpoint
        async def endpoint(request: Request) -> Response:
            if why := refused(request, hosts, token):
                return PlainTextResponse(f"refused: {why}\n", 403, HEADERS)
            found: Response = await answer(request)
            return found

        return endpoint

    async def file(request: Request) -> Response:
        name, kind = FILES[request.url.path]
        folder = importlib.resources.files("pyport.watch") / "static"
        return Response((folder / name).read_bytes(), 200, HEADERS | {"Content-Type": kind})

    async def state(_: Request) -> Response:
        return Response(live.now()[1], 200, HEADERS | {"Content-Type": "application/json"})

    async def events(request: Request) -> Response:
        return StreamingResponse(_news(live, request), 200, HEADERS, media_type="text/event-stream")

    routes = [Route(path, guarded(file), methods=["GET"]) for path in FILES]
    routes += [
        Route("/state.json", guarded(state), methods=["GET"]),
        Route("/events", guarded(events), methods=["GET"]),
    ]
    return Starlette(routes=routes)


def refused(request: Any, hosts: Collection[str], token: str) -> str | None:  # noqa: ANN401 - starlette's
    """Say why a request is none of the page's; None where it is.

    A page of another site can send a request here, under a name of its own that leads to this
    machine too; it cannot send it under this machine's name without saying where it comes from.
    """
    asked = request.headers.get("host", "")
    if hosts and asked not in hosts:
        return "another host"
    origin = request.headers.get("origin")
    if origin is not None and origin != f"http://{asked}":
        return "another site"
    if request.headers.get("sec-fetch-site", "none") not in {"none", "same-origin"}:
        return "another site"
    bare = request.url.path in {"/watch.css", "/watch.js"}
    given = request.query_params.get("token", "")
    if token and not bare and not hmac.compare_digest(given.encode(), token.encode()):
        return "no token"
    return None


async def _news(live: Live, request: Any) -> AsyncIterator[str]:  # noqa: ANN401 - starlette's
    """Yield what is shown whenever it changes; a comment in between keeps the connection."""
    seen, quiet = -1, 0.0
    while not await request.is_disconnected():
        version, text = live.now()
        if version != seen:
            seen, quiet = version, 0.0
            yield f"id: {version}\ndata: {text}\n\n"
        elif quiet >= ALIVE_S:
            quiet = 0.0
            yield ": alive\n\n"
        await asyncio.sleep(LOOK_S)
        quiet += LOOK_S


def impatient() -> Any:  # noqa: ANN401 - uvicorn's
    """Return uvicorn's protocol, which waits for a request as long as it takes, with a limit."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Impatient(H11Protocol):
        def connection_made(self, transport: Any) -> None:  # noqa: ANN401 - asyncio's
            super().connection_made(transport)
            self.loop.call_later(PATIENCE_S, self._give_up)

        def _give_up(self) -> None:
            if self.cycle is None:
                self.transport.close()

    return Impatient


@dataclass(frozen=True)
class Served:
    """A page that is served: its address and how to stop."""

    address: str
    server: Any
    thread: threading.Thread

    def stop(self) -> None:
        """Stop serving."""
        self.server.should_exit = True
        self.server.force_exit = True
        self.thread.join(timeout=5)


def serve(live: Live, host: str = HOST, port: int = PORT) -> Served:
    """Serve the page from a thread; beyond this machine only with a token in its address.

    Raises `BadInput`: starlette or uvicorn are not installed, or the port is taken.
    """
    try:
        import uvicorn

        token = "" if host in LOOPBACK else secrets.token_urlsafe(16)
        application, protocol = app(live, host, port, token), impatient()
    except ImportError:
        wrong = "--serve needs starlette and uvicorn: pip install 'pyport-pointing[serve]'"
        raise BadInput(wrong) from None
    config = uvicorn.Config(
        application, host=host, port=port, http=protocol, log_level="error", lifespan="off"
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    for _ in range(200):
        if server.started or not thread.is_alive():
            break
        thread.join(0.05)
    if not server.started:
        raise BadInput(f"{host}:{port} cannot be served from, expected a free port: --port")
    query = f"?token={token}" if token else ""
    place = f"[{host}]" if ":" in host else host
    return Served(f"http://{place}:{port}/{query}", server, thread)
