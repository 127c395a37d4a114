"""The parameter file: a law as data, JSON with a published schema. Reading it never executes anything."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import AliasChoices, BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipeclamp_models.base.answer import LeftOutRun
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import read_text, write_whole
from pipeclamp_models.base.toml_file import explained
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import Law, Structure

SCHEMA: Final = "pipeclamp-law-1"
COVARIANCE_ROUNDING: Final = 1e-6
"""Share by which a covariance may pass what it can be: more than its digits leave."""
RANGE_UNITS: Final = {"A": "mm", "f": "Hz", "T": "K"}
"""Of the ends of a law's range."""
OF_METRICS: Final = "metrics"
"""The method of a law that was fitted to metrics without records."""

CoefficientState = Literal["fitted", "held", "frozen", "at_bound", "given"]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class LawFilePart(BaseModel):
    """What all parts of the file share: unknown keys are refused, values don't change once read."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Prior(LawFilePart):
    """What was held likely of a parameter before the tests: a normal distribution. What they leave open stays near."""

    mean: Finite
    standard_deviation: Annotated[float, Field(gt=0, allow_inf_nan=False)]


class CoefficientEntry(LawFilePart):
    """One parameter of the law.

    `state` says how it came about: "fitted"; "held" (by the law's structure or by wish); "frozen" (the data can't
    determine it); "at_bound" (the fit ran into a bound that physics sets); "given" (taken from a source).
    """

    value: Finite
    unit: str
    standard_error: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    state: CoefficientState
    meaning: str = ""
    reason: str = ""
    prior: Prior | None = None


class Interval(LawFilePart):
    """Where a quantity lay in the data."""

    minimum: Finite
    maximum: Finite
    unit: str

    @model_validator(mode="after")
    def _ordered(self) -> Interval:
        if self.minimum > self.maximum:
            raise ValueError(f"minimum {self.minimum:g} is above maximum {self.maximum:g}")
        return self


class Covariance(LawFilePart):
    """Covariance of the fitted parameters, rows and columns in the order of `names`."""

    names: tuple[str, ...]
    matrix: tuple[tuple[Finite, ...], ...]

    @model_validator(mode="after")
    def _square(self) -> Covariance:
        count = len(self.names)
        if len(self.matrix) != count or any(len(row) != count for row in self.matrix):
            raise ValueError(f"the matrix must be {count} x {count}, as there are {count} names")
        for i, row in enumerate(self.matrix):
            for j in range(i + 1):
                self._refuse_pair(i, j, row[j])
        return self

    def _refuse_pair(self, i: int, j: int, value: float) -> None:
        """Refuse a value that no two parameters' covariance can have: variances aren't below 0, and bound it."""
        largest = math.sqrt(max(self.matrix[i][i], 0.0)) * math.sqrt(max(self.matrix[j][j], 0.0))
        if abs(value) > largest * (1 + COVARIANCE_ROUNDING):
            raise ValueError(
                f"the matrix has {value:g} for {self.names[i]} and {self.names[j]}; expected {largest:g} at most"
                if i != j
                else f"the matrix has {value:g} as the variance of {self.names[i]}; expected 0 or more"
            )
        if abs(value - self.matrix[j][i]) > largest * COVARIANCE_ROUNDING:
            raise ValueError(
                f"the matrix has {value:g} and {self.matrix[j][i]:g} for {self.names[i]} and {self.names[j]}; "
                "expected the same on both sides of its diagonal"
            )


class Correlation(LawFilePart):
    """A pair of parameters that the data can hardly tell apart."""

    pair: tuple[str, str]
    value: Annotated[float, Field(ge=-1, le=1)]


class DataSource(LawFilePart):
    """The data that the law was identified from; `warnings` say which of its units are likely wrong.

    Where `time_measured` is false, a cycle was taken for a second: the law says nothing of speeds and frequencies.
    `about_mm` is the displacement about which the tests moved, where that isn't about zero.
    """

    name: str
    fingerprint: str
    runs_used: Annotated[int, Field(ge=0)]
    left_out: tuple[LeftOutRun, ...] = ()
    warnings: tuple[str, ...] | None = None
    time_measured: Literal[False] | None = None
    about_mm: Finite | None = None

    @property
    def is_timed(self) -> bool:
        """Whether its speeds and frequencies mean something."""
        return self.time_measured is None


class RunQuality(LawFilePart):
    """How well the law fits one run; nrmse: root of the summed squared error over the summed squared force."""

    run: str
    nrmse: Finite
    noise_nrmse: Finite | None = None


class FitQuality(LawFilePart):
    """How well the law fits its data.

    `mean_share` is the share of the squared force that the runs' mean forces hold, where it is most; `unsettled` are
    cycles on which the law's memory didn't become periodic, if any.
    """

    method: str
    nrmse: Finite
    noise_nrmse: Finite | None = None
    mean_share: Annotated[float, Field(gt=0, lt=1)] | None = None
    runs: tuple[RunQuality, ...] = ()
    unsettled: Annotated[int, Field(ge=1)] | None = None

    @property
    def of_metrics(self) -> bool:
        """Whether the data are metrics alone: errors are then rms log ratios."""
        return self.method == OF_METRICS


class Estimate(LawFilePart):
    """A value with its standard error."""

    value: Finite
    standard_error: Annotated[float, Field(ge=0, allow_inf_nan=False)]


class GroupEntry(LawFilePart):
    """A group of the runs that the law was identified from, which has factors of its own; they are no part of the law.

    Stiffness and damping are factors on the law's, the mean force adds to it; what isn't there doesn't differ.
    """

    column: str
    name: str
    runs: Annotated[int, Field(ge=1)]
    stiffness_factor: Estimate | None = None
    damping_factor: Estimate | None = None
    mean_force_N: Estimate | None = None


class Shares(LawFilePart):
    """Standard deviations of the shares by which a law's elastic and damping force are off."""

    stiffness: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    damping: Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Foretold(LawFilePart):
    """How far a law is off at the end of a condition's range where the tests there are left out.

    `step` is how far the end lies from the next level: of A and f the natural logarithm of their ratio, else the
    difference in the condition's own unit.
    """

    step: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    error: Shares


