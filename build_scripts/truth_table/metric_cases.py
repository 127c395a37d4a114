"""The cases of which dW and W alone are kept: which there are, and how one is drawn, sized and measured."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from cases import FORMS, PAIRS, Case, case_random, draw_base, draw_between, draw_needs, parts, size_alone
from hidden import EFFECTS, draw_shape
from metric_loops import PLANS, Errors, Luck, draw_luck, driven, energies, printed
from truth import Array, BaseLaw, force

from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.law import rms
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.law.law import Structure

UNSEEN = ("asymmetry", "directional_damping", "offset")
"""Effects that change neither a loop's area nor the range of its force: nothing is the honest answer to them."""
SEEN = tuple(kind for kind in EFFECTS if kind not in UNSEEN)
SEEN_PAIRS = tuple(pair for pair in PAIRS if not set(pair) & set(UNSEEN))
SEEN_UNLISTED = ("static_friction", "amplitude_and_temperature", "resonance", "amplitude_phase")
"""Physics of no catalogue that changes dW or W differently over the conditions."""
METRIC_STRENGTHS = {"small": (1.0, 3.0), "large": (3.0, 10.0)}
"""What the base law can't imitate of log dW and log W, over their scatter (rms each)."""
SCATTERS = {"low": (0.002, 0.005), "high": (0.005, 0.015)}
"""Rms of what the rig's errors make of log dW and log W."""
UNSEEN_SIZES = (0.1, 0.4)
"""Share of the largest reasonable size."""
EMPTY_REPEATS = 10
ERRORS = {
    "clean": Errors(reading=0.01),
    "rough": Errors(
        amplitude=0.004, temperature=1.5, stiffness=0.002, damping=0.005, reading=0.003, distortion=0.005
    ),
}  # fmt: skip
"""What the scatter is made of; how large it is in all is drawn."""


def metric_cases() -> list[Case]:
    """Give every case, in a fixed order."""
    cases: list[Case] = []
    for form in FORMS:
        for number, (hidden, strength, plan) in enumerate(itertools.product(SEEN, METRIC_STRENGTHS, PLANS)):
            cases.append(Case("effect", (hidden,), form, strength, ("low", "high")[number % 2], plan))
        for number, noise, plan in itertools.product(range(EMPTY_REPEATS), SCATTERS, PLANS):
            cases.append(Case("none", (), form, "", noise, plan, number))
        for number, (hidden, plan) in enumerate(itertools.product(UNSEEN, PLANS)):
            cases.append(Case("none", (hidden,), form, "", ("low", "high")[number % 2], plan))
        for number, (pair, plan) in enumerate(itertools.product(SEEN_PAIRS, PLANS)):
            cases.append(Case("two", pair, form, "large", ("low", "high")[number % 2], plan))
        for number, (hidden, strength, plan) in enumerate(itertools.product(SEEN_UNLISTED, METRIC_STRENGTHS, PLANS)):
            cases.append(Case("unlisted", (hidden,), form, strength, ("low", "high")[number % 2], plan))
    return cases


@dataclass(frozen=True)
class DrawnMetrics:
    """A case, drawn: the truth, the plan and the rig.

    Attributes:
        base: the base law.
        shapes: of each hidden kind.
        needs: what varies besides A, f, T.
        luck: what the rig's errors are made of.
        scatter: wanted rms of what they make of log dW and log W.
        target: wanted strength of each hidden kind; of one that can't be seen, its size.
    """

    case: Case
    base: BaseLaw
    shapes: tuple[Mapping[str, float], ...]
    needs: frozenset[str]
    luck: Luck
    scatter: float
    target: tuple[float, ...]

    def energies(self, sizes: Sequence[float], errors: Errors) -> Array:
        """Give dW and W of each row in J, (R, 2), as they are read."""
        plan = PLANS[self.case.design]
        result = np.empty((len(plan), 2))
        for series in driven(plan, self.luck, errors, self.needs):
            hidden = parts(self.case, self.base, self.shapes, series.motion, sizes)
            shown = force(self.base, series.motion, hidden, (errors.stiffness, errors.damping))
            result[series.places] = energies(series.motion, shown)
        return np.asarray(result * np.exp(errors.reading * self.luck.reading))

    def campaign(self, sizes: Sequence[float], errors: Errors) -> MetricCampaign:
        """Give what a user gets."""
        text = printed(PLANS[self.case.design], self.energies(sizes, errors), self.luck.order, self.needs)
        with TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "campaign.toml").write_text(f'name = "{self.case.name}"\n', encoding="utf-8")
            (folder / "runs.csv").write_text(text, encoding="utf-8")
            return read_tests(folder, strict=True).metrics()

    def errors(self, sizes: Sequence[float]) -> Errors:
        """Give errors that make the wanted scatter: what they do is as good as proportional to them."""
        errors = ERRORS[self.case.form]
        return errors.times(self.scatter / self.scatter_of(sizes, errors))

    def scatter_of(self, sizes: Sequence[float], errors: Errors) -> float:
        """Give the rms of what errors make of log dW and log W."""
        return rms(np.log(self.energies(sizes, errors) / self.energies(sizes, errors.times(0.0))))


def draw_metrics(case: Case, seed: int) -> DrawnMetrics:
    """Draw the truth and the rig of a case."""
    random = case_random(case, seed)
    base, needs = draw_base(random), draw_needs(case, random)
    A, _, T = (tuple(sorted(set(column))) for column in zip(*PLANS[case.design], strict=True))
    shapes = tuple(draw_shape(random, A, T) for _ in case.hidden)
    luck = draw_luck(random, len(PLANS[case.design]))
    scatter = draw_between(random, SCATTERS[case.noise])
    if case.kind == "none":
        target = tuple(EFFECTS[kind].most * draw_between(random, UNSEEN_SIZES) for kind in case.hidden)
    else:
        target = tuple(draw_between(random, METRIC_STRENGTHS[case.strength]) for _ in case.hidden)
    return DrawnMetrics(case, base, shapes, needs, luck, scatter, target)


def unimitated_logs(drawn: DrawnMetrics, sizes: Sequence[float], effects: tuple[str, ...] = ()) -> float:
    """Give the rms of log dW and log W, free of scatter, that the base law (with effects) can't imitate."""
    observations = metric_observations(drawn.campaign(sizes, Errors()))
    return rms(observations.logs(fit(Structure("power", effects), observations).law_force.force))


@dataclass(frozen=True)
class MeasuredMetrics:
    """A case, measured.

    Attributes:
        campaign: what a user gets.
        strengths: of each hidden kind, what the base law can't imitate over the scatter; none where none can be seen.
        scatter: rms of what the rig's errors made of log dW and log W.
    """

    campaign: MetricCampaign
    strengths: tuple[float, ...]
    scatter: float


def measure_metrics(drawn: DrawnMetrics) -> MeasuredMetrics:
    """Size what is hidden and measure the campaign."""
    if drawn.case.kind == "none":
        sizes, strengths = drawn.target, ()
    else:
        found = [
            size_alone(drawn.case, place, target * drawn.scatter, lambda sizes: unimitated_logs(drawn, sizes))
            for place, target in enumerate(drawn.target)
        ]
        sizes = tuple(size for size, _ in found)
        strengths = tuple(reached / drawn.scatter for _, reached in found)
    errors = drawn.errors(sizes)
    return MeasuredMetrics(drawn.campaign(sizes, errors), strengths, drawn.scatter_of(sizes, errors))
