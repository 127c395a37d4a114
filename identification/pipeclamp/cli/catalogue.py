"""The command line's part for what the program knows by itself: effects and schemas."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from pipeclamp.cli.terminal import DeclaredOption, JsonOption, print_table, put, spare
from pipeclamp_models.base.files import write_whole

app = typer.Typer()

TERMINAL_WIDTH = 80
"""Columns that every terminal has."""


@app.command(epilog="Example: pipeclamp effects memory")
def effects(
    effect: Annotated[
        str | None, typer.Argument(metavar="[EFFECT]", help="Show this one whole: equation, sizes, source.")
    ] = None,
    declared: DeclaredOption = None,
    json: JsonOption = None,
) -> None:
    """The catalogue: every effect, what it does and what imitates it; or one effect whole."""
    from pipeclamp.show import effects as shown
    from pipeclamp_models.realise.catalogue_answer import TYPICAL_LAW, asked_effects, catalogue_answer

    spare(*(declared or ()), outputs=(json,))
    asked = asked_effects(effect or None, declared or ())
    if json:
        write_whole(json, catalogue_answer(asked).json_text())
    if not effect:
        print_table(shown.overview(asked), TERMINAL_WIDTH)
        put("One whole, with its equation, units, sizes and source: pipeclamp effects EFFECT")
        return
    one = asked[0]
    for line in shown.equation_lines(one):
        put(line)
    for table in shown.tables_of(one):
        print_table(table, TERMINAL_WIDTH)
    put(f"Bounds and typical sizes are those for the bundled clamp {TYPICAL_LAW}.")
    for line in shown.about_lines(one):
        put(line)


@app.command(epilog="Example: pipeclamp schema diagnosis > diagnosis.schema.json")
def schema(
    name: Annotated[
        str,
        typer.Argument(
            metavar="[law|metrics|comparison|laws-comparison|system-comparison|diagnosis|discovery|import|effects|"
            "band-plan|campaign-plan]",
            help="Of what is written.",
        ),
    ] = "law",
) -> None:
    """The JSON schema of parameter files, or of what --json writes."""
    from pipeclamp_identification.workflow.schemas import schema_text

    sys.stdout.write(schema_text(name))
