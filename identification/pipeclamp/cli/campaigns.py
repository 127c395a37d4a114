"""The command line's part for making tests: a virtual rig's, and several in one."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pipeclamp.cli.terminal import (
    DeclaredOption,
    EffectsOption,
    LawArgument,
    StrictOption,
    command_called,
    folder_option,
    is_stated,
    names_in,
    numbers_in,
    opened_law,
    print_next,
    print_table,
    put,
    showing_progress,
    values_in,
    warn,
)
from pipeclamp_models.base.said import counted

app = typer.Typer()


class RecordFormat(StrEnum):
    """Formats of records that the virtual rig writes."""

    csv = "csv"
    csv_gz = "csv.gz"
    parquet = "parquet"


@app.command(epilog="Example: pipeclamp rig law.json -o virtual --effects viscous --set c1=2 --temperatures 20,150,300")
def rig(
    context: typer.Context,
    law: LawArgument,
    output: Annotated[Path, folder_option("CAMPAIGN", "The folder to write; it must not exist.")],
    effects: EffectsOption = "",
    declared: DeclaredOption = None,
    set_values: Annotated[
        str,
        typer.Option(
            "--set",
            metavar="name=value,...",
            help="Sizes of parameters, in the units that `pipeclamp effects EFFECT` states, and further columns; "
            "parameters of --effects that aren't named get typical sizes, which are shown.",
        ),
    ] = "",
    amplitudes: Annotated[str, typer.Option(metavar="mm,...")] = "0.2,0.5,0.8,1",
    frequencies: Annotated[str, typer.Option(metavar="Hz,...")] = "1,3,5",
    temperatures: Annotated[str, typer.Option(metavar="°C,...")] = "20,100,200,300",
    drive: Annotated[
        Path | None,
        typer.Option(
            metavar="DRIVE.csv", help="A drive signal that every run follows, as `diagnose --drive` writes it."
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Run the campaign that `pipeclamp plan -o` wrote, in its order."),
    ] = None,
    repeats: Annotated[int, typer.Option(help="Runs of each combination.")] = 1,
    cycles: Annotated[float, typer.Option(help="Cycles per record; need not be whole.")] = 5.0,
    ramp_cycles: Annotated[float, typer.Option(help="Cycles of ramp-in before them.")] = 0.0,
    rate: Annotated[float, typer.Option(help="Samples per second.")] = 1000.0,
    force_noise: Annotated[float, typer.Option(help="Rms noise of the force sensor, N.")] = 3.0,
    displacement_noise: Annotated[float, typer.Option(help="Rms noise of the displacement sensor, mm.")] = 0.0002,
    force_step: Annotated[float, typer.Option(help="Quantisation of the force, N.")] = 0.1,
    displacement_step: Annotated[float, typer.Option(help="Quantisation of the displacement, mm.")] = 0.0001,
    about: Annotated[
        float | None, typer.Option(help="Displacement that the runs move about, mm; as the law's tests unless told.")
    ] = None,
    distortion: Annotated[float, typer.Option(help="Third harmonic of the drive, share of the amplitude.")] = 0.005,
    riding: Annotated[float, typer.Option(help="Small cycles on the large one, share of its amplitude.")] = 0.0,
    riding_order: Annotated[int, typer.Option(help="So many of them a cycle.")] = 7,
    amplitude_error: Annotated[float, typer.Option(help="Rms error of the amplitude, as a share.")] = 0.005,
    temperature_error: Annotated[float, typer.Option(help="Rms error of the temperature, K.")] = 1.0,
    force_drift: Annotated[float, typer.Option(help="Drift of the force channel's zero, N/s.")] = 0.0,
    displacement_drift: Annotated[float, typer.Option(help="Drift of the displacement channel's zero, mm/s.")] = 0.0,
    force_gain_drift: Annotated[float, typer.Option(help="Drift of the force channel's gain, share per second.")] = 0.0,
    force_range: Annotated[float, typer.Option(help="Where the force sensor ends, N; 0: nowhere.")] = 0.0,
    displacement_range: Annotated[float, typer.Option(help="Where that of displacement ends, mm; 0: nowhere.")] = 0.0,
    specimens: Annotated[int, typer.Option(min=0, help="Specimens, each run in every combination; 0: no name.")] = 0,
    specimen_scatter: Annotated[float, typer.Option(help="Rms share by which their k and c differ.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="Of the random numbers.")] = 0,
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.csv,
) -> None:
    """A virtual campaign of a law: would this test plan see that effect?"""
    from pipeclamp.show.effects import truth_table
    from pipeclamp_identification.campaign.rig.plan import TestPlan
    from pipeclamp_identification.workflow.next_command import after_import
    from pipeclamp_identification.workflow.virtual_campaign import (
        OF_NO_DRIVE,
        OF_NO_PLAN,
        make_virtual_campaign,
        refuse_stated_twice,
    )
    from pipeclamp_models.law.declaration_files import read_effects

    stated = [name for name in {*OF_NO_DRIVE, *OF_NO_PLAN} if is_stated(context, name)]
    refuse_stated_twice(stated, drive, plan, lambda name: f"--{name.replace('_', '-')}")
    with showing_progress("rig") as tell:
        asked = TestPlan(
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
            about=about,
            distortion=distortion,
            riding=riding,
            riding_order=riding_order,
            amplitude_error=amplitude_error,
            temperature_error=temperature_error,
            force_drift=force_drift,
            displacement_drift=displacement_drift,
            force_gain_drift=force_gain_drift,
            force_range=force_range,
            displacement_range=displacement_range,
            specimens=specimens,
            specimen_scatter=specimen_scatter,
            repeats=repeats,
            seed=seed,
        )
        ids, declarations = read_effects(names_in(effects), declared or ())
        made = make_virtual_campaign(
            opened_law(law), output, asked, notes=f"Virtual rig: {command_called()}", effects=ids,
            declared=declarations, values=values_in(set_values, "--set"), drive=drive, plan=plan, format=format.value,
            progress=tell,
        )  # fmt: skip
    for words in made.beyond:
        warn(f"beyond the law's data: {words}")
    if made.truth.whence:
        print_table(truth_table(made.truth))
    put(f"{output}: {counted(made.count, 'run')}")
    if drive is None:  # what a drive signal gives is one test more, for tests that aren't named here
        print_next(after_import(str(output)))


@app.command(epilog="Example: pipeclamp join tests next_test -o all_tests")
def join(
    campaigns: Annotated[list[Path], typer.Argument(metavar="CAMPAIGN...", help="Tests of one clamp.")],
    output: Annotated[Path, folder_option("CAMPAIGN", "The folder to write; it must not exist.")],
    strict: StrictOption = False,
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.csv,
) -> None:
    """Several campaigns of one clamp in one: the tests so far and the next one."""
    from pipeclamp_identification.campaign.reading import Campaign
    from pipeclamp_identification.workflow.joining import join_campaigns
    from pipeclamp_identification.workflow.next_command import after_import

    def tell_left_out(one: Campaign) -> None:
        for entry in one.left_out:
            warn(str(entry))

    with showing_progress("join") as tell:
        count = join_campaigns(
            campaigns, output, strict=strict, format=format.value, read=tell_left_out, progress=tell
        )  # fmt: skip
    put(f"{output}: {counted(count, 'run')}")
    print_next(after_import(str(output)))
