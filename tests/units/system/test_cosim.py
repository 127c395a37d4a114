"""Co-simulation with real FMUs: against the monolithic solution, its energy balance, its results, its refusals."""

from __future__ import annotations

import json
import re
import sys
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, pi
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import polars as pl
import pytest
from cantilever import cantilever
from fmpy.fmi1 import FMICallException
from stick_slip import Modal, Rubbing, integrate

from pipeclamp.pages.system.cosim import cosim_sections
from pipeclamp_fmu.build import build_clamp, build_excitation, build_native_clamp, build_pipe
from pipeclamp_fmu.contents.excitation import Samples
from pipeclamp_fmu.describe.ssv import NAMESPACES
from pipeclamp_fmu.ssp import Component, SystemStructure, write_ssp
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.cosim import ssp as system_ssp
from pipeclamp_system.cosim.building import PYTHON
from pipeclamp_system.cosim.divergence import IMPOSSIBLE
from pipeclamp_system.cosim.result import CosimResult, write_result
from pipeclamp_system.cosim.run import run_described, run_system
from pipeclamp_system.cosim.summary import summary_of
from pipeclamp_system.description.excitation import excitation_signal
from pipeclamp_system.description.system import read_system
from pipeclamp_system.fmus.participant import FmuParticipant
from pipeclamp_system.transient.monolithic import MonolithicResult, clamp_equations, solve_monolithic

SSD = f"{{{NAMESPACES['ssd']}}}"

PIPE_STIFFNESS = 20.23
"""N/mm, static, at clamp1."""

pipe_text = partial(cantilever, up_to_Hz=200, probes={"tip": 3.0})

SMOOTH = {"k10": 4.0, "k30": 1.0, "c0": 0.05, "alpha0": 1.0}
SOFT = {"k10": 4.0, "k30": 1.0, "c0": 3.0, "alpha0": 0.45, "k1_T": -0.3, "c_T1": -0.5}
STIFF = {"k10": 10 * PIPE_STIFFNESS, "k30": 40.0, "c0": 10.0, "alpha0": 0.45, "k1_T": -0.3, "c_T1": -0.5}


def write_system(
    folder: Path,
    scheme: str = "iterated",
    laws: Mapping[str, str] | None = None,
    frequency: float = 9.0,
    acceleration: float = 2.0,
    amplitude_mm: float = 1.0,
    temperature_C: float = 20.0,
    stop: float = 0.4,
    step: float = 1e-3,
    more: str = "",
) -> Path:
    clamps = "".join(
        f'[[clamps]]\nat = "{at}"\n{source}\ntemperature_C = {temperature_C!r}\namplitude_mm = {amplitude_mm!r}\n'
        for at, source in (laws or {"clamp1": 'fmu = "smooth.fmu"'}).items()
    )
    path = folder / "SYSTEM.toml"
    path.write_text(
        f'name = "test"\n[pipe]\nfmu = "pipe.fmu"\n{clamps}[excitation]\nkind = "sine"\n'
        f"acceleration_m_s2 = {acceleration!r}\nfrequency_Hz = {frequency!r}\n"
        f'[run]\nstop_s = {stop!r}\nstep_s = {step!r}\nscheme = "{scheme}"\n{more}',
        encoding="utf-8",
    )
    return path


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    """Give a folder with pipes, laws and their FMUs."""
    folder = tmp_path_factory.mktemp("bench")
    clamps = {
        "pipe": {"clamp1": 2.0},
        "pipe2": {"clamp1": 2.0, "clamp2": 2.6},
        "pipe2_swapped": {"clamp2": 2.6, "clamp1": 2.0},
    }
    for name, places in clamps.items():
        (folder / f"{name}.toml").write_text(pipe_text(ratio=0.01, clamps=places), encoding="utf-8")
        build_pipe(reduce(read_pipe(folder / f"{name}.toml")), folder / f"{name}.fmu")
    laws = {
        "smooth": (SMOOTH, "power", ()),
        "soft": (SOFT, "power", ("damping_temperature",)),
        "stiff": (STIFF, "power", ("damping_temperature",)),
        "slip": ({"k10": 5.0, "c0": 0.01, "k_s": 200.0, "z_s": 8.0}, "memory", ()),
    }
    for name, (values, base, effects) in laws.items():
        write_law(folder / f"{name}.json", values, base, effects)
        build_clamp(read_law(folder / f"{name}.json"), folder / f"{name}.fmu")
    return folder


