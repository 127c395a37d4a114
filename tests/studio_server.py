"""A studio that tests ask over HTTP, with headers of any kind."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn

from pipeclamp.studio.desk import Desk
from pipeclamp.studio.routes import application, most_bytes
from pipeclamp.studio.security import Door, RequestGuard
from pipeclamp.studio.serve import bound


class Studio:
    """A running studio.

    Attributes:
        desk, door: what it serves, and how it is reached.
    """

    def __init__(self, desk: Desk, door: Door) -> None:
        self.desk = desk
        self.door = door

    @property
    def own(self) -> dict[str, str]:
        """What a page of the studio sends."""
        host = f"127.0.0.1:{self.door.port}"
        return {"Host": host, "Origin": f"http://{host}", "Cookie": f"{self.door.cookie}={self.door.token}"}

    def ask(
        self, path: str, method: str = "GET", body: object = None, headers: Mapping[str, str] | None = None
    ) -> tuple[int, http.client.HTTPMessage, bytes]:
        """Ask as a page of the studio does, or with other headers; None leaves one out."""
        given = {name: value for name, value in {**self.own, **(headers or {})}.items() if value is not None}
        content = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
        connection = http.client.HTTPConnection("127.0.0.1", self.door.port, timeout=60)
        try:
            connection.putrequest(method, path, skip_host=True)
            for name, value in {"Content-Length": str(len(content or b"")), **given}.items():
                connection.putheader(name, value)
            connection.endheaders(content)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def json(self, path: str, body: object = None) -> Any:
        """Give what is answered, or why not, as JSON."""
        return json.loads(self.ask(path, "GET" if body is None else "POST", body)[2])

    def done(self, job: Mapping[str, Any]) -> Mapping[str, Any]:
        """Wait for a job to end."""
        while True:
            (found,) = (each for each in self.desk.jobs.of(job["project"]) if each["number"] == job["number"])
            if found["state"] != "running":
                return found
            time.sleep(0.05)


@contextmanager
def running(home: Path, campaign: str = "") -> Iterator[Studio]:
    """Run a studio in a thread."""
    desk = Desk(home, campaign)
    listening = bound("127.0.0.1", 0)
    door = Door("127.0.0.1", listening.getsockname()[1])
    app = RequestGuard(application(desk), door, most_bytes)
    server = uvicorn.Server(uvicorn.Config(app, log_level="warning", lifespan="off", timeout_graceful_shutdown=1))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    try:
        yield Studio(desk, door)
    finally:
        desk.jobs.end()
        server.should_exit = True
        thread.join()
