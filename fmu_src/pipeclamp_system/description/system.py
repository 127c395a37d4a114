"""SYSTEM.toml: a pipe, the laws of its clamps, the excitation and how to run them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, StrictBool, model_validator

from pipeclamp_models.base.toml_file import Celsius, Number, Positive, ShortName, TomlTable, read_described
from pipeclamp_system.description.scheme import ROLLS_BACK, Scheme

LawMode = Literal["given", "solved", "tracked"]

MOST_STEPS = 5_000_000
"""More than these don't fit into memory with all that is kept of each."""


class PipeSource(TomlTable):
    """The pipe: its description, or a finished FMU; `variables` gives a foreign FMU's names for ours.

    Ours are base.a or excitation.f, and for each clamp NAME.s, NAME.v, NAME.f, for each probe NAME.s.
    """

    file: str | None = None
    fmu: str | None = None
    variables: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (self.fmu is None):
            raise ValueError("expected either file = 'PIPE.toml' or fmu = 'pipe.fmu'")
        if self.file is not None and self.variables:
            raise ValueError("variables belong to fmu = ...; a described pipe has our names")
        return self


class ClampSource(TomlTable):
    """One clamp: where it sits, its law or finished FMU, and the motion that its law's coefficients are taken for.

    Amplitude and frequency are those given here; with `solve` they are only where it starts, and the run is repeated
    until the clamp's motion shows those that it was given, held inside the data of the law where that is named; with
    `track` the FMU estimates them as it goes. `conditions` are further ones that the law follows, by column of
    runs.csv; the middle of the law's range where they are left out. `variables` gives a foreign FMU's names for ours:
    flange.s, flange.v, flange.f.
    """

    at: ShortName
    law: str | None = None
    fmu: str | None = None
    temperature_C: Celsius
    amplitude_mm: Positive | None = None
    frequency_Hz: Positive | None = None
    track: StrictBool = False
    solve: StrictBool = False
    conditions: Annotated[dict[str, Number], Field(default_factory=dict)]
    variables: dict[str, str] = Field(default_factory=dict)

    @property
    def mode(self) -> LawMode:
        """Where the law's A and f come from."""
        return "tracked" if self.track else "solved" if self.solve else "given"

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.track and self.solve:
            raise ValueError("track and solve exclude each other: A and f are followed as they come, or found by runs")
        if (self.law is None) == (self.fmu is None):
            raise ValueError("expected either law = 'LAW.json' or fmu = 'clamp.fmu'")
        if self.amplitude_mm is None and not self.track:
            raise ValueError("amplitude_mm is missing: the law's coefficients depend on it; give it, or track = true")
        return self


class ExcitationTable(TomlTable):
    """The excitation: a sine, a sweep or a record; of the base's acceleration or displacement, or of the force."""

    kind: Literal["sine", "sweep", "record"]
    acceleration_m_s2: Positive | None = None
    displacement_mm: Positive | None = None
    force_N: Positive | None = None
    frequency_Hz: Positive | None = None
    from_Hz: Positive | None = None
    to_Hz: Positive | None = None
    file: str | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        amplitudes = [self.acceleration_m_s2, self.displacement_mm, self.force_N]
        given = {
            name
            for name in ("acceleration_m_s2", "displacement_mm", "force_N", "frequency_Hz", "from_Hz", "to_Hz", "file")
            if getattr(self, name) is not None
        }
        needed = {"sine": {"frequency_Hz"}, "sweep": {"from_Hz", "to_Hz"}, "record": {"file"}}[self.kind]
        allowed = needed | (set() if self.kind == "record" else {"acceleration_m_s2", "displacement_mm", "force_N"})
        if needed - given:
            raise ValueError(f"kind = {self.kind!r} needs {', '.join(sorted(needed - given))}")
        if given - allowed:
            raise ValueError(f"{', '.join(sorted(given - allowed))} doesn't belong to kind = {self.kind!r}")
        if self.kind != "record" and sum(value is not None for value in amplitudes) != 1:
            raise ValueError("expected one amplitude: acceleration_m_s2, displacement_mm (of the base) or force_N")
        return self

    @property
    def highest_frequency(self) -> float | None:
        """Of a sine or a sweep, Hz; None for a record."""
        return max(filter(None, (self.frequency_Hz, self.from_Hz, self.to_Hz)), default=None)