def reference(
    system_file: Path, laws: tuple[str, ...], pipe: str = "pipe", tolerance: float = 1e-8
) -> MonolithicResult:
    """Solve the system that a file describes as one set of equations."""
    folder = system_file.parent
    system = read_system(system_file)
    reduced = reduce(read_pipe(folder / f"{pipe}.toml"))
    signal = excitation_signal(system.excitation, reduced.excitation, system.run.stop_s, folder, "test")
    frequency = system.excitation.frequency_Hz
    assert frequency is not None
    clamps = [
        clamp_equations(
            law_of(read_law(folder / f"{name}.json")),
            clamp.amplitude_mm or 0.0,
            frequency,
            clamp.temperature_C + 273.15,
        )
        for name, clamp in zip(laws, system.clamps, strict=True)
    ]
    time = np.linspace(0.0, system.run.stop_s, system.run.steps + 1)
    return solve_monolithic(reduced, clamps, signal, time, tolerance)


def resonance(bench: Path, stiffness: float) -> float:
    """Give the first natural frequency of the pipe with a spring (N/mm) at clamp1, Hz."""
    reduced = reduce(read_pipe(bench / "pipe.toml"))
    shape = np.array(reduced.clamp_shapes[0])
    squared = np.linalg.eigvalsh(np.diag(np.array(reduced.omega) ** 2) + 1e3 * stiffness * np.outer(shape, shape))
    return float(np.sqrt(squared[0]) / (2 * pi))


def run_once(file: Path) -> CosimResult:
    """Co-simulate without another run that tells the error of its steps, where nothing asks for that."""
    return run_described(read_system(file), file.parent, str(file), checked=False)


def largest_error(result: CosimResult, exact: MonolithicResult) -> float:
    names = result.clamp_names
    ours = np.column_stack([result.columns[f"{name}.s"] for name in names])
    return float(np.abs(ours - exact.displacement).max() / np.abs(exact.displacement).max())


@pytest.mark.parametrize("scheme", ["implicit", "iterated"])
@pytest.mark.parametrize(("law", "temperature"), [("soft", 300.0), ("stiff", 20.0)])
def test_amplitude_at_resonance_is_the_monolithic_one(bench: Path, law: str, temperature: float, scheme: str) -> None:
    stiffness = {"soft": SOFT, "stiff": STIFF}[law]["k10"] * ((temperature + 273.15) / 293.15) ** -0.3
    frequency = round(resonance(bench, stiffness), 3)
    file = write_system(
        bench,
        scheme,
        laws={"clamp1": f'fmu = "{law}.fmu"'},
        frequency=frequency,
        acceleration={"soft": 3.0, "stiff": 4.0}[law],
        amplitude_mm={"soft": 2.0, "stiff": 0.3}[law],
        temperature_C=temperature,
        stop=25 / frequency,
        step=1 / (80 * frequency),
    )
    result = run_once(file)
    exact = reference(file, (law,))
    last = slice(-5 * 80, None)
    for column, values in (("clamp1.s", exact.displacement[:, 0]), ("tip.s", exact.probes[:, 0])):
        amplitude = np.ptp(values[last]) / 2
        assert np.ptp(result.columns[column][last]) / 2 == pytest.approx(amplitude, rel=0.01), column
    assert result.out_of_range == ()


FINE = 2.5e-4
"""Macro step, s, of the finer of two runs."""


@pytest.fixture(scope="module")
def smooth_reference(bench: Path) -> MonolithicResult:
    """Give the solution for a smooth law at the points of the finer run."""
    return reference(write_system(bench, step=FINE, stop=0.3), ("smooth",), tolerance=1e-10)


