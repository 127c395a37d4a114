"""What is answered to which address."""

from __future__ import annotations

import json
import math
import mimetypes
from collections.abc import AsyncIterator, Callable, Mapping
from functools import partial, wraps
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from pipeclamp.pages.page import asset
from pipeclamp.studio import commands, overview, uploads
from pipeclamp.studio.bench import changed, with_candidate
from pipeclamp.studio.desk import Desk, Opened, OpenedMetrics
from pipeclamp.studio.diagnosis_shown import CandidateShown, DiagnosisShown
from pipeclamp.studio.jobs import Job
from pipeclamp.studio.loop_picture import run_picture
from pipeclamp.studio.on_pipe import temperatures_of
from pipeclamp.studio.rendering import campaign_page, metrics_page, page
from pipeclamp.studio.security import TooLargeError
from pipeclamp.studio.work import JobTask
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law

HERE = Path(__file__).parent
MOST_REQUEST_BYTES = 64 * 1024
"""Bytes of a request that is no file."""
MOST_LAWS = 4
"""Drawn over one loop."""
STATED = ("columns", "rate", "pattern")
"""Options of an import that the page sends as texts."""
MEDIA = {
    ".json": "application/json",
    ".csv": "text/csv",
    ".fmu": "application/zip",
    ".html": "text/html",
    ".toml": "application/toml",
}

SERVED = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
"""Types of the studio's own files."""


def most_bytes(path: str) -> int:
    """Give the size that a request to a path may have."""
    return uploads.MOST_UPLOAD_BYTES if path.startswith("/uploads/") else MOST_REQUEST_BYTES


def application(desk: Desk) -> Starlette:
    """Give the application."""
    for suffix, kind in SERVED.items():
        # what Windows keeps of them in its registry may be anything, and a module of another type isn't run
        mimetypes.add_type(kind, suffix)
    pages = Pages(desk)
    routes = [
        Route("/", pages.home),
        Route("/campaigns", pages.campaigns),
        Route("/c/{key}/", pages.campaign),
        Route("/c/{key}/laws/{law}", pages.law),
        Route("/c/{key}/runs/{run:path}", pages.run),
        Route("/c/{key}/moved", pages.moved, methods=["POST"]),
        Route("/c/{key}/jobs", pages.start, methods=["POST"]),
        Route("/c/{key}/jobs", pages.events),
        Route("/c/{key}/jobs/{number:int}/cancel", pages.cancel, methods=["POST"]),
        Route("/c/{key}/files/{name}", pages.file),
        Route("/import/jobs", pages.start_import, methods=["POST"]),
        Route("/uploads/{batch}/{name}", pages.upload, methods=["PUT"]),
        Route("/plotly.js", pages.plotly),
        Route("/page.js", pages.page_script),
        Route("/explorer.js", pages.explorer_script),
        Mount("/static", StaticFiles(directory=HERE / "static")),
    ]
    handlers: Mapping[Any, Any] = {UserError: _refused, TooLargeError: _too_large}
    return Starlette(routes=routes, exception_handlers=handlers)


async def _refused(request: Request, error: Exception) -> Response:
    if "text/html" in request.headers.get("accept", ""):
        return HTMLResponse(page("refused.html.jinja", message=str(error)), 400)
    return JSONResponse({"error": str(error)}, 400)


async def _too_large(request: Request, error: Exception) -> Response:
    return JSONResponse({"error": "too large"}, 413)


def _in_thread(endpoint: Callable[..., Response]) -> Callable[..., Any]:
    """Answer in a thread, so that a long answer keeps nobody else waiting."""

    @wraps(endpoint)
    async def answered(self: Pages, request: Request) -> Response:
        return await run_in_threadpool(endpoint, self, request)

    return answered


