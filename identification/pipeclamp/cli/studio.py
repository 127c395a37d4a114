"""The command line's part for the studio."""

from __future__ import annotations

import threading
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from pipeclamp.cli.terminal import put, showing_progress
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import refuse_parent

app = typer.Typer()
NEEDED = ("starlette", "uvicorn")


@app.command(epilog="Example: pipeclamp studio my_campaign")
def studio(
    campaign: Annotated[
        str,
        typer.Argument(metavar="[CAMPAIGN]", help="Folder with campaign.toml and runs.csv, or a bundled campaign."),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FOLDER", help="Where laws are written; CAMPAIGN_studio here by default."
        ),
    ] = None,
    port: Annotated[int, typer.Option(metavar="N", min=0, max=65535, help="0: any that is free.")] = 0,
    host: Annotated[str, typer.Option(metavar="ADDRESS", help="To bind to; others than this machine get in then.")] = (
        "127.0.0.1"
    ),
    no_browser: Annotated[bool, typer.Option("--no-browser", metavar="", help="Print the URL, and open nothing.")] = (
        False
    ),
) -> None:
    """The whole job in the browser: tests, law, what it lacks, FMU; serves this machine until Ctrl-C."""
    if output is not None:
        refuse_parent(output)
    if any(find_spec(name) is None for name in NEEDED):
        raise UserError(f"studio: needs {' and '.join(NEEDED)}; pip install 'pipeclamp[studio]' brings them")
    from pipeclamp.studio.desk import Desk, default_home
    from pipeclamp.studio.rendering import warm_drawing
    from pipeclamp.studio.serve import serve

    threading.Thread(target=warm_drawing, daemon=True).start()
    with showing_progress("studio") as tell:
        tell(f"read {campaign}" if campaign else "start")
        desk = Desk(output or default_home(campaign), campaign)

    def say(url: str) -> None:
        put(url)

    serve(desk, host, port, say, browser=not no_browser)
