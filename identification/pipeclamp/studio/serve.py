"""The server: bound to this machine alone unless told otherwise, until it is stopped."""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import webbrowser
from collections.abc import Callable

import uvicorn

from pipeclamp.studio.desk import Desk
from pipeclamp.studio.rendering import warm
from pipeclamp.studio.routes import application, most_bytes
from pipeclamp.studio.security import Door, RequestGuard
from pipeclamp_models.base.errors import InterruptError, UserError

GRACE_s = 1
"""So long an answer may take to end when the studio is stopped."""


class Server(uvicorn.Server):
    """A server that ends its jobs first, and with them the streams that tell of them."""

    def __init__(self, config: uvicorn.Config, desk: Desk) -> None:
        """Serve what lies on a desk."""
        super().__init__(config)
        self._desk = desk

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End."""
        self._desk.jobs.end()
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)  # what is cut off now is meant to be
        await super().shutdown(sockets)


def serve(desk: Desk, host: str, port: int, tell: Callable[[str], None], *, browser: bool) -> None:
    """Serve until stopped.

    Args:
        desk: what is open.
        host: address to bind to.
        port: likewise; 0 for a free one.
        tell: is told the URL once requests are taken.
        browser: whether to open it.

    Raises:
        UserError: the address can't be bound.
        InterruptError: it was stopped.
    """
    with contextlib.closing(bound(host, port)) as listening:
        door = Door(host, listening.getsockname()[1])
        app = RequestGuard(application(desk), door, most_bytes)
        config = uvicorn.Config(
            app, log_level="warning", access_log=False, server_header=False, lifespan="off",
            timeout_graceful_shutdown=GRACE_s, h11_max_incomplete_event_size=64 * 1024, ws="none", proxy_headers=False,
        )  # fmt: skip
        tell(door.url)
        # while the browser starts, what its first page needs is made
        threading.Thread(target=warm, args=(desk,), daemon=True).start()
        if browser:
            webbrowser.open(door.url)
        try:
            Server(config, desk).run(sockets=[listening])
        except KeyboardInterrupt as stop:
            raise InterruptError(f"all laws are in {desk.home}; the same command goes on with them") from stop
        finally:
            desk.jobs.end()


def bound(host: str, port: int) -> socket.socket:
    """Give a socket that listens.

    Raises:
        UserError: the address can't be bound.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        # on Windows the former would let a second server in, and its absence alone doesn't keep one out
        option = getattr(socket, "SO_EXCLUSIVEADDRUSE", socket.SO_REUSEADDR)
        listening.setsockopt(socket.SOL_SOCKET, option, 1)
        listening.bind((host, port))
        listening.listen(128)
    except (OSError, OverflowError) as error:
        listening.close()
        raise UserError(
            f"--host {host} --port {port}: can't be bound ({getattr(error, 'strerror', None) or error}); expected an "
            "address of this machine and a port that is free, or --port 0 for any"
        ) from error
    return listening