class Pages:
    """The endpoints."""

    def __init__(self, desk: Desk) -> None:
        """Answer from a desk."""
        self.desk = desk

    def _opened(self, request: Request) -> Opened:
        return self.desk.open_records(request.path_params["key"])

    @_in_thread
    def home(self, request: Request) -> Response:
        """Give the page of the campaign that the studio was started with, or the list of campaigns."""
        if self.desk.first:
            return self._shown(self.desk.open(self.desk.first), None, request)
        return self._campaigns()

    @_in_thread
    def campaigns(self, request: Request) -> Response:
        """Give the list of campaigns, where files are dropped too."""
        return self._campaigns()

    def _campaigns(self) -> Response:
        imported, bundled = self.desk.choices()
        return HTMLResponse(
            page("campaigns.html.jinja", first=self.desk.first, imported=imported, bundled=bundled, home=self.desk.home)
        )

    @_in_thread
    def campaign(self, request: Request) -> Response:
        """Give a campaign's page with its newest law."""
        return self._shown(self.desk.open(request.path_params["key"]), None, request)

    @_in_thread
    def law(self, request: Request) -> Response:
        """Give the page of a law."""
        return self._shown(self._opened(request), request.path_params["law"], request)

    def _shown(self, opened: Opened | OpenedMetrics, name: str | None, request: Request) -> Response:
        if isinstance(opened, OpenedMetrics):
            return HTMLResponse(metrics_page(opened))
        asked = request.query_params
        return HTMLResponse(campaign_page(opened, name, by=asked.get("by", ""), beside=asked.get("with", "")))

    @_in_thread
    def run(self, request: Request) -> Response:
        """Give one run with the laws that are asked for, and a candidate's prediction."""
        opened = self._opened(request)
        names = [name for name in request.query_params.get("laws", "").split(",") if name]
        laws = {name: law_of(opened.project.law(name)) for name in names[:MOST_LAWS]}
        candidate = request.query_params.get("candidate")
        if candidate and names:
            # the law that the page is about stays last
            laws = {
                f"{names[-1]} + {commands.effects_said(candidate)}": _candidate(opened, names[-1], candidate),
                **laws,
            }
        return JSONResponse(run_picture(opened.bench.run(request.path_params["run"]), laws))

    async def moved(self, request: Request) -> Response:
        """Give what a law gives on a run with other values of parameters."""
        asked = await _asked(request)
        return await run_in_threadpool(self._moved, self._opened(request), asked)

    def _moved(self, opened: Opened, asked: Mapping[str, Any]) -> Response:
        name, candidate = _text(asked, "law"), asked.get("candidate")
        values = asked.get("values")
        if not isinstance(values, dict) or not all(map(_is_number, values.values())):
            raise UserError("values: expected numbers by the names of parameters")
        law = _candidate(opened, name, str(candidate)) if candidate else law_of(opened.project.law(name))
        label = f"{commands.effects_said(str(candidate or name))}, moved"
        shown = run_picture(opened.bench.run(_text(asked, "run")), {label: changed(law, values)})
        try:
            return JSONResponse({"force": shown["laws"][0], "by_law": shown["by_law"][0]})
        except ValueError as error:  # JSON holds no infinite numbers
            raise UserError("values: the law gives forces beyond all reason there") from error

    async def start(self, request: Request) -> Response:
        """Start a job."""
        asked = await _asked(request)
        return await run_in_threadpool(self._start, self._opened(request), asked)

    def _start(self, opened: Opened, asked: Mapping[str, Any]) -> Response:
        task, law = _task(opened, asked)
        return JSONResponse(self.desk.start(opened, task, law).to_dict())

    async def start_import(self, request: Request) -> Response:
        """Start an import of uploaded files, or a look into them."""
        asked = await _asked(request)
        name = uploads.safe_campaign(_text(asked, "name"))
        batch, dry_run = _text(asked, "batch"), bool(asked.get("dry_run", True))
        task = commands.import_task(
            uploads.taken(self.desk.home, batch), self.desk.home / name,
            {option: _text(asked, option) for option in STATED if option in asked},
            skip_unusable=bool(asked.get("skip_unusable", False)), dry_run=dry_run,
        )  # fmt: skip

        def made(job: Job) -> None:
            self.desk.forget(name)
            if not dry_run:
                uploads.clear(self.desk.home, batch)

        job = self.desk.jobs.start("", task, made)
        return JSONResponse(job.to_dict())

    async def cancel(self, request: Request) -> Response:
        """Stop a job."""
        self.desk.jobs.cancel(request.path_params["number"])
        return JSONResponse({})

    async def events(self, request: Request) -> Response:
        """Send a campaign's jobs whenever they change, until none runs."""
        key = request.path_params["key"]

        async def sent() -> AsyncIterator[str]:
            async for jobs in self.desk.jobs.followed("" if key == "-" else key):
                yield f"data: {json.dumps(jobs)}\n\n"

        return StreamingResponse(sent(), media_type="text/event-stream")

    @_in_thread
    def file(self, request: Request) -> Response:
        """Give a file that the studio wrote."""
        path = self._opened(request).project.file_of(request.path_params["name"])
        return FileResponse(path, media_type=MEDIA[path.suffix], filename=path.name)

    async def upload(self, request: Request) -> Response:
        """Take a file."""
        parameters = request.path_params
        name = await uploads.take(self.desk.home, parameters["batch"], parameters["name"], request.stream())
        return JSONResponse({"name": name})

    @_in_thread
    def plotly(self, request: Request) -> Response:
        """Give the library that draws."""
        return _script("plotly/plotly-cartesian.min.js", "max-age=86400")

    @_in_thread
    def page_script(self, request: Request) -> Response:
        """Give what pages draw pictures with."""
        return _script("templates/page.js", "no-cache")

    @_in_thread
    def explorer_script(self, request: Request) -> Response:
        """Give what pages draw a run with."""
        return _script("templates/explorer.js", "no-cache")


