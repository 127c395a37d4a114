"""The cases of the truth table: which there are, and how one is drawn, sized and measured."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Protocol, TypeVar

import numpy as np
from beyond.registry import LAWS
from hidden import COLUMN, EFFECTS, Kind, draw_shape, effect_id
from rig import BETWEEN_STARTS, DESIGNS, Batch, Quality, batches, campaign_of, held_out, measured, plan, recorded
from truth import Array, BaseLaw, Motion, Part, force
from unlisted import UNLISTED

from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.diagnosis.further_test.next_test import Proposal
from pipeclamp_identification.diagnosis.further_test.outlook import RIDDEN, RIDING_ORDER, RIDING_SHARE, RUNS_OF_A_TEST
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.misfit import misfits
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of, per_cycle
from pipeclamp_models.law.law import Structure

KINDS: Mapping[str, Kind] = {**EFFECTS, **UNLISTED, **{name: law.kind for name, law in LAWS.items()}}
STRENGTHS = {"weak": (0.3, 0.6), "middle": (0.6, 1.5), "strong": (1.5, 5.0)}
IMITATED = {"open": 1.5, "nearly open": 4.0}
"""Standard deviations by which a narrow campaign as a whole tells the truth from an imitation of it."""
SHARES = {"small": 0.01, "large": 0.03}
"""What the base law can't imitate in a narrow campaign, as a share of the force (rms)."""
FORMS = ("clean", "rough")
NOISES = {"low": (0.0015, 0.004), "high": (0.006, 0.015)}
NONE_REPEATS = 12
PAIRS = (
    ("memory", "damping_temperature"), ("memory", "contact_growth"), ("end_stop", "inertia"), ("gap", "viscous"),
    ("asymmetry", "contact_growth"), ("directional_damping", "stiffness_frequency"), ("hardening", "delay"),
    ("relaxation", "damping_temperature"), ("coulomb", "loosening"), ("density", "memory"),
    ("condition", "contact_growth"), ("offset", "quadratic_damping"), ("loosening", "damping_temperature"),
    ("inertia", "asymmetry"), ("density", "damping_temperature"), ("end_stop", "viscous"),
)  # fmt: skip
"""Two effects at once; none of them imitates the other."""
SEVERAL = (
    ("memory", "damping_temperature", "asymmetry"), ("end_stop", "viscous", "contact_growth"),
    ("relaxation", "asymmetry", "damping_temperature"), ("hardening", "quadratic_damping", "loosening"),
    ("gap", "contact_growth", "directional_damping"), ("density", "memory", "inertia", "asymmetry"),
    ("condition", "end_stop", "offset", "contact_growth"),
    ("relaxation", "hardening", "directional_damping", "density"),
    ("memory", "damping_temperature", "inertia", "asymmetry", "loosening"),
    ("hardening", "relaxation", "condition", "directional_damping", "delay"),
    ("end_stop", "density", "viscous", "contact_growth", "asymmetry"),
)  # fmt: skip
"""Three to five effects at once; none of them imitates another."""
SCATTER = (0.002, 0.004)
"""Run-to-run scatter of stiffness and damping in rough cases."""
ZEROS = (0.005, 0.002)
"""By which zeros differ from run to run in rough cases: shares of the rms force and of the largest amplitude."""
COLOURED = 0.3
MOST_COARSE = 80.0
"""A proposed test is sampled at least so many times a cycle."""


@dataclass(frozen=True)
class Case:
    """One row of the experiment.

    Attributes:
        kind: "effect", "none", "two", "several", "unlisted", "narrow", "beyond" or "beside".
        hidden: kinds of physics in the truth.
        form: "clean" or "rough".
        strength: a key of STRENGTHS, in narrow plans of SHARES, "" where nothing is hidden.
        noise: a key of NOISES, in narrow plans of IMITATED.
        design: name of a test plan.
        repeat: number of the draw.
        rival: the effect that imitates the hidden one, in narrow plans.
    """

    kind: str
    hidden: tuple[str, ...]
    form: str
    strength: str
    noise: str
    design: str
    repeat: int = 0
    rival: str = ""

    @property
    def name(self) -> str:
        """Its unique name."""
        what = "+".join(self.hidden) or "nothing"
        what += f" or {self.rival}" if self.rival else ""
        return "/".join((self.kind, what, self.form, self.strength or "-", self.noise, self.design, str(self.repeat)))

    @property
    def family(self) -> tuple[str, ...]:
        """What a share of the cases is spread over."""
        return (self.kind, self.form, *self.hidden)

    @property
    def truth(self) -> frozenset[str]:
        """The ids that a diagnosis should name."""
        return frozenset(effect_id(kind) for kind in self.hidden if kind in EFFECTS)

    def known_as(self, name: str) -> str:
        """Give the id that an effect's id counts as: rough forms may be another effect as much as their own."""
        kinds = (kind for kind in self.hidden if self.form == "rough" and KINDS[kind].rough_is == name)
        return next(map(effect_id, kinds), name)