class KrigedShare(LawFilePart):
    """How the share by which a law's force is off follows the conditions.

    `shares` at the conditions of `at`, `variances` of what scatters in them; between them it has the standard deviation
    `deviation`, and stays alike over the `lengths`: of A and f natural logarithms, else in the condition's own unit.
    """

    deviation: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    lengths: dict[str, Annotated[float, Field(gt=0, allow_inf_nan=False)]]
    shares: tuple[Finite, ...]
    variances: tuple[Annotated[float, Field(ge=0, allow_inf_nan=False)], ...]


class LocalForm(LawFilePart):
    """Where a law's form is off, and how: at the tested conditions `at`, A in mm, f in Hz, T in K and further ones."""

    at: dict[str, tuple[Finite, ...]]
    stiffness: KrigedShare
    damping: KrigedShare

    @model_validator(mode="after")
    def _fits(self) -> LocalForm:
        counts = {len(values) for values in self.at.values()}
        for share in (self.stiffness, self.damping):
            counts |= {len(share.shares), len(share.variances)}
            if set(share.lengths) != set(self.at):
                raise ValueError(f"lengths are of {sorted(share.lengths)}; expected {sorted(self.at)}, as in at")
        if len(counts) != 1 or 0 in counts:
            raise ValueError("at, shares and variances must be equally long, and not empty")
        for name in {"A", "f"} & set(self.at):
            if min(self.at[name]) <= 0:
                raise ValueError(f"at.{name}: {min(self.at[name]):g} isn't above 0")
        return self


class Spread(LawFilePart):
    """What tests scatter about their law beside the parameters' covariance, as shares of its force.

    `runs`: between runs (mountings, specimens) at the same conditions; `form`: what the law leaves over on left-out
    conditions besides, inside its range; `local`: how that follows the conditions, where enough were tested; `beyond`:
    that at the ends of the range of A, f, T and further conditions.
    """

    runs: Shares
    form: Shares
    beyond: dict[str, Foretold] = {}
    local: LocalForm | None = None