@pytest.mark.parametrize(("scheme", "order"), [("parallel", 1), ("sequential", 1), ("implicit", 2), ("iterated", 2)])
def test_each_scheme_s_error_falls_at_its_order(
    bench: Path, smooth_reference: MonolithicResult, scheme: str, order: int
) -> None:
    exact = smooth_reference.displacement[:, 0]
    errors = []
    for every in (2, 1):
        file = write_system(bench, scheme, step=every * FINE, stop=0.3, more="tolerance = 1e-9\n")
        ours = run_once(file).columns["clamp1.s"]
        errors.append(np.abs(ours - exact[::every]).max() / np.abs(exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)
    assert errors[1] < {1: 0.03, 2: 1e-4}[order]


def test_two_clamps_of_different_laws_one_with_memory(bench: Path) -> None:
    text = {"clamp2": 'fmu = "slip.fmu"', "clamp1": 'law = "soft.json"'}
    file = write_system(bench, laws=text, step=2.5e-4, acceleration=8.0)
    file.write_text(file.read_text(encoding="utf-8").replace("pipe.fmu", "pipe2.fmu"), encoding="utf-8")
    result = run_once(file)
    assert result.clamp_names == ("clamp2", "clamp1")
    exact = reference(file, ("slip", "soft"), pipe="pipe2_swapped")
    assert largest_error(result, exact) < 2e-3
    assert result.amplitude("clamp2.f") > 8.0  # it slips


@pytest.mark.parametrize("scheme", ["parallel", "iterated"])
def test_a_place_without_a_law_is_free(bench: Path, scheme: str) -> None:
    """The pipe alone, excited at rest far below resonance, follows its base statically."""
    file = write_system(bench, scheme, frequency=0.2, stop=2.5)
    text = file.read_text(encoding="utf-8")
    file.write_text(text[: text.index("[[clamps]]")] + text[text.index("[excitation]") :], encoding="utf-8")
    result = run_once(file)
    reduced = reduce(read_pipe(bench / "pipe.toml"))
    sag = 2.0 * np.sum(np.array(reduced.probe_shapes[0]) * reduced.excitation_participation / np.square(reduced.omega))
    assert result.columns["tip.s"].min() == pytest.approx(sag, rel=0.05)
    assert result.energy.clamps_received[-1] == 0.0


def test_the_energy_balance_closes_and_names_what_the_coupling_made(bench: Path) -> None:
    made = {}
    for scheme in ("parallel", "sequential", "iterated"):
        result = run_once(write_system(bench, scheme, laws={"clamp1": 'fmu = "soft.fmu"'}, stop=1.0))
        energy = result.energy
        total = float(np.abs(energy.excitation).max())
        assert np.abs(energy.unexplained).max() < 1e-9 * total
        assert energy.clamps_dissipated[-1] > 0.3 * total
        assert np.all(energy.pipe_stored >= 0)
        made[scheme] = energy.coupling[-1] / total
    # A force that comes late feeds the pipe: the later, the more; an iterated step's comes in time.
    assert made["parallel"] > 2 * made["sequential"] > 0
    assert abs(made["iterated"]) < 0.1 * made["sequential"]


def test_the_implicit_scheme_takes_steps_that_are_far_longer_than_the_parallel_one_s(bench: Path) -> None:
    """1 % at resonance with a clamp ten times as stiff as the pipe: `build_scripts/benchmarks/work_precision.py`."""
    frequency = round(resonance(bench, STIFF["k10"]), 3)
    laws = {"clamp1": 'fmu = "stiff.fmu"'}
    errors = {}
    for scheme, parts in (("implicit", 40), ("parallel", 20 * 40)):
        file = write_system(bench, scheme, laws, frequency, 4.0, 0.3, stop=15 / frequency, step=1 / (parts * frequency))
        errors[scheme] = largest_error(run_once(file), reference(file, ("stiff",)))
    assert errors["implicit"] < 0.01 < errors["parallel"]


def test_a_result_whose_coupling_makes_energy_is_marked_everywhere(bench: Path, tmp_path: Path) -> None:
    laws = {"clamp1": 'fmu = "soft.fmu"'}
    marked = run_system(write_system(bench, "parallel", laws, step=2.5e-3))
    assert not marked.trusted
    assert f"NOT TO BE TRUSTED: the coupling itself made {marked.coupling_share:.2%}" in summary_of(marked)
    write_result(marked, tmp_path / "marked.csv")
    assert set(pl.read_csv(tmp_path / "marked.csv")["trusted [1 yes, 0 no]"]) == {0.0}
    titles = [figure.layout.title.text for section in cosim_sections(marked) for figure in section.figures]
    assert titles
    assert all("NOT TO BE TRUSTED" in title for title in titles)
    for more in ("", "trusted_share = 0.9\n"):
        scheme = "parallel" if more else "implicit"
        fine = run_system(write_system(bench, scheme, laws, step=2.5e-3, more=more))
        assert fine.trusted
        assert "TRUSTED" not in summary_of(fine)


def test_the_coupling_s_energy_is_a_share_of_what_the_excitation_gave(bench: Path) -> None:
    """Not of what goes to and fro, which is many times that."""
    energy = run_once(write_system(bench, "parallel", {"clamp1": 'fmu = "soft.fmu"'}, step=2.5e-3)).energy
    assert energy.coupling_share == pytest.approx(np.abs(energy.coupling).max() / np.abs(energy.excitation).max())
    giving = replace(energy, clamps_dissipated=-0.1 * np.abs(energy.excitation))
    assert giving.clamps_share == pytest.approx(0.1)


def test_few_steps_in_a_period_cannot_be_trusted_whatever_the_energy_says(bench: Path) -> None:
    laws = {"clamp1": 'fmu = "smooth.fmu"'}
    more = "trusted_share = 0.9\n"
    for parts, fine in ((9, False), (11, True)):
        result = run_system(write_system(bench, "implicit", laws, step=1 / (9.0 * parts), stop=20 / 9.0, more=more))
        assert result.trusted == fine, result.doubts()
        assert ("steps in a period of the excitation, expected at least 10" in summary_of(result)) != fine


def test_a_run_of_one_step_is_held_against_its_halves(bench: Path) -> None:
    """No step is longer than the run."""
    more = "trusted_share = 0.9\n"
    result = run_system(write_system(bench, "implicit", stop=1e-3, step=1e-3, more=more))
    assert result.time.size == 2
    assert result.step_error is not None
    assert 0 < result.step_error < 0.9, result.doubts()
    unknown = replace(result, step_error=inf)
    assert "error isn't known, as no run in other steps tells it" in summary_of(unknown)


def test_what_has_not_settled_is_said(bench: Path, tmp_path: Path) -> None:
    laws = {"clamp1": 'fmu = "smooth.fmu"'}
    column = "settled [1 yes, 0 no, empty where nothing settles]"
    for stop, settled in ((1.0, 0.0), (20.0, 1.0)):
        result = run_system(write_system(bench, "implicit", laws, step=4e-3, stop=stop))
        assert ("tip" in result.unsettled) == (settled == 0.0)
        assert ("not settled: the amplitude at tip changes by" in summary_of(result)) == (settled == 0.0)
        write_result(result, tmp_path / "result.csv")
        assert set(pl.read_csv(tmp_path / "result.csv")[column]) == {settled}
    swept = result.system.excitation.model_copy(update={"kind": "sweep", "from_Hz": 1.0, "to_Hz": 9.0})
    assert replace(result, system=result.system.model_copy(update={"excitation": swept})).unsettled == {}


def test_the_advice_about_another_amplitude_is_none_that_was_followed(bench: Path) -> None:
    result = run_system(write_system(bench, laws={"clamp1": 'fmu = "smooth.fmu"'}, amplitude_mm=0.2))
    assert "set amplitude_mm to that, or solve = true, or track = true" in summary_of(result)
    ends, elsewhere = "the range of its data ends there", ("its motion is no steady sine", "A and f are not solved")
    for mode, beyond, unsolved, said in (
        ("tracked", (), 0.0, elsewhere[0]),
        ("tracked", ("clamp1",), 0.0, ends),
        ("solved", (), 0.1, elsewhere[1]),
        ("solved", (), 0.0, ends),
    ):
        clamp = result.system.clamps[0].model_copy(update={"track": mode == "tracked", "solve": mode == "solved"})
        system = result.system.model_copy(update={"clamps": (clamp,)})
        summary = summary_of(replace(result, system=system, out_of_range=beyond, unsolved=unsolved))
        assert f"mm: {said}" in summary
        assert "track = true" not in summary


def test_why_a_law_s_amplitude_is_not_that_of_the_peaks_is_said(bench: Path) -> None:
    """A third harmonic of a tenth takes a tenth of the peaks, and adds half a percent to the rms."""
    result = run_system(write_system(bench, laws={"clamp1": 'fmu = "smooth.fmu"'}, stop=1.0))
    clamp = result.system.clamps[0].model_copy(update={"track": True})
    result = replace(result, system=result.system.model_copy(update={"clamps": (clamp,)}))
    phase = 2 * np.pi * 20 * result.time
    for third, said in ((0.0, ""), (0.1, r"10\.[3-6]% less, as the motion is no sine")):
        moved = np.cos(phase) - third * np.cos(3 * phase)
        summary = summary_of(replace(result, columns={**result.columns, "clamp1.s": 1e-3 * moved}))
        assert ("A is sqrt(2) times the rms" in summary) == bool(said)
        assert re.search(said, summary), summary


def test_solved_conditions_stay_inside_the_data_of_a_law_that_is_named(bench: Path) -> None:
    content = json.loads((bench / "smooth.json").read_text(encoding="utf-8"))
    content["range"]["A"]["minimum"] = 2.0
    (bench / "far.json").write_text(json.dumps(content), encoding="utf-8")
    file = write_system(bench, "implicit", {"clamp1": 'law = "far.json"\nsolve = true'}, step=4e-3)
    result = run_system(file)
    assert 1e3 * result.columns["clamp1.A_used"][-1] == pytest.approx(2.0)
    assert 1e3 * result.amplitude("clamp1.s") < 1.6
    assert not result.unsolved
    assert "it moves with" in summary_of(result)
    assert "the range of its data ends there" in summary_of(result)


def test_an_energy_tolerance_controls_the_macro_step(bench: Path) -> None:
    laws = {"clamp1": 'fmu = "soft.fmu"'}
    shares = []
    for tolerance in (1e-2, 1e-3):
        more = f"energy_tolerance = {tolerance}\n"
        result = run_system(write_system(bench, "implicit", laws, step=8e-3, stop=0.6, more=more))
        assert result.time[-1] == pytest.approx(0.6)
        assert np.ptp(np.diff(result.time)) > 0
        assert result.coupling_share < tolerance
        shares.append(result.coupling_share)
    assert shares[1] < shares[0]


def renamed(fmu: Path, names: Mapping[str, str], output: Path) -> None:
    """Copy an FMU with other variable names, as somebody else would have given them."""
    with zipfile.ZipFile(fmu) as ours, zipfile.ZipFile(output, "w") as theirs:
        for entry in ours.namelist():
            content = ours.read(entry)
            if entry == "modelDescription.xml":
                for name, other in names.items():
                    assert content.count(f'name="{name}"'.encode()) == 1
                    content = content.replace(f'name="{name}"'.encode(), f'name="{other}"'.encode())
            theirs.writestr(entry, content)


def foreign_system(bench: Path, scheme: str) -> Path:
    """Write a system whose FMUs have other names, no energies, no parameters of ours but A, f and T."""
    energies = ("energyPipe", "energyDissipated", "workExcitation", "workClamps", "inputsAtStepEnd")
    pipe = {"base.a": "shaking", "clamp1.s": "x", "clamp1.v": "xdot", "clamp1.f": "push", "tip.s": "end"}
    renamed(
        bench / "pipe.fmu", pipe | {"tip.v": "ev", "tip.a": "ea"} | {n: f"z_{n}" for n in energies}, bench / "fp.fmu"
    )
    clamp = {"flange.s": "in1", "flange.v": "in2", "flange.f": "out", "T": "heat"}
    others = ("A_used", "f_used", "T_used", "energyDissipated", "inRange", "track")
    renamed(bench / "smooth.fmu", clamp | {name: f"z_{name}" for name in others}, bench / "fc.fmu")

    def table(names: Mapping[str, str]) -> str:
        return "{ " + ", ".join(f'"{ours}" = "{theirs}"' for ours, theirs in names.items()) + " }"

    file = write_system(bench, scheme, {"clamp1": f'fmu = "fc.fmu"\nvariables = {table(clamp)}'}, step=5e-4)
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('fmu = "pipe.fmu"', f'fmu = "fp.fmu"\nvariables = {table(pipe)}'), encoding="utf-8")
    return file


