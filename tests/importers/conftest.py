"""What tests of FMUs share: models, built FMUs, and a driver that goes by variable names.

No test here gives fmpy's `simulate_fmu` a `logger`: fmpy keeps the last one for the whole process, after it has been
freed, and an FMU of FMI 2.0 that is then run without one can crash at its first message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import pytest
import stand_in as stand_in_numbers
from fmpy.fmi1 import FMICallException

from pipeclamp_fmu.build import build_clamp, build_native_clamp, build_native_pipe, build_pipe
from pipeclamp_fmu.contents.clamp import clamp_content
from pipeclamp_fmu.contents.clamp_model import ClampModel, Entry
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_fmu.python.packing import write_fmu
from pipeclamp_fmu.slaves.one_module import body_of, source_text
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import CoefficientEntry, Interval, LawFile
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.fmus.participant import LoadedFmu, opened

PIPE = """
name = "bench"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 6.0
material = "316L"
fluid = "water"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 2.0
[[clamps]]
name = "clamp2"
position_m = 5.0
[[probes]]
name = "middle"
position_m = 3.0
{tables}
[damping]
ratio = 0.01
[modes]
up_to_Hz = 100
"""

PIPES = {
    "pipe": "",
    "forced_pipe": '[excitation]\nkind = "force"\nposition_m = 1.0',
    "loaded_pipe": "[flow]\nvelocity_m_s = 8.0\npressure_bar = 20.0\n[axial]\ntension_N = 4000.0",
}
"""Test pipes: shaken by the base, shaken by a force, and with axial force and flow."""


class Driver:
    """One instance of an FMU, by variable names."""

    def __init__(self, fmu: LoadedFmu, start: dict[str, float]) -> None:
        self.fmu, self.slave, self.messages = fmu, fmu.slave, fmu.messages
        self.time = 0.0
        self.start(start)

    def start(self, values: dict[str, float]) -> None:
        self.slave.setupExperiment(startTime=0.0)
        self.set(values)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = 0.0

    def set(self, values: dict[str, float]) -> None:
        self.fmu.set_parameters(values)

    def get(self, name: str) -> float:
        variable = self.fmu.variables[name]
        read = self.slave.getBoolean if variable.kind == "Boolean" else self.slave.getReal
        return read([variable.reference])[0]

    def all(self) -> dict[str, float]:
        return {name: self.get(name) for name, variable in self.fmu.variables.items() if variable.causality == "output"}

    def step(self, h: float, **inputs: float) -> None:
        self.set({name.replace("__", "."): value for name, value in inputs.items()})
        self.slave.doStep(self.time, h)
        self.time += h

    def discarded(self, h: float, **inputs: float) -> str:
        """Try a step that must be discarded, and give what the FMU says of it."""
        before = len(self.messages.errors)
        with pytest.raises(FMICallException) as refused:
            self.step(h, **inputs)
        assert refused.value.status == 2, "expected fmi2Discard"
        assert len(self.messages.errors) == before + 1
        return self.messages.errors[-1]

    def save(self) -> Any:
        return self.slave.getFMUstate()

    def restore(self, state: Any) -> None:
        self.slave.setFMUstate(state)

    def serialised(self) -> bytes:
        return bytes(self.slave.serializeFMUstate(self.save()))

    def deserialise(self, data: bytes) -> None:
        self.restore(self.slave.deSerializeFMUstate(data))


def shake(clamp: Driver, begin: int, end: int, h: float = 1e-3, A: float = 5e-4, f: float = 3.0) -> list[float]:
    """Step a clamp along a sinusoid with some of the third harmonic and give the forces."""
    forces = []
    for n in range(begin, end):
        theta = 2 * pi * f * h * (n + 1)
        clamp.step(
            h,
            flange__s=A * (sin(theta) + 0.3 * sin(3 * theta)),
            flange__v=A * 2 * pi * f * (cos(theta) + 0.9 * cos(3 * theta)),
        )
        forces.append(clamp.get("flange.f"))
    return forces


@pytest.fixture(scope="session")
def stand_in() -> ClampModel:
    """Give the stand-in law, which has a memory, as a clamp."""
    source = body_of(source_text("pipeclamp_fmu.slaves.stand_in_law"))
    return ClampModel(
        "stand-in",
        "from collections.abc import Sequence\n" + source[source.index("STATES") :],
        tuple(Entry(name, "", name, value) for name, value in stand_in_numbers.VALUES.items()),
        *stand_in_numbers.RANGES,
        ("F = k1*y < anything & more",),
        (("k1", "1200", "3", "N/mm", "stiffness"),),
    )


def law_file(
    name: str, base: str, effects: tuple[str, ...], values: dict[str, float], smoothing: tuple[float, float]
) -> LawFile:
    """Give a law as a parameter file, over the stand-in law's range."""
    coefficients = {key: CoefficientEntry(value=value, unit="", state="given") for key, value in values.items()}
    return open_law("emwm2").model_copy(
        update={
            "name": name,
            "base": base,
            "effects": effects,
            "smoothing": dict(zip(("v_r", "y_r"), smoothing, strict=True)),
            "coefficients": coefficients,
            "range": {
                "A": Interval(minimum=0.2, maximum=1.0, unit="mm"),
                "f": Interval(minimum=1.0, maximum=5.0, unit="Hz"),
                "T": Interval(minimum=293.15, maximum=573.15, unit="K"),
            },
        }
    )