class RunTable(TomlTable):
    """How to run: until when, in which macro steps, coupled how, to which tolerance.

    With `energy_tolerance` the macro step follows the energy that the coupling makes, as a share of what is exchanged;
    `step_s` is then the longest. A result whose coupling made more than `trusted_share` of the energy that the
    excitation gave, whose displacement errs by more than that for its steps, or that hid more than that of a clamp's
    motion between the steps, is marked.
    """

    stop_s: Positive
    step_s: Positive
    scheme: Scheme = "iterated"
    tolerance: Annotated[Positive, Field(lt=0.1)] = 1e-6
    max_iterations: Annotated[int, Field(strict=True, ge=2, le=10_000)] = 60
    energy_tolerance: Annotated[Positive, Field(lt=1)] | None = None
    trusted_share: Annotated[Positive, Field(lt=1)] = 0.02

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        if self.energy_tolerance is not None and self.scheme not in ROLLS_BACK:
            raise ValueError(
                f"energy_tolerance needs a scheme that rolls back; expected {' or '.join(sorted(ROLLS_BACK))}"
            )
        if self.step_s > self.stop_s:
            raise ValueError(f"step_s = {self.step_s:g} is longer than stop_s = {self.stop_s:g}")
        if self.stop_s / self.step_s > MOST_STEPS:
            raise ValueError(f"stop_s/step_s = {self.stop_s / self.step_s:.0f} steps; expected at most {MOST_STEPS}")
        return self

    @property
    def steps(self) -> int:
        """How many macro steps."""
        return max(1, round(self.stop_s / self.step_s))

    @property
    def even_step_s(self) -> float:
        """The macro step that is taken, s: `step_s`, or so near to it that whole steps end at `stop_s`."""
        return self.stop_s / self.steps


class ResponseTable(TomlTable):
    """What `pipeclamp response` draws.

    Attributes:
        from_Hz, to_Hz: the frequencies.
        levels: factors on the excitation's amplitude, a curve each.
        temperatures_C: of all clamps, a set of curves each; the clamps' own where it is left out.
        harmonics: up to which the motion of the clamps is balanced; as many as it asks for where left out.
        dots: co-simulations along each curve.
    """

    from_Hz: Positive
    to_Hz: Positive
    levels: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=20)] = (1.0,)
    temperatures_C: Annotated[tuple[Celsius, ...], Field(max_length=20)] = ()
    harmonics: Annotated[int, Field(strict=True, ge=1, le=31)] | None = None
    dots: Annotated[int, Field(strict=True, ge=0, le=100)] = 5

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if self.from_Hz >= self.to_Hz:
            raise ValueError(f"from_Hz = {self.from_Hz:g} isn't below to_Hz = {self.to_Hz:g}")
        return self


class SystemDescription(TomlTable):
    """A coupled system; paths are relative to the file they stand in."""

    name: str = "system"
    notes: str = ""
    pipe: PipeSource
    clamps: tuple[ClampSource, ...] = ()
    excitation: ExcitationTable
    run: RunTable
    response: ResponseTable | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        seen: set[str] = set()
        for index, clamp in enumerate(self.clamps, 1):
            if clamp.at in seen:
                raise ValueError(f"clamps[{index}].at = {clamp.at!r} is there twice; expected one law per place")
            seen.add(clamp.at)
            if clamp.frequency_Hz is None and self.excitation.kind != "sine" and not clamp.track:
                raise ValueError(
                    f"clamps[{index}].frequency_Hz is missing: the law's coefficients depend on it and the excitation "
                    "isn't one sine; give it, or track = true"
                )
        return self


def files_of_system(path: Path) -> list[Path]:
    """Give the files that a system's description names: pipe, laws, FMUs, a record; a bundled law's name is none.

    Raises:
        UserError: as of `read_system`.
    """
    system = read_system(path)
    names = [system.pipe.file or system.pipe.fmu, *(clamp.law or clamp.fmu for clamp in system.clamps)]
    named = [path.parent / name for name in (*names, system.excitation.file) if name]
    return [file for file in named if file.is_file()]


def read_system(path: Path) -> SystemDescription:
    """Read a coupled system.

    Raises:
        UserError: the file is missing, is not TOML, or describes no system; the message names the place.
    """
    return read_described(path, SystemDescription, "system")
