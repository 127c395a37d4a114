"""The command line's part for making tests: a virtual rig's, and several in one; nothing is computed here."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pipeclamp_identification.terminal import (
    DeclaredOption,
    EffectsOption,
    LawArgument,
    StrictOption,
    command_called,
    console,
    errors,
    folder_option,
    names_in,
    numbers_in,
    opened_law,
    told,
    values_in,
)

app = typer.Typer()


class RecordFormat(StrEnum):
    """Formats of records that the virtual rig writes."""

    csv = "csv"
    csv_gz = "csv.gz"
    parquet = "parquet"


@app.command(epilog="Example: pipeclamp rig law.json -o virtual --effects viscous --set c1=2 --temperatures 20,150,300")
def rig(
    law: LawArgument,
    output: Annotated[Path, folder_option("CAMPAIGN", "The folder to write; it must not exist.")],
    effects: EffectsOption = "",
    declared: DeclaredOption = None,
    set_values: Annotated[
        str, typer.Option("--set", metavar="name=value,...", help="Of parameters and further columns.")
    ] = "",
    amplitudes: Annotated[str, typer.Option(metavar="mm,...")] = "0.2,0.5,0.8,1",
    frequencies: Annotated[str, typer.Option(metavar="Hz,...")] = "1,3,5",
    temperatures: Annotated[str, typer.Option(metavar="degC,...")] = "20,100,200,300",
    cycles: Annotated[float, typer.Option(help="Cycles per record; need not be whole.")] = 5.0,
    ramp_cycles: Annotated[float, typer.Option(help="Cycles of ramp-in before them.")] = 0.0,
    rate: Annotated[float, typer.Option(help="Samples per second.")] = 1000.0,
    force_noise: Annotated[float, typer.Option(help="Rms noise of the force sensor, N.")] = 3.0,
    displacement_noise: Annotated[float, typer.Option(help="Rms noise of the displacement sensor, mm.")] = 0.0002,
    force_step: Annotated[float, typer.Option(help="Quantisation of the force, N.")] = 0.1,
    displacement_step: Annotated[float, typer.Option(help="Quantisation of the displacement, mm.")] = 0.0001,
    distortion: Annotated[float, typer.Option(help="Third harmonic of the drive, share of the amplitude.")] = 0.005,
    riding: Annotated[float, typer.Option(help="Small cycles on the large one, share of its amplitude.")] = 0.0,
    riding_order: Annotated[int, typer.Option(help="So many of them a cycle.")] = 7,
    amplitude_error: Annotated[float, typer.Option(help="Rms error of the amplitude, as a share.")] = 0.005,
    temperature_error: Annotated[float, typer.Option(help="Rms error of the temperature, K.")] = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Of the random numbers.")] = 0,
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.csv,
) -> None:
    """A virtual campaign of a law: would this test plan see that effect?"""
    from pipeclamp.declaration import read_effects
    from pipeclamp_identification import rig as virtual
    from pipeclamp_identification.campaign_writing import write_campaign

    with told("rig") as tell:
        plan = virtual.TestPlan(
            amplitudes=numbers_in(amplitudes, "--amplitudes"),
            frequencies=numbers_in(frequencies, "--frequencies"),
            temperatures=numbers_in(temperatures, "--temperatures"),
            cycles=cycles,
            ramp_cycles=ramp_cycles,
            rate=rate,
            force_noise=force_noise,
            displacement_noise=displacement_noise,
            force_step=force_step,
            displacement_step=displacement_step,
            distortion=distortion,
            riding=riding,
            riding_order=riding_order,
            amplitude_error=amplitude_error,
            temperature_error=temperature_error,
            seed=seed,
        )
        ids, declarations = read_effects(names_in(effects), declared or ())
        file = opened_law(law)
        truth, conditions = virtual.truth_law(file, ids, values_in(set_values), declarations)
        runs = virtual.virtual_runs(truth, plan, conditions)
        notes = f"Virtual rig: {command_called()}"
        count = write_campaign(output, runs, name=output.name, notes=notes, format=format.value, progress=tell)
    for words in virtual.beyond_range(file, plan):
        errors.print(f"warning: beyond the law's data: {words}", style="yellow", highlight=False, soft_wrap=True)
    console.print(f"{output}: {count} runs")


@app.command(epilog="Example: pipeclamp join tests next_test -o all_tests")
def join(
    campaigns: Annotated[list[Path], typer.Argument(metavar="CAMPAIGN...", help="Tests of one clamp.")],
    output: Annotated[Path, folder_option("CAMPAIGN", "The folder to write; it must not exist.")],
    strict: StrictOption = False,
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.csv,
) -> None:
    """Several campaigns of one clamp in one: the tests so far and the next one."""
    from pipeclamp_identification.bundled_campaigns import campaign_folder
    from pipeclamp_identification.campaign import read_campaign
    from pipeclamp_identification.campaign_writing import joined_runs, write_campaign

    with told("join") as tell:
        tests = [read_campaign(campaign_folder(folder), strict=strict) for folder in campaigns]
        for entry in (entry for one in tests for entry in one.left_out):
            errors.print(f"warning: {entry}", style="yellow", markup=False, highlight=False, soft_wrap=True)
        notes = f"Joined of {', '.join(one.name for one in tests)}"
        count = write_campaign(
            output, joined_runs(tests), name=output.name, notes=notes, format=format.value, progress=tell
        )
    console.print(f"{output}: {count} runs")