@pytest.fixture(scope="session")
def law_with_memory() -> LawFile:
    """Give a law like the stand-in, as a parameter file."""
    values = {"k10": 1200.0, "k1_A": -0.2, "k1_T": 0.0, "k30": 150.0, "k3_A": 0.0, "k3_T": 0.0, "k_s": 500.0}
    values |= {"c0": 180.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.47, "alpha_A": 0.0, "alpha_f": 0.012, "z_s": 60.0}
    values |= {"c_T1": -0.1, "c_T2": 0.02, "c_T3": 0.0}
    return law_file("stand-in", "power", ("memory", "damping_temperature"), values, (0.0126, 0.002))


@pytest.fixture(scope="session")
def law_with_further_conditions(law_with_memory: LawFile) -> LawFile:
    """Give a law that follows density, a further column of the test table, and load cycles."""
    further = {"k_rho": 4.0, "c_rho": 2.0, "l_N": -0.2, "N_l": 8.0, "z_u_current_A1": 0.4, "z_u_current_A2": 0.0}
    further |= {"k_u_current_A1": 0.1, "k_u_current_A2": 0.0, "c_u_current_A1": 0.5, "c_u_current_A2": -0.05}
    further |= {"F_u_current_A1": 0.0}
    given = {name: CoefficientEntry(value=value, unit="", state="given") for name, value in further.items()}
    ranges = {"rho": (2.0, 2.6, "g/cm3"), "current_A": (-1.0, 2.0, "in its name"), "N": (0.5, 200.0, "cycles")}
    return law_with_memory.model_copy(
        update={
            "name": "further",
            "effects": (*law_with_memory.effects, "density", "condition:current_A", "loosening"),
            "coefficients": {**law_with_memory.coefficients, **given},
            "range": {
                **law_with_memory.range,
                **{name: Interval(minimum=low, maximum=high, unit=unit) for name, (low, high, unit) in ranges.items()},
            },
        }
    )


@pytest.fixture(scope="session")
def native_fmus(tmp_path_factory: pytest.TempPathFactory, law_with_memory: LawFile) -> dict[int, Path]:
    """Give native FMUs of the law with memory by version of FMI."""
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    folder = tmp_path_factory.mktemp("native")
    paths = {fmi: folder / f"fmi{fmi}.fmu" for fmi in (2, 3)}
    for fmi, path in paths.items():
        build_native_clamp(law_with_memory, path, fmi)
    return paths


@pytest.fixture(scope="session")
def native_pipes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Give the native FMUs of the test pipes by name."""
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    folder = tmp_path_factory.mktemp("native_pipes")
    paths = {name: folder / f"{name}.fmu" for name in PIPES}
    for name, path in paths.items():
        build_native_pipe(reduce(parse_pipe(PIPE.format(tables=PIPES[name]))), path)
    return paths


@pytest.fixture(scope="session")
def reduced_pipe() -> ReducedPipe:
    """Give the test pipe in modes."""
    return reduce(parse_pipe(PIPE.format(tables=PIPES["pipe"])))


@pytest.fixture(scope="session")
def fmus(
    tmp_path_factory: pytest.TempPathFactory, stand_in: ClampModel, law_with_further_conditions: LawFile
) -> dict[str, Path]:
    """Give built FMUs by name."""
    folder = tmp_path_factory.mktemp("fmus")
    paths = {name: folder / f"{name}.fmu" for name in ("memory", "stiffer", "emwm2", "further", *PIPES)}
    write_fmu(clamp_content(stand_in, "0"), paths["memory"])
    stiffer = replace(stand_in, source=stand_in.source.replace("(k10 *", "(2.0 * k10 *"))
    write_fmu(clamp_content(stiffer, "0"), paths["stiffer"])
    build_clamp(open_law("emwm2"), paths["emwm2"])
    build_clamp(law_with_further_conditions, paths["further"])
    for name, tables in PIPES.items():
        build_pipe(reduce(parse_pipe(PIPE.format(tables=tables))), paths[name])
    return paths


@pytest.fixture
def drive(fmus: dict[str, Path]) -> Iterator[Callable[..., Driver]]:
    """Give a function that makes an initialised instance of one of the FMUs, or of the FMU at a path."""
    with ExitStack() as stack:

        def make(which: str | Path, start: dict[str, float] | None = None) -> Driver:
            path = which if isinstance(which, Path) else fmus[which]
            (fmu,) = stack.enter_context(opened([(path, path.stem)]))
            return Driver(fmu, start or {})

        yield make


@pytest.fixture(scope="session")
def shaken() -> Callable[..., list[float]]:
    """Give the function that steps a clamp along a motion and gives its forces."""
    return shake


@pytest.fixture(scope="session")
def pipe_text() -> Callable[..., str]:
    """Give a function that gives the TOML of one of the test pipes."""
    return lambda name="pipe": PIPE.format(tables=PIPES[name])
