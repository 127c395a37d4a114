"""Measurements on a pipe are read as they were written, whatever form they have; mistakes are named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_identification.on_pipe.measurement import PipeMeasurement, read_measurement
from pipeclamp_models.base.errors import UserError

PROBE = '[[probes]]\nname = "tip"\nposition_m = 2.0\nunit = "{unit}"\n'
RESPONSE = '[[responses]]\nfile = "sines.csv"\n'
HEAD = "frequency_Hz,acceleration_m_s2,tip_amplitude,tip_phase_deg\n"


@pytest.fixture
def folder(tmp_path: Path) -> Callable[..., Path]:
    def write(
        table: str = HEAD + "2,0.5,3,90\n4,0.5,1,-30\n", description: str | None = None, unit: str = "mm"
    ) -> Path:
        text = PROBE.format(unit=unit) + RESPONSE if description is None else description
        (tmp_path / "measurement.toml").write_text(text, encoding="utf-8")
        (tmp_path / "sines.csv").write_text(table, encoding="utf-8")
        return tmp_path

    return write


def response(measurement: PipeMeasurement) -> np.ndarray:
    return measurement.steady.response[:, 0]


def test_amplitude_and_phase_are_a_ratio_in_si(folder):
    found = read_measurement(folder())
    assert response(found) == pytest.approx([6e-3j, 2e-3 * np.exp(-1j * np.pi / 6)])
    assert found.steady.drive == pytest.approx([0.5, 0.5])
    assert found.steady.phased.all()
    assert np.isnan(found.steady.temperature).all()


def test_real_and_imaginary_parts_a_ratio_and_a_file_serve_too(folder):
    table = "frequency_Hz,acceleration_m_s2,tip_real,tip_imag\n2,0.5,0,6\n4,0.5,1.7320508,-1\n"
    where = folder(table, PROBE.format(unit="mm") + RESPONSE + "ratio = true\n")
    assert response(read_measurement(where / "measurement.toml")) == pytest.approx(response(read_measurement(folder())))


@pytest.mark.parametrize(("unit", "size"), [("um", 1e-6), ("mm/s", 1e-3), ("g", 9.80665), ("m/s2", 1.0)])
def test_units(folder, unit, size):
    assert abs(response(read_measurement(folder(unit=unit)))[0]) == pytest.approx(6 * size)


def test_a_base_displacement_is_an_acceleration_the_other_way(folder):
    table = "frequency_Hz,displacement_mm,tip_amplitude,tip_phase_deg\n2,1,3,0\n"
    found = read_measurement(folder(table))
    squared = (2 * np.pi * 2) ** 2
    assert found.steady.drive == pytest.approx([1e-3 * squared])
    assert response(found) == pytest.approx([-3 / squared])


def test_amplitudes_alone_have_no_phase_and_blanks_are_not_measured(folder):
    found = read_measurement(folder("frequency_Hz,acceleration_m_s2,tip_amplitude\n2,0.5,3\n4,0.5,\n"))
    assert not found.steady.phased.any()
    assert response(found)[0] == pytest.approx(6e-3)
    assert np.isnan(response(found)[1])


def test_a_record_of_a_sine_gives_its_fundamental_and_its_scatter(folder):
    time = np.arange(4000) / 400
    phase = 2 * np.pi * 3.1 * time + 0.4
    rng = np.random.default_rng(1)
    tip = 2 * np.sin(phase - 0.7) + 0.3 * np.sin(3 * phase) + 0.05 * rng.standard_normal(time.size)
    rows = "".join(f"{t:.5f},{0.5 * np.sin(p):.6f},{y:.6f}\n" for t, p, y in zip(time, phase, tip, strict=True))
    description = PROBE.format(unit="mm") + '[[sines]]\nfile = "sines.csv"\nfrom_s = 1.0\nsweep = "down"\n'
    found = read_measurement(folder("time_s,acceleration_m_s2,tip\n" + rows, description))
    assert found.steady.frequency == pytest.approx([3.1], rel=1e-4)
    assert found.steady.drive == pytest.approx([0.5], rel=1e-3)
    assert response(found) == pytest.approx([4e-3 * np.exp(-0.7j)], rel=5e-3)
    # noise of 0.05 mm over 28 cycles of 129 samples, twice by the excitation of 0.5
    assert found.steady.scatter[0, 0] == pytest.approx(1e-4 * np.sqrt(2 / 3600), rel=0.3)
    assert found.steady.sweep[0] == -1


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("frequency_Hz,acceleration_m_s2\n2,1\n", "no column for probe 'tip'"),
        ("frequency_Hz,tip_amplitude\n2,1\n", "expected one column of the excitation"),
        (HEAD, "no rows"),
        ((HEAD + "2,0.5,3,90\n").replace("\n", "\r"), "no rows"),
        (HEAD.replace("tip_phase_deg", "tip_amplitude") + "2,0.5,3,90\n", "column 'tip_amplitude' is there twice"),
        (HEAD + "2,0.5,3,90\n-4,0.5,1,0\n", "row 3, column 'frequency_Hz'"),
        (HEAD + "2,0,3,90\n", "row 2, column 'acceleration_m_s2'"),
        (HEAD + "2,0.5,-3,90\n", "row 2, column 'tip_amplitude'"),
        (HEAD + "2,0.5,3,90\n4,0.5,x,90\n", "row 3, column 'tip_amplitude': got 'x'"),
        (HEAD + "2,0.5,inf,90\n", "expected a finite number"),
        ("frequency,acceleration_m_s2,tip_amplitude\n2,1,1\n", "did you mean 'frequency'"),
    ],
)
def test_a_table_that_cant_serve_is_named(folder, table, said):
    with pytest.raises(UserError, match=r"sines\.csv") as refused:
        read_measurement(folder(table))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("description", "said"),
    [
        (RESPONSE, "probes"),
        (PROBE.format(unit="inch") + RESPONSE, "unit"),
        (PROBE.format(unit="mm"), "nothing was measured"),
        (PROBE.format(unit="mm") * 2 + RESPONSE, "is there twice"),
        (PROBE.format(unit="mm") + RESPONSE + 'swep = "up"\n', "did you mean 'sweep'"),
        (PROBE.format(unit="mm") + '[[sines]]\nfile = "sines.csv"\n', "time_s"),
        (PROBE.format(unit="mm") + '[[responses]]\nfile = "none.csv"\n', "none.csv"),
    ],
)
def test_a_description_that_cant_serve_is_named(folder, description, said):
    with pytest.raises(UserError) as refused:
        read_measurement(folder(description=description))
    assert said in str(refused.value)