@pytest.mark.parametrize("scheme", ["parallel", "implicit", "iterated"])
def test_foreign_fmus_stand_in_for_both_sides(bench: Path, scheme: str) -> None:
    """The pipe holds its inputs over a step."""
    foreign = run_system(foreign_system(bench, scheme))
    own = run_once(write_system(bench, scheme, step=5e-4))
    scale = np.abs(own.columns["clamp1.s"]).max()
    difference = np.abs(foreign.columns["clamp1.s"] - own.columns["clamp1.s"]).max() / scale
    assert difference < (1e-12 if scheme == "parallel" else 2e-3)
    assert foreign.amplitude("tip.s") == pytest.approx(own.amplitude("tip.s"), rel=2e-3)
    assert np.isnan(foreign.columns["clamp1.A_used"]).all()
    assert np.isfinite(foreign.coupling_share)
    assert "clamp1: amplitude" in summary_of(foreign)


def test_a_foreign_fmu_that_fails_beside_its_steps_is_told(bench: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(participant: FmuParticipant) -> list[float]:
        raise FMICallException("fmi2GetReal", 3)

    monkeypatch.setattr(FmuParticipant, "outputs", failing)
    with pytest.raises(UserError, match=r"smooth\.fmu: one of these FMUs failed \(fmi2GetReal failed with status 3"):
        run_system(write_system(bench))


def test_an_ssp_of_foreign_fmus_speaks_their_names(bench: Path, tmp_path: Path) -> None:
    system_ssp.write_system(foreign_system(bench, "parallel"), tmp_path / "system.ssp", PYTHON)
    with zipfile.ZipFile(tmp_path / "system.ssp") as archive:
        archive.extractall(tmp_path)
    ssd = ElementTree.parse(tmp_path / "SystemStructure.ssd")
    ports = {
        (element.get("name"), connector.get("name"))
        for element in ssd.iter(f"{SSD}Component")
        for connector in element.iter(f"{SSD}Connector")
    }
    connections = {
        tuple((entry.get(f"{end}Element"), entry.get(f"{end}Connector")) for end in ("start", "end"))
        for entry in ssd.iter(f"{SSD}Connection")
    }
    assert connections == {
        (("excitation", "signal"), ("pipe", "shaking")),
        (("pipe", "x"), ("clamp1", "in1")),
        (("pipe", "xdot"), ("clamp1", "in2")),
        (("clamp1", "out"), ("pipe", "push")),
    }
    assert all(end in ports for connection in connections for end in connection)
    values = ElementTree.parse(tmp_path / "resources" / "clamp1.ssv")
    assert {entry.get("name") for entry in values.iter() if entry.get("name")} == {"parameters", "A", "f", "heat"}


def test_an_ssp_s_excitation_ends_with_the_run(bench: Path, tmp_path: Path) -> None:
    """Also where the step doesn't divide the run: the steps that are taken do."""
    made: list[Samples] = []

    def kept(samples: Samples, output: Path) -> None:
        made.append(samples)
        build_excitation(samples, output)

    file = write_system(bench, laws={"clamp1": 'fmu = "smooth.fmu"'}, stop=1.0, step=0.3)
    system_ssp.write_system(file, tmp_path / "system.ssp", replace(PYTHON, excitation=kept))
    (samples,) = made
    assert samples.step * (len(samples.values) - 1) == pytest.approx(1.0, rel=1e-12)
    assert samples.step == run_system(file).step


def test_an_fmu_of_fmi_3_is_refused(bench: Path, tmp_path: Path) -> None:
    build_native_clamp(read_law(bench / "smooth.json"), bench / "three.fmu", 3, ())
    file = write_system(bench, laws={"clamp1": 'fmu = "three.fmu"'})
    for use in (run_system, lambda file: system_ssp.write_system(file, tmp_path / "system.ssp", PYTHON)):
        with pytest.raises(UserError, match=r"three\.fmu: FMI 3\.0.*expected FMI 2\.0.*unless they are told --fmi 3"):
            use(file)
    structure = SystemStructure("alone", [Component("clamp1", bench / "three.fmu", {})], [], 1.0)
    with pytest.raises(UserError, match=r"three\.fmu: FMI 3\.0; expected FMI 2\.0.*without --fmi 3"):
        write_ssp(structure, tmp_path / "system.ssp")
    assert not (tmp_path / "system.ssp").exists()


def test_a_mapped_name_that_is_not_there_is_named(bench: Path) -> None:
    laws = {"clamp1": 'fmu = "smooth.fmu"\nvariables = { "flange.s" = "flange.ss" }'}
    with pytest.raises(UserError, match=r"smooth\.fmu: variable 'flange\.ss' is not known; did you mean 'flange\.s'"):
        run_system(write_system(bench, laws=laws))


def test_an_fmu_without_roll_back_gets_the_best_scheme_that_it_allows(bench: Path) -> None:
    with zipfile.ZipFile(bench / "smooth.fmu") as whole, zipfile.ZipFile(bench / "stuck.fmu", "w") as stuck:
        for entry in whole.namelist():
            content = whole.read(entry)
            if entry == "modelDescription.xml":
                content = content.replace(b'canGetAndSetFMUstate="true"', b'canGetAndSetFMUstate="false"')
            stuck.writestr(entry, content)
    laws = {"clamp1": 'fmu = "stuck.fmu"'}
    result = run_system(write_system(bench, "implicit", laws))
    assert result.scheme == "sequential"
    assert result.warnings[0].startswith("clamp1 can't save and restore a state: coupled by 'sequential'")
    assert np.array_equal(result.columns["clamp1.s"], run_system(write_system(bench, "sequential")).columns["clamp1.s"])


@pytest.mark.parametrize(("scheme", "step"), [("parallel", 5e-3), ("parallel", 2e-3), ("sequential", 5e-3)])
def test_a_diverging_run_is_stopped_in_its_step(bench: Path, scheme: str, step: float) -> None:
    laws = {"clamp1": 'fmu = "stiff.fmu"'}
    with pytest.raises(UserError, match=r"coupling diverges from step \d+ on: .*'iterated'") as stopped:
        run_system(write_system(bench, scheme, laws, step=step, stop=2.0))
    began, stopped_in, steps = map(
        int, re.findall(r"from step (\d+) on.*stopped in step (\d+) of (\d+)", str(stopped.value))[0]
    )
    assert began <= stopped_in < steps
    run_system(write_system(bench, "iterated", laws, step=step, stop=0.2))


@pytest.mark.parametrize(("stiffness", "scheme"), [(2000.0, "iterated"), (2e5, "iterated"), (2000.0, "implicit")])
def test_no_clamp_is_too_stiff_for_a_scheme_that_rolls_back(
    bench: Path, write_law: Callable[..., None], stiffness: float, scheme: str
) -> None:
    """100 and 10,000 times the pipe's stiffness in steps of 4 ms, against matrix exponentials."""
    write_law(bench / "hard.json", {"k10": stiffness, "c0": 0.02, "alpha0": 1.0})
    result = run_system(write_system(bench, scheme, {"clamp1": 'law = "hard.json"'}, 10.0, 3.0, step=4e-3, stop=1.0))
    assert "the pipe was told their means instead" in result.warnings[0]
    pipe = reduce(read_pipe(bench / "pipe.toml"))
    modal = Modal.of(pipe)
    motion = integrate(modal, [Rubbing(1e3 * stiffness, 20.0, 0.0)], 3.0, 10.0, result.time)[: len(pipe.omega)]
    exact, late = (modal.clamps @ motion)[0], result.time > 0.8
    assert np.std((result.columns["clamp1.s"] - exact)[late]) < 0.05 * np.std(exact[late])
    assert result.doubts()  # 25 steps a cycle err, and the motion of so stiff a clamp passes between them


def test_a_stiff_clamp_in_short_steps_is_told_linear_forces(bench: Path, write_law: Callable[..., None]) -> None:
    write_law(bench / "hard.json", {"k10": 2000.0, "c0": 0.02, "alpha0": 1.0})
    settled = run_system(write_system(bench, "iterated", {"clamp1": 'law = "hard.json"'}, 20.0, 3.0, stop=1.0))
    assert not settled.means_told
    assert not settled.doubts()


@pytest.mark.parametrize("scheme", ["parallel", "sequential"])
def test_a_start_into_steep_friction_is_not_taken_for_divergence(
    bench: Path, write_law: Callable[..., None], scheme: str
) -> None:
    values = {"k10": 20.0, "c0": 60.0, "alpha0": 0.2}
    write_law(bench / "steep.json", values, v_r=0.005)
    file = write_system(bench, scheme, {"clamp1": 'law = "steep.json"'}, step=2.5e-4, stop=0.5, acceleration=20.0)
    energy = run_once(file).energy
    early = energy.pipe_stored[2:20] / np.cumsum(np.abs(np.diff(energy.excitation[1:20])))
    assert early.max() > IMPOSSIBLE  # the late force made it, for a few steps
    assert abs(energy.coupling[-1]) < 0.3 * energy.excitation[-1]


def test_a_step_that_does_not_agree_is_named(bench: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = write_system(bench, laws={"clamp1": 'fmu = "stiff.fmu"'}, more="max_iterations = 2\ntolerance = 1e-12\n")
    run_system(file)  # enclosed where two trials don't do
    monkeypatch.setattr("pipeclamp_system.coupling.bracketing.MOST_SWEEPS", 0)
    with pytest.raises(UserError, match=r"step \d+ \(t = .*2 secants.*'implicit'.*max_iterations"):
        run_system(file)


@pytest.mark.parametrize("step", [1e-3, 2e-3])
def test_friction_that_holds_a_clamp_is_coupled(bench: Path, write_law: Callable[..., None], step: float) -> None:
    """The tip's amplitude is that by scipy's LSODA on the cantilever's own modes, with the same friction."""
    write_law(bench / "dry.json", {"k10": 20.0, "c0": 0.02, "alpha0": 1.0, "F_c": 60.0}, "power", ("coulomb",))
    laws = {"clamp1": 'law = "dry.json"'}
    result = run_once(write_system(bench, "iterated", laws, 7.0, 3.0, step=step, stop=2.0))
    assert 1e3 * result.amplitude("clamp1.s", 0.2) < 0.002
    assert 1e3 * result.amplitude("tip.s", 0.2) == pytest.approx(0.06695, rel=0.03)


def test_the_result_is_written_with_names_and_units(bench: Path, tmp_path: Path) -> None:
    told: list[float] = []
    result = run_system(write_system(bench), told.append)
    write_result(result, tmp_path / "RESULT.csv")
    frame = pl.read_csv(tmp_path / "RESULT.csv")
    expected = ["time [s]", "base.a [m/s2]", "clamp1.s [m]", "clamp1.v [m/s]", "clamp1.f [N]", "tip.a [m/s2]"]
    assert [name for name in frame.columns if name in expected] == expected
    assert "energy.coupling [J]" in frame.columns
    assert frame.height == 401
    assert frame["clamp1.s [m]"].to_numpy() == pytest.approx(result.columns["clamp1.s"], rel=1e-15)
    assert told[-1] == pytest.approx(1.0)
    assert all(before <= after for before, after in pairwise(told))
    summary = summary_of(result)
    assert "clamp1: amplitude" in summary
    assert "coupling" in summary
    assert "clamp1: its law is taken for an amplitude of 1 mm, and it moves with" in summary


def test_a_law_that_follows_no_amplitude_needs_none(bench: Path, write_law: Callable[..., None]) -> None:
    """It had been told to take that of its motion, which changes nothing."""
    write_law(bench / "linear.json", {"k10": 20.0, "c0": 0.02, "alpha0": 1.0})
    result = run_once(write_system(bench, laws={"clamp1": 'law = "linear.json"'}, step=4e-3, stop=1.0))
    assert abs(1e3 * result.amplitude("clamp1.s") - 1.0) > 0.1
    assert "its law is taken for an amplitude" not in summary_of(result)


def test_an_undamped_pipe_loses_nothing(bench: Path) -> None:
    """Both works and the stored energy are exact, so that nothing is left for damping."""
    (bench / "undamped.toml").write_text(pipe_text(ratio=0.0), encoding="utf-8")
    file = write_system(bench, "sequential", step=5e-3)  # a coarse step: the pipe is exact all the same
    file.write_text(
        file.read_text(encoding="utf-8").replace('fmu = "pipe.fmu"', 'file = "undamped.toml"'), encoding="utf-8"
    )
    energy = run_once(file).energy
    assert np.abs(energy.pipe_dissipated).max() < 1e-11 * np.abs(energy.excitation).max()


def test_a_run_leaves_nothing_behind(bench: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = list(sys.path)
    run_system(write_system(bench, laws={"clamp1": 'law = "smooth.json"'}, stop=0.01))
    assert list(tmp_path.iterdir()) == []
    assert sys.path == path


def test_velocity_and_acceleration_are_those_of_the_displacement(bench: Path) -> None:
    result = run_system(write_system(bench, step=2.5e-4))
    time = result.time
    relative = np.gradient(np.gradient(result.columns["tip.s"], time), time)
    absolute = relative + result.columns["base.a"]
    inner = slice(4, -4)
    scale = np.abs(result.columns["tip.a"]).max()
    assert np.abs(absolute - result.columns["tip.a"])[inner].max() < 0.02 * scale


def test_a_law_with_tracking_finds_its_amplitude_and_frequency(bench: Path) -> None:
    file = write_system(bench, laws={"clamp1": 'fmu = "soft.fmu"\ntrack = true'}, stop=1.5, amplitude_mm=0.1)
    result = run_system(file)
    assert result.columns["clamp1.A_used"][-1] == pytest.approx(result.amplitude("clamp1.s", 0.15), rel=0.1)
    assert result.columns["clamp1.f_used"][-1] == pytest.approx(9.0, rel=0.05)


def test_a_law_used_beyond_its_data_is_said(bench: Path) -> None:
    result = run_system(write_system(bench, temperature_C=600.0, stop=0.1))
    assert result.out_of_range == ("clamp1",)
    assert any("clamp1" in warning and "range" in warning for warning in result.warnings)


def test_a_pipe_and_a_law_are_built_where_they_are_not_finished(bench: Path) -> None:
    file = write_system(bench, laws={"clamp1": 'law = "smooth.json"'})
    finished = run_system(write_system(bench))
    file = write_system(bench, laws={"clamp1": 'law = "smooth.json"'})
    file.write_text(
        file.read_text(encoding="utf-8").replace('fmu = "pipe.fmu"', 'file = "pipe.toml"'), encoding="utf-8"
    )
    built = run_system(file)
    assert np.array_equal(built.columns["clamp1.s"], finished.columns["clamp1.s"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('at = "clamp1"', 'at = "clmp1"'), ["clamps[1].at", "'clmp1'", "did you mean 'clamp1'"]),
        (('"pipe.fmu"', '"smooth.fmu"'), ["smooth.fmu", "isn't a pipe FMU", "flange.s"]),
        (('"smooth.fmu"', '"pipe.fmu"'), ["pipe.fmu", "'flange.s'", "clamp1.f"]),
        (('"smooth.fmu"', '"pipe.toml"'), ["pipe.toml", "not a whole zip archive"]),
        (('"smooth.fmu"', '"none.fmu"'), ["none.fmu", "no such file; expected an FMU"]),
        (("acceleration_m_s2", "force_N"), ["excited by base", "acceleration_m_s2"]),
    ],
)
def test_what_cannot_be_coupled_is_refused(bench: Path, change: tuple[str, str], words: list[str]) -> None:
    file = write_system(bench)
    file.write_text(file.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises(UserError) as refused:
        run_system(file)
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_force_that_is_off_for_its_motion_is_said_once_in_the_result_s_words(
    bench: Path, write_law: Callable[..., None]
) -> None:
    """And not again in the FMU's own."""
    write_law(bench / "falling.json", {**SMOOTH, "k1_A": -0.3}, "power", ())
    laws = {"clamp1": 'law = "falling.json"'}
    result = run_system(write_system(bench, laws=laws, amplitude_mm=0.2, stop=1.0))
    assert result.columns["clamp1.forceDeviation"][-1] > 0.05
    assert result.warnings == ()
    (said,) = re.findall(r"clamp1: .* its force is off by .*", summary_of(result))
    assert "so that its force is off by" in said
    assert "set amplitude_mm to that, or solve = true, or track = true" in said
    followed = run_system(write_system(bench, laws={"clamp1": laws["clamp1"] + "\ntrack = true"}, stop=1.0))
    assert "is off by" not in summary_of(followed)
