"""The command line as a whole: its commands, and how a mistake ends one.

What a command needs is imported inside it, so that `--help` and light commands start fast.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from pipeclamp.cli import campaigns as cli_campaigns
from pipeclamp.cli import catalogue as cli_catalogue
from pipeclamp.cli import discover as cli_discover
from pipeclamp.cli import importing as cli_importing
from pipeclamp.cli import laws as cli_laws
from pipeclamp.cli import planning as cli_planning
from pipeclamp.cli import simulation as cli_simulation
from pipeclamp.cli import studio as cli_studio
from pipeclamp.cli.commands import Commands
from pipeclamp.cli.terminal import MARKED, errors, print_next, put
from pipeclamp_models.base.errors import InterruptError, UsageError, UserError
from pipeclamp_models.base.one_thread import one_thread_throughout
from pipeclamp_models.base.said import message
from pipeclamp_system.description.trust_mark import is_doubt

app = typer.Typer(
    cls=Commands,
    name="pipeclamp",
    help="Identify the law of a pipe clamp from loop tests, see where it fails, and carry it into system simulation.",
    epilog="Example: pipeclamp identify my_campaign -o law.json && pipeclamp compare law.json my_campaign",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    # Rich's help looks no clearer, and takes twice as long as everything else of `--help`.
    rich_markup_mode=None,
    add_completion=True,
)
app.add_typer(cli_laws.app)
app.add_typer(cli_campaigns.app)
app.add_typer(cli_catalogue.app)
app.add_typer(cli_importing.app)
app.add_typer(cli_discover.app)
app.add_typer(cli_planning.app)
app.add_typer(cli_simulation.app)
app.add_typer(cli_studio.app)


def _tell_version(wanted: bool) -> None:
    if wanted:
        from pipeclamp_identification.fitting.identify import software

        put(software())
        raise typer.Exit


TYPER_INTERRUPTED = 130
"""Exit status that Typer makes of Ctrl-C."""


def main() -> None:
    """Run the command line; a user's mistake is one message on stderr and status 1 or (usage) 2.

    Raises:
        KeyboardInterrupt: the user stopped it; how to go on, where it isn't the same command from its start.
    """
    one_thread_throughout()
    try:
        app(prog_name="pipeclamp")
    except SystemExit as end:
        if end.code == TYPER_INTERRUPTED:
            raise KeyboardInterrupt from end
        raise
    except InterruptError as error:
        raise KeyboardInterrupt(str(error)) from error
    except (UserError, OSError) as error:
        told = f"pipeclamp: {error if isinstance(error, UserError) else message(str(error))}"
        put(told, to=errors(), style="red")
        sys.exit(2 if isinstance(error, UsageError) else 1)


@app.callback()
def program(
    version: Annotated[
        bool,
        typer.Option("--version", metavar="", is_eager=True, callback=_tell_version, help="Show the version and exit."),
    ] = False,
) -> None:
    """Take what stands before a command; the help is the program's own."""


@app.command(epilog="Example: pipeclamp demo my_demo")
def demo(
    folder: Annotated[Path, typer.Argument(metavar="[FOLDER]", help="Where the results go.")] = Path("pipeclamp_demo"),
) -> None:
    """The whole story on bundled data, in about a minute."""
    from pipeclamp.demo import AFTER_DEMO, run_demo

    def tell(line: str) -> None:
        style = MARKED if is_doubt(line.strip()) else None
        put(line, style=style)

    for path in run_demo(folder, tell):
        put(f"  open {path}")
    print_next(AFTER_DEMO)