def _script(name: str, kept: str) -> Response:
    return Response(asset(name), media_type="text/javascript", headers={"cache-control": kept})


def _task(opened: Opened, asked: Mapping[str, Any]) -> tuple[JobTask, str | None]:
    """Give the task that is asked for, and the name of the law that comes of it, if one does.

    Raises:
        UserError: there is no such task, or what is asked doesn't serve it.
    """
    project, law = opened.project, partial(_text, asked, "law")
    tasks: Mapping[str, Callable[[], tuple[JobTask, str | None]]] = {
        "identify": lambda: commands.identify_task(project, _base(asked)),
        "add": lambda: _addition(opened, law(), _text(asked, "effect")),
        "refit": lambda: commands.refit_task(project, law()),
        "diagnose": lambda: (commands.diagnose_task(project, law(), _limits(asked)), None),
        "climb": lambda: commands.climb_task(project, law(), _limits(asked)),
        "discover": lambda: commands.discover_task(project, law()),
        "build": lambda: (commands.build_task(project, law()), None),
        "report": lambda: (commands.report_task(project, law()), None),
        "respond": lambda: (commands.response_task(project, law(), temperatures_of(opened.bench.loops)), None),
    }
    wanted = _text(asked, "kind")
    if wanted not in tasks:
        raise UserError(f"kind: got {wanted!r}; expected one of {', '.join(tasks)}")
    return tasks[wanted]()


def _base(asked: Mapping[str, Any]) -> str:
    base = _text(asked, "base")
    if base not in commands.BASES:
        raise UserError(f"base: got {base!r}; expected one of {', '.join(commands.BASES)}")
    return base


def _addition(opened: Opened, of: str, effect: str) -> tuple[JobTask, str]:
    """Give the task that adds a candidate of a law's diagnosis, and the name of the law with it."""
    diagnosis = _diagnosis(opened, of, opened.project.law(of))
    _among(diagnosis, of, effect)
    return commands.add_task(opened.project, of, effect, diagnosis.meant(effect))


def _candidate(opened: Opened, law: str, candidate: str) -> Law:
    file = opened.project.law(law)
    found = _among(_diagnosis(opened, law, file), law, candidate)
    return with_candidate(file, found.effects, found.values)


def _among(diagnosis: DiagnosisShown, law: str, candidate: str) -> CandidateShown:
    found = next((each for each in diagnosis.candidates if each.name == candidate), None)
    if found is None:
        raise UserError(f"{candidate!r}: no candidate of {law}'s diagnosis; diagnose it first")
    return found


def _diagnosis(opened: Opened, law: str, file: LawFile) -> DiagnosisShown:
    diagnosis = overview.diagnosis_in(opened.project, law, file)
    if diagnosis is None:
        raise UserError(f"{law}: hasn't been diagnosed; do that first")
    return diagnosis


async def _asked(request: Request) -> Mapping[str, Any]:
    try:
        asked = json.loads(await request.body())
    except (ValueError, RecursionError) as error:
        raise UserError("got no JSON; expected what the studio's page sends") from error
    if not isinstance(asked, dict):
        raise UserError("got no JSON object; expected what the studio's page sends")
    return asked


def _text(asked: Mapping[str, Any], name: str) -> str:
    value = asked.get(name)
    if not isinstance(value, str):
        raise UserError(f"{name}: got {value!r}; expected a text")
    return value


def _limits(asked: Mapping[str, Any]) -> str:
    """Give what the rig can do as it was stated, which may be nothing; it is refused before a job begins."""
    limits = str(asked.get("limits", ""))
    if limits:
        parse_limits(limits)
    return limits


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