class FormerLaw(LawFilePart):
    """The law as it stood before it was changed: what its force is computed from, and no more."""

    base: str
    effects: tuple[str, ...] = ()
    declared: tuple[Declaration, ...] = ()
    values: dict[str, Finite]


Verdict = Literal["complete", "missing", "ambiguous", "unknown"]
"""What a diagnosis can find."""
NamedKind = Literal["cause", "part"]
"""A cause explains what is missing, and its form fits; a part takes so much of it, and something that acts alike may
stand behind it."""


class HistoryStep(LawFilePart):
    """One step of the law's way: what was done, what the error did, and the law at that step, of all but the last.

    `nrmse` is the error on the tests used; `refitted_nrmse` that on left-out conditions, each foretold by a fit without
    them. A diagnosis estimates the latter from the fit to all, as `heldout_nrmse`, which is another number.
    """

    step: str
    nrmse: Finite
    refitted_nrmse: Finite | None = Field(
        default=None,
        validation_alias=AliasChoices("refitted_nrmse", "heldout_nrmse"),  # files have had it under the other name
        description="error on left-out groups of A and f, of fits without them",
    )
    kind: NamedKind | None = Field(default=None, description="how the diagnosis meant what was added, where one did")
    few_settings: Literal[True] | None = Field(
        default=None, description="of the tests are too few left for errors on left-out ones to tell laws apart"
    )
    stage: FormerLaw | None = None


class InVain(LawFilePart):
    """An effect, or two `with` each other, tried and not in the law: errors on left-out groups without and with it."""

    effect: str
    refitted_nrmse: tuple[Finite, Finite]


@dataclass(frozen=True)
class Provenance:
    """How a law's file comes about: the command that makes it again, and when it is made; None leaves the line out."""

    command: str
    date: str | None = None


class LastDiagnosis(LawFilePart):
    """What the last diagnosis of the law as it stands found: its verdict, what it named, on which tests.

    `in_vain` are effects that it had named, and that didn't help when they were added.
    """

    verdict: Verdict
    effects: tuple[str, ...] = ()
    tests: str
    in_vain: tuple[InVain, ...] = ()


class LawFile(LawFilePart):
    """A law with its parameters, their uncertainty, its range and where it comes from.

    `declared` holds the declarations of a user's own effects. `smoothing` holds v_r (mm/s) and y_r (mm), below which
    sgn v and sgn y are smooth. `range` is keyed by A (mm), f (Hz) and, where they are known, T (K) and further
    conditions. `diagnosis` is there where `diagnose --auto` wrote the law. `date` is the one line that `--reproducible`
    leaves out.
    """

    schema_name: Literal["pipeclamp-law-1"] = Field(alias="schema")
    name: str
    notes: str = ""
    base: str
    effects: tuple[str, ...] = ()
    declared: tuple[Declaration, ...] = ()
    smoothing: dict[Literal["v_r", "y_r"], Annotated[float, Field(gt=0, allow_inf_nan=False)]]
    coefficients: dict[str, CoefficientEntry]
    covariance: Covariance | None = None
    spread: Spread | None = None
    correlations: tuple[Correlation, ...] = ()
    range: dict[str, Interval]
    data: DataSource
    fit: FitQuality | None = None
    groups: tuple[GroupEntry, ...] | None = None
    history: tuple[HistoryStep, ...] = ()
    diagnosis: LastDiagnosis | None = None
    software: str
    command: str
    date: str | None = None

    @property
    def about(self) -> float:
        """Displacement about which the tests moved, mm."""
        return self.data.about_mm or 0.0

    @model_validator(mode="after")
    def _complete(self) -> LawFile:
        missing = {"v_r", "y_r"} - set(self.smoothing)
        if missing:
            raise ValueError(f"smoothing lacks {', '.join(sorted(missing))}")
        missing = {"A", "f"} - set(self.range)
        if missing:
            raise ValueError(f"range lacks {', '.join(sorted(missing))}")
        for name, unit in RANGE_UNITS.items():
            stated = self.range[name].unit if name in self.range else ""
            if stated not in ("", unit):
                raise ValueError(f"range.{name}: unit {stated!r}; expected {unit!r}, and the ends in it")
        for name in ("A", "f"):  # coefficients are powers of them, and a clamp at rest is taken for the smallest
            interval = self.range[name]
            if not interval.minimum > 0:
                raise ValueError(f"range.{name}: minimum {interval.minimum:g} {interval.unit} isn't above 0")
        return self