def all_cases() -> list[Case]:
    """Give every case, in a fixed order."""
    cases: list[Case] = []
    for form in FORMS:
        for number, (hidden, strength, design) in enumerate(itertools.product(EFFECTS, STRENGTHS, DESIGNS)):
            noise = ("low", "high")[(number + number // 2 + number // 6) % 2]
            cases.append(Case("effect", (hidden,), form, strength, noise, design))
        for number, (noise, design) in itertools.product(range(NONE_REPEATS), itertools.product(NOISES, DESIGNS)):
            cases.append(Case("none", (), form, "", noise, design, number))
        for number, (pair, design) in enumerate(itertools.product(PAIRS, DESIGNS)):
            strength = ("middle", "strong")[(number + number // 2) % 2]
            cases.append(Case("two", pair, form, strength, ("low", "high")[number // 2 % 2], design))
        for number, (hidden, strength, design) in enumerate(itertools.product(UNLISTED, STRENGTHS, DESIGNS)):
            noise = ("low", "high")[(number + number // 2 + number // 6) % 2]
            cases.append(Case("unlisted", (hidden,), form, strength, noise, design))
        for number, (several, design) in enumerate(itertools.product(SEVERAL, DESIGNS)):
            strength = ("middle", "strong")[(number + number // 2) % 2]
            cases.append(Case("several", several, form, strength, ("low", "high")[number // 2 % 2], design))
    return cases


class Drawable(Protocol):
    """A case of any experiment."""

    @property
    def name(self) -> str:
        """Its unique name."""

    @property
    def family(self) -> tuple[str, ...]:
        """What a share of the cases is spread over."""


AnyCase = TypeVar("AnyCase", bound=Drawable)


def chosen(cases: Sequence[AnyCase], share: float, seed: int) -> list[AnyCase]:
    """Give a share of the cases, spread evenly over their families; the same seed gives the same ones."""
    families: dict[tuple[str, ...], list[AnyCase]] = {}
    for case in cases:
        families.setdefault(case.family, []).append(case)
    random = np.random.default_rng(seed)
    kept: set[str] = set()
    for family in families.values():
        expected = share * len(family)
        count = int(expected) + int(random.uniform() < expected % 1.0)
        kept.update(family[place].name for place in random.permutation(len(family))[:count])
    return [case for case in cases if case.name in kept]


@dataclass(frozen=True)
class Drawn:
    """A case, drawn: the truth and the rig.

    Attributes:
        base: the base law.
        shapes: of each hidden kind.
        runs, heldout: motion of the campaign and of the conditions left out.
        needs: what varies besides A, f, T.
        noise_share: rms of the noise as a share of the rms force.
        target: wanted strength of each hidden kind.
        noise_seed: of the sensors.
    """

    case: Case
    base: BaseLaw
    shapes: tuple[Mapping[str, float], ...]
    runs: tuple[Batch, ...]
    heldout: tuple[Batch, ...]
    needs: frozenset[str]
    noise_share: float
    target: tuple[float, ...]
    noise_seed: int

    def forces(self, runs: Sequence[Batch], sizes: Sequence[float], scattered: bool) -> list[Array]:
        """Give the true force of each batch, (R, n)."""
        scatter = SCATTER if scattered and self.case.form == "rough" else (0.0, 0.0)
        return [
            force(self.base, batch.motion, parts(self.case, self.base, self.shapes, batch.motion, sizes), scatter)
            for batch in runs
        ]

    @cached_property
    def force_rms(self) -> float:
        """Rms force of the base law over all samples of the campaign, N."""
        nothing = (0.0,) * len(self.case.hidden)
        forces = self.forces(self.runs, nothing, False)
        shown = [recorded(batch, f)[2] for batch, f in zip(self.runs, forces, strict=True)]
        return float(np.sqrt(sum(np.sum(f**2) for f in shown) / sum(f.size for f in shown)))


def parts(
    case: Case, base: BaseLaw, shapes: Sequence[Mapping[str, float]], motion: Motion, sizes: Sequence[float]
) -> tuple[Part, ...]:
    """Give what is hidden in a case, at these sizes."""
    return tuple(
        KINDS[kind].part(motion, base, case.form == "rough", size, shape)
        for kind, size, shape in zip(case.hidden, sizes, shapes, strict=True)
        if size != 0.0
    )


def case_random(case: Case, seed: int) -> np.random.Generator:
    """Give the generator of all that is drawn for a case."""
    return np.random.default_rng([seed, zlib.crc32(case.name.encode())])


def draw_base(random: np.random.Generator) -> BaseLaw:
    """Draw a base law."""
    return BaseLaw(
        k10=random.uniform(800, 2500), k1_A=random.uniform(-0.4, 0.0), k1_T=random.uniform(-0.2, 0.1),
        k30=random.uniform(100, 1000), k3_A=random.uniform(-1.0, 0.0), k3_T=random.uniform(-0.2, 0.1),
        c0=random.uniform(30, 200), c_A=random.uniform(-0.2, 0.3), c_f=random.uniform(-0.5, -0.1),
        alpha0=random.uniform(0.25, 0.8), alpha_A=random.uniform(-0.1, 0.3), alpha_f=random.uniform(-0.05, 0.05),
    )  # fmt: skip


def draw_needs(case: Case, random: np.random.Generator) -> frozenset[str]:
    """Draw what varies besides A, f and T: what the hidden kinds need, and where none is found, anything."""
    needs = {KINDS[kind].needs for kind in case.hidden} - {""}
    if case.kind in ("none", "unlisted"):
        needs |= {need for need in ("density", "condition", "cycles") if random.uniform() < 0.25}
    return frozenset(needs)


def draw_between(random: np.random.Generator, between: tuple[float, float]) -> float:
    """Draw a number of which the logarithm is uniform."""
    return float(np.exp(random.uniform(*np.log(between))))


def draw(case: Case, seed: int) -> Drawn:
    """Draw the truth and the rig of a case."""
    random = case_random(case, seed)
    design = plan(case.design)
    base = draw_base(random)
    fixed = draw_needs(case, random)
    # Where a plan has too few temperatures, what happens at one is drawn as for a plan that has them.
    temperatures = max(design.temperatures, DESIGNS["A"].temperatures, key=len)
    shapes = tuple(draw_shape(random, design.amplitudes, temperatures) for _ in case.hidden)
    target = tuple(draw_between(random, STRENGTHS.get(case.strength, (1.0, 1.0))) for _ in case.hidden)
    share = draw_between(random, NOISES.get(case.noise, (1.0, 1.0)))
    return Drawn(
        case, base, shapes, tuple(batches(design, random, fixed)),
        tuple(batches(held_out(case.design), random, fixed)), fixed, share, target, int(random.integers(2**31)),
    )  # fmt: skip


def unimitated_rms(drawn: Drawn, sizes: Sequence[float], effects: tuple[str, ...] = ()) -> float:
    """Give the rms of the noise-free force that the base law (with effects) can't imitate, N, over all samples.

    It is counted in the harmonics that the loops keep: sample by sample, the steps of friction at reversals would
    count where a phase is off by part of a sample only. What no harmonic shows (hum, subharmonics, drift within a
    record) counts sample by sample. The force is sampled finely here: what coarse samples fold is no lack of the law.
    """
    forces = drawn.forces(drawn.runs, sizes, False)
    channels = [recorded(batch, f, FINELY) for batch, f in zip(drawn.runs, forces, strict=True)]
    campaign = campaign_of("noise-free", drawn.runs, channels, drawn.needs)
    loops = loops_of(campaign)
    structure = Structure("power", effects)
    if set(drawn.case.hidden) & NOT_LOCKED:
        runs = misfits(fit_structure(structure, loops).law, campaign, loops)
        return float(np.sqrt(sum(run.squared_error for run in runs) / sum(len(run.measured) for run in runs)))
    loops = per_cycle(loops) if structure.equations.ages else loops
    observations = loop_observations(loops)
    squares = observations.mean_squares(fit_structure(structure, loops, observations).law_force)
    return float(np.sqrt(np.average(squares, weights=loops.samples)))


FINELY = 2
"""Fine steps between the samples of a noise-free record."""
WITHIN = 0.07
"""A strength this near to the wanted one, as a share, is good enough."""
MOST_STEPS = 8
FINEST = 0.001
"""No noise is less than this share of the rms force."""
WELL_SEEN = 1.0
"""What the base law can't imitate in a narrow campaign is at least this share of the noise."""
NOT_LOCKED = frozenset({"mains_hum", "subharmonic", "impact"})
"""Kinds that the harmonics of the loops don't show, or not in full."""


def sized(drawn: Drawn) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Find sizes at which what the base law can't imitate has the wanted strength.

    Returns:
        sizes; strengths reached; rms of the noise in N, less than drawn where an effect can't be large enough.
    """
    if drawn.case.rival:
        return _sized_against_rival(drawn)
    drawn_noise = drawn.noise_share * drawn.force_rms
    noise = drawn_noise
    for _ in drawn.case.hidden:
        found = [_size(drawn, place, target * noise) for place, target in enumerate(drawn.target)]
        # an effect that can't be larger is measured with less noise, as far as sensors go
        most = min(rms / target for (_, rms), target in zip(found, drawn.target, strict=True))
        if most > noise * (1 - WITHIN):
            break
        noise = max(most, min(drawn_noise, FINEST * drawn.force_rms))
    else:
        found = [_size(drawn, place, target * noise) for place, target in enumerate(drawn.target)]
    return tuple(size for size, _ in found), tuple(rms / noise for _, rms in found), noise


def _sized_against_rival(drawn: Drawn) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Find the noise at which an imitation can hardly be told from the truth, but the base law can; as `sized`."""
    size, rms = _size(drawn, 0, SHARES[drawn.case.strength] * drawn.force_rms)
    left = unimitated_rms(drawn, (size,), (drawn.case.rival,))
    samples = sum(recorded(batch, batch.motion.y)[1].size for batch in drawn.runs)
    noise = left * np.sqrt(samples) / IMITATED[drawn.case.noise]
    noise = float(np.clip(noise, FINEST * drawn.force_rms, rms / WELL_SEEN))
    return (size,), (rms / noise,), noise


def _size(drawn: Drawn, place: int, wanted: float) -> tuple[float, float]:
    """Find the size of one of the hidden kinds that leaves the base law with this rms in N; size and rms."""
    return size_alone(drawn.case, place, wanted, partial(unimitated_rms, drawn))


def size_alone(
    case: Case, place: int, wanted: float, unimitated: Callable[[Sequence[float]], float]
) -> tuple[float, float]:
    """Find the size of one of the hidden kinds, alone, at which what the base law can't imitate is as wanted.

    Args:
        case: the case.
        place: of the kind.
        wanted: rms of what the base law can't imitate.
        unimitated: gives that of all hidden kinds' sizes.

    Returns:
        size, and what is reached with it: less than wanted where the kind can't be large enough.
    """
    kind = KINDS[case.hidden[place]]
    size, rms = kind.start, 0.0
    for _ in range(MOST_STEPS):
        rms = unimitated([size if index == place else 0.0 for index in range(len(case.hidden))])
        if abs(rms / wanted - 1) < WITHIN or (size >= kind.most and rms < wanted):
            break
        size = min(size * float(np.clip(wanted / max(rms, 1e-9), 0.1, 10.0)), kind.most)
    return size, rms


@dataclass(frozen=True)
class Measured:
    """A case, measured.

    Attributes:
        campaign, heldout: what a user gets, and the same clamp at other conditions.
        heldout_floor: error on `heldout`, as a share of its force, of the truth itself, told the displacement
            that the sensor shows: noise and scatter between runs.
        sizes, strengths: of what is hidden.
        noise_share: rms noise as a share of the rms force.
    """

    campaign: Campaign
    heldout: Campaign
    heldout_floor: float
    sizes: tuple[float, ...]
    strengths: tuple[float, ...]
    noise_share: float


def quality_of(drawn: Drawn, noise: float) -> Quality:
    """Give how well the rig of a case measures, at this rms of the force noise in N."""
    rough = drawn.case.form == "rough"
    force_zero, displacement_zero = ZEROS if rough else (0.0, 0.0)
    return Quality(
        noise=noise,
        coloured=COLOURED if rough else 0.0,
        displacement_noise=1e-4,
        force_step=noise / 3,
        displacement_step=1e-5,
        force_zero=force_zero * drawn.force_rms,
        displacement_zero=displacement_zero * max(plan(drawn.case.design).amplitudes),
    )


def further_runs(drawn: Drawn, done: Measured, campaign: Campaign, proposal: Proposal) -> Campaign:
    """Run a proposed test a few times on the same clamp and rig; give the campaign with these runs at its end.

    Args:
        drawn: the case.
        done: as it was measured at first.
        campaign: its campaign so far.
        proposal: the test.
    """
    A, f, T = proposal.amplitude_mm, proposal.frequency_Hz, proposal.temperature_C
    ridden = (RIDING_ORDER, RIDING_SHARE) if proposal.profile == RIDDEN else None
    before = len(campaign.runs)
    named = {"N": "cycles", "rho": "density", f"u_{COLUMN}": "condition"}
    wanted = {named[signal]: value for signal, value in proposal.further.items()}
    wanted = {"cycles": BETWEEN_STARTS * before, **wanted}
    random = np.random.default_rng([drawn.noise_seed, before])
    design = replace(plan(drawn.case.design), amplitudes=(A,), frequencies=(f,), temperatures=(T,))
    design = replace(design, rate=max(design.rate, MOST_COARSE * f))
    added: list[Run] = []
    noise = done.noise_share * drawn.force_rms
    for repeat in range(RUNS_OF_A_TEST):
        runs = batches(design, random, drawn.needs, ridden, wanted)
        channels = []
        for batch, true in zip(runs, drawn.forces(runs, done.sizes, True), strict=True):
            time, y, shown = recorded(batch, true)
            channels.append((time, *measured(time, y, shown, quality_of(drawn, noise), random)))
        fresh = campaign_of("proposed", runs, channels, drawn.needs).runs
        added += [replace(run, name=f"{run.name}_next{before + repeat}") for run in fresh]
    return replace(campaign, fingerprint="sha256:extended", runs=(*campaign.runs, *added))


def _as_shown(batch: Batch, place: Array) -> Batch:
    """Give runs with the zero that their displacement sensor had: no law is told another."""
    zero = np.mean(place - recorded(batch, batch.motion.y)[1], axis=1, keepdims=True)
    return replace(batch, motion=replace(batch.motion, y=batch.motion.y + zero, memory={}))


def measure(drawn: Drawn) -> Measured:
    """Size what is hidden and measure the campaigns."""
    sizes, strengths, noise = sized(drawn)
    random = np.random.default_rng(drawn.noise_seed)
    quality = quality_of(drawn, noise)
    campaigns = []
    for name, runs in (("campaign", drawn.runs), ("heldout", drawn.heldout)):
        channels = []
        for batch, true in zip(runs, drawn.forces(runs, sizes, True), strict=True):
            time, y, f = recorded(batch, true)
            channels.append((time, *measured(time, y, f, quality, random)))
        campaigns.append((campaign_of(f"{drawn.case.name} {name}", runs, channels, drawn.needs), channels))
    error = total = 0.0
    channels = campaigns[1][1]
    moved = [_as_shown(batch, place) for batch, (_, place, _) in zip(drawn.heldout, channels, strict=True)]
    for batch, true, (_, _, shown) in zip(moved, drawn.forces(moved, sizes, False), channels, strict=True):
        error += float(np.sum((shown - recorded(batch, true)[2]) ** 2))
        total += float(np.sum(shown**2))
    return Measured(
        campaigns[0][0], campaigns[1][0], float(np.sqrt(error / total)), sizes, strengths, noise / drawn.force_rms
    )
