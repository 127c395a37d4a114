"""Who is answered: pages of this studio, opened with its token; nobody else's pages, and no other name of this host."""

from __future__ import annotations

import ipaddress
import secrets
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HEADERS = {
    "content-security-policy": (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; object-src 'none'; "
        "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
"""What every answer carries. Styles may stand in a page, since Plotly sets them there; scripts may not."""
READING = ("GET", "HEAD")


@dataclass(frozen=True)
class Door:
    """Where the studio listens, and what opens it.

    Attributes:
        host: the address that it is bound to.
        port: likewise.
        token: in the URL that is printed, then in a cookie.
    """

    host: str
    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    @property
    def loopback(self) -> bool:
        """Whether only this machine reaches it."""
        return _is_loopback(self.host)

    @property
    def url(self) -> str:
        """What is printed: it opens the studio."""
        host = "127.0.0.1" if self.host in ("0.0.0.0", "::") else self.host
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self.port}/?token={self.token}"

    @property
    def cookie(self) -> str:
        """Name of the cookie: browsers share cookies between the ports of a host."""
        return f"pipeclamp_studio_{self.port}"

    def serves(self, authority: str) -> bool:
        """Tell whether a Host is one of this studio's: a foreign name that points here is none."""
        try:
            asked = urlsplit(f"//{authority}")
            name, port = asked.hostname or "", asked.port or 80
        except ValueError:
            return False
        if port != self.port or asked.username is not None or asked.path:
            return False
        if self.loopback:
            return _is_loopback(name)
        return name == self.host.lower() or name == socket.gethostname().lower() or _is_address(name)

    def knows(self, given: str | None) -> bool:
        """Tell whether a token is the right one, in a time that says nothing about it."""
        return given is not None and secrets.compare_digest(given.encode(), self.token.encode())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name == "localhost"
    return True


def _is_loopback(name: str) -> bool:
    return name == "localhost" or (_is_address(name) and ipaddress.ip_address(name).is_loopback)


class RequestGuard:
    """Refuses what is not asked by a page of this studio, and limits what it is sent."""

    def __init__(self, app: ASGIApp, door: Door, most_bytes: Callable[[str], int]) -> None:
        """Guard an application; `most_bytes` gives the size that a request to a path may have."""
        self.app = app
        self.door = door
        self.most_bytes = most_bytes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or refuse."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        token = _token_in(scope)
        refusal = self._refusal(scope, headers, token)
        most = self.most_bytes(scope["path"])
        if refusal is None and int(headers.get("content-length", "0") or 0) > most:
            refusal = PlainTextResponse(f"too large; expected at most {most} bytes", 413)

        async def answered(message: Message) -> None:
            if message["type"] == "http.response.start":
                sent = MutableHeaders(scope=message)
                sent.update(HEADERS)
                if "cache-control" not in sent:
                    sent["cache-control"] = "no-store"
                if refusal is None and token is not None:
                    given = f"{self.door.cookie}={token}; Path=/; HttpOnly; SameSite=Strict"
                    sent.append("set-cookie", given)
            await send(message)

        await (refusal or self.app)(scope, _limited(receive, most), answered)

    def _refusal(self, scope: Scope, headers: Headers, token: str | None) -> PlainTextResponse | None:
        if not self.door.serves(headers.get("host", "")):
            return PlainTextResponse("this name isn't served; use the URL that the studio printed", 421)
        origin = headers.get("origin")
        own = f"http://{headers['host']}"
        if origin not in ((None, own) if scope["method"] in READING else (own,)):
            return PlainTextResponse("asked by a page of somebody else", 403)
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin") and token is None:
            return PlainTextResponse("asked by a page of somebody else", 403)
        if not self.door.knows(token if token is not None else _cookies(headers).get(self.door.cookie)):
            return PlainTextResponse("no access; open the URL that the studio printed, with its token", 403)
        return None


def _token_in(scope: Scope) -> str | None:
    found = parse_qs(scope["query_string"].decode("latin-1")).get("token")
    return found[0] if found else None


def _cookies(headers: Headers) -> Mapping[str, str]:
    try:
        return {name: morsel.value for name, morsel in SimpleCookie(headers.get("cookie", "")).items()}
    except CookieError:
        return {}


class TooLargeError(Exception):
    """More was sent than a request may hold."""


def _limited(receive: Receive, most: int) -> Receive:
    seen = 0

    async def limited() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > most:
            raise TooLargeError
        return message

    return limited