def structure_of(file: LawFile) -> Structure:
    """Give the structure that the file names, with what it holds."""
    held = tuple(sorted((name, entry.value) for name, entry in file.coefficients.items() if entry.state == "held"))
    return Structure(file.base, file.effects, held, file.declared)


def law_of(file: LawFile) -> Law:
    """Give the law that the file describes.

    Raises:
        UserError: an effect is not known, or the coefficients are not those of the structure, or in other units.
    """
    structure = structure_of(file)
    parameters = {parameter.name: parameter for parameter in structure.equations.parameters}
    names, given = set(parameters), set(file.coefficients)
    if names != given:
        raise UserError(
            f"law {file.name!r}: the coefficients don't belong to base {file.base!r} with effects "
            f"{list(file.effects)}: missing {sorted(names - given)}, not expected {sorted(given - names)}"
        )
    for name, entry in file.coefficients.items():
        if entry.unit not in ("", parameters[name].unit):
            raise UserError(
                f"law {file.name!r}: coefficients.{name}.unit: got {entry.unit!r}; expected {parameters[name].unit!r}, "
                "and the value in it"
            )
    values = {name: entry.value for name, entry in file.coefficients.items()}
    return Law(structure, values, file.smoothing["v_r"], file.smoothing["y_r"])


def former_law_of(file: LawFile) -> FormerLaw:
    """Give what a later law's history keeps of this one."""
    values = {name: entry.value for name, entry in file.coefficients.items()}
    return FormerLaw(base=file.base, effects=file.effects, declared=file.declared, values=values)


def law_at(file: LawFile, former: FormerLaw) -> Law:
    """Give the law as it stood at an earlier step of a file's history.

    Raises:
        UserError: an effect is not known, or the values are not those of its structure.
    """
    structure = Structure(former.base, former.effects, (), former.declared)
    if set(structure.equations.names) != set(former.values):
        raise UserError(f"law {file.name!r}: history: the values of {list(former.effects)} aren't its own")
    return Law(structure, former.values, file.smoothing["v_r"], file.smoothing["y_r"])


def read_law(path: Path) -> LawFile:
    """Read a parameter file.

    Raises:
        UserError: the file is missing, is not JSON, or is not of the schema; the message names the place.
    """
    return parse_law(read_text(path, "a law, as identify writes it"), str(path))


def parse_law(text: str, where: str) -> LawFile:
    """Read a parameter file's text; `where` is named in errors.

    Raises:
        UserError: the text is not JSON, not of the schema, or names effects that don't make a law.
    """
    try:
        file = LawFile.model_validate_json(text, strict=False)
        law_of(file)
    except UserError as error:
        raise UserError(f"{where}: {error}") from error
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        if first["type"] == "json_invalid" and "EOF" in first["msg"]:
            line = text.count("\n") + 1
            raise UserError(f"{where}: the JSON breaks off in line {line}; expected the whole file") from error
        raise UserError(
            f"{where}: {explained(error)}; correct it ({SCHEMA}), or fit the law anew: pipeclamp identify"
        ) from error
    return file


def is_newer(file: LawFile, version: str) -> bool:
    """Tell whether a file was made by a later version of this program than the given one, such as 0.1.0."""

    def numbers(text: str) -> list[int]:
        return [int(part) for part in re.findall(r"\d+", text)][:3]

    return file.software.startswith("pipeclamp ") and numbers(file.software) > numbers(version)


def law_text(file: LawFile) -> str:
    """Give the file's text: keys in the schema's order, numbers as short as they read back the same."""
    content = file.model_dump(by_alias=True, exclude_none=True, mode="json")
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def write_law(file: LawFile, path: Path) -> None:
    """Write a parameter file, whole or not at all.

    Raises:
        UserError: the folder can't be written.
    """
    write_whole(path, law_text(file))
