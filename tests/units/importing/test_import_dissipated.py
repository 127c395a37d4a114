"""Tables of what loops dissipate, and a rheometer's results beside its time: told, and turned to stiffness."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import quantity_of, turned
from pipeclamp_identification.importing.results.recognised import holds_results
from pipeclamp_identification.units.stated import unit_in_name
from pipeclamp_models.base.errors import UserError

AMPLITUDE = np.array([0.5, 1.0, 1.5, 2.0, 3.0])
STORAGE, LOSS = 900 * AMPLITUDE**-0.2, 120 * AMPLITUDE**-0.1


def written(path, header, columns, fmt="{:.6g}"):
    rows = [",".join(fmt.format(value) for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def read_back(folder):
    lines = (folder / "runs.csv").read_text().splitlines()
    names = lines[0].split(",")
    rows = [dict(zip(names, line.split(","), strict=True)) for line in lines[1:]]
    return np.array([[float(row["storage_stiffness_N_mm"]), float(row["loss_stiffness_N_mm"])] for row in rows]).T


@pytest.mark.parametrize(
    ("name", "plain", "unit"),
    [
        ("stiffness_kN_per_mm", "stiffness", "kN/mm"), ("speed mm per s", "speed", "mm/s"),
        ("omega_rad_per_s", "omega", "rad/s"), ("E_dissipated_J", "E_dissipated", "J"),
        ("cycles_per_min", "cycles_per", "min"), ("Load per cycle", "Load per cycle", ""),
    ],
)  # fmt: skip
def test_units_with_their_stroke_spelt_and_energies_are_read(name, plain, unit):
    assert unit_in_name(name) == (plain, unit)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("E_dissipated_J", "dissipated_energy"), ("dW [mJ]", "dissipated_energy"),
        ("Dissipated energy per cycle [J]", "dissipated_energy"), ("E_load_J", ""), ("Dissipated energy [%]", ""),
    ],
)  # fmt: skip
def test_the_energy_that_a_cycle_loses_is_told_from_others(name, quantity):
    assert quantity_of(Channel(name, "", np.arange(3.0))) == quantity


def test_radians_a_second_in_capitals_are_no_hertz():
    found = turned("frequency", "RAD/S", "OMEGA")
    assert found is not None and found.factor == pytest.approx(1 / (2 * np.pi))


@pytest.mark.parametrize("beside", ["dynamic", "storage", "force"])
def test_dissipated_energy_gives_the_loss_stiffness(tmp_path, beside):
    energy = np.pi * LOSS * AMPLITUDE**2 / 1e3
    whole = np.hypot(STORAGE, LOSS)
    stiff = {
        "dynamic": ("stiffness_kN_per_mm", whole / 1e3),
        "storage": ("storage_stiffness_N/mm", STORAGE),
        "force": ("Force amplitude [kN]", whole * AMPLITUDE / 1e3),
    }[beside]
    header = f"amplitude_mm,frequency_Hz,{stiff[0]},E_load_J,E_dissipated_J"
    written(tmp_path / "loops.csv", header, [AMPLITUDE, np.full(5, 0.1), stiff[1], 4 * energy, energy], "{:.9g}")
    pc.import_files(tmp_path / "loops.csv", tmp_path / "c")
    np.testing.assert_allclose(read_back(tmp_path / "c"), [STORAGE, LOSS], rtol=1e-5)


@pytest.mark.parametrize(
    ("names", "stiff", "share"),
    [
        ("K [N/mm],C [Ns/mm]", STORAGE, 1.0),
        ("Storage stiffness [N/mm],Damping coefficient (N·s/m)", STORAGE, 1e3),
        ("Stiffness [kN/mm],c_kns_per_m", STORAGE / 1e3, 1.0),
        ("Dynamic stiffness [N/mm],Damping [N s/mm]", np.hypot(STORAGE, LOSS), 1.0),
        ("K* [N/mm],Ceq [lb-s/in]", np.hypot(STORAGE, LOSS), 1 / 0.1751268352465),
    ],
)  # fmt: skip
def test_a_damping_coefficient_is_the_loss_stiffness_over_the_angular_frequency(tmp_path, names, stiff, share):
    """Isolators' K and C had been refused: what a test lost had to be an angle, a factor or an energy."""
    coefficient = LOSS / (2 * np.pi * 4.0)
    columns = [AMPLITUDE, np.full(5, 4.0), stiff, share * coefficient]
    written(tmp_path / "kc.csv", f"Amplitude [mm],Frequency [Hz],{names}", columns, "{:.9g}")
    found = pc.import_files(tmp_path / "kc.csv", tmp_path / "c")
    np.testing.assert_allclose(read_back(tmp_path / "c"), [STORAGE, LOSS], rtol=1e-5)
    assert ("taken for K in F = K x + C v" in str(found.notes)) == names.startswith("Stiffness")


def test_the_stiffness_beside_a_damping_coefficient_may_be_stated(tmp_path):
    whole, coefficient = np.hypot(STORAGE, LOSS), LOSS / (2 * np.pi * 4.0)
    written(tmp_path / "kc.csv", "Amplitude [mm],K [N/mm],C [Ns/mm]", [AMPLITUDE, whole, coefficient], "{:.9g}")
    (tmp_path / "set.csv").write_text("file,frequency_Hz\nkc.csv,4\n")
    columns = "dynamic_stiffness=K [N/mm]"
    pc.import_files(tmp_path / "kc.csv", tmp_path / "c", columns=columns, conditions=tmp_path / "set.csv")
    np.testing.assert_allclose(read_back(tmp_path / "c"), [STORAGE, LOSS], rtol=1e-5)


def test_a_loss_angle_beside_it_counts_before_it(tmp_path):
    whole, angle = np.hypot(STORAGE, LOSS), np.degrees(np.arctan2(LOSS, STORAGE))
    columns = [AMPLITUDE, np.full(5, 4.0), whole, angle, np.ones(5)]
    written(
        tmp_path / "kc.csv", "Amplitude [mm],Frequency [Hz],Stiffness [N/mm],Phase [deg],C [Ns/mm]", columns, "{:.9g}"
    )
    found = pc.import_files(tmp_path / "kc.csv", tmp_path / "c")
    np.testing.assert_allclose(read_back(tmp_path / "c"), [STORAGE, LOSS], rtol=1e-5)
    notes = " ".join(found.notes)
    assert "F = K x + C v" not in notes
    assert "not used: 'C [Ns/mm]'" in notes


def by_name(tmp_path):
    return {"pattern": "s_{amplitude_mm}"}


def by_conditions(tmp_path):
    written(tmp_path / "cond.csv", "amplitude_mm,file", [[2.0], ["s_2.csv"]], "{}")
    return {"conditions": tmp_path / "cond.csv"}


@pytest.mark.parametrize("known", [by_name, by_conditions])
@pytest.mark.parametrize("beside", ["energy", "force", "both"])
def test_the_amplitude_that_is_stated_of_a_file_turns_its_energies_and_forces(tmp_path, known, beside):
    """A sheet a level is how sweeps of the frequency are kept; a column of the amplitude had been asked for."""
    storage, loss = STORAGE, LOSS
    whole = np.hypot(storage, loss)
    columns = {
        "energy": ("stiffness [N/mm],Dissipated energy [J]", [whole, np.pi * loss * 4.0 / 1e3]),
        "force": ("Force amplitude [N],Loss factor", [whole * 2.0, loss / storage]),
        # what is stated of a file goes before its columns, also where energies are turned by it
        "both": ("amplitude [mm],stiffness [N/mm],dW [J]", [np.full(5, 1.9), whole, np.pi * loss * 4.0 / 1e3]),
    }[beside]
    (tmp_path / "sheets").mkdir()
    frequencies = np.arange(1.0, 6.0)
    written(tmp_path / "sheets" / "s_2.csv", f"Frequency [Hz],{columns[0]}", [frequencies, *columns[1]], "{:.9g}")
    pc.import_files(tmp_path / "sheets", tmp_path / "c", **known(tmp_path))
    np.testing.assert_allclose(read_back(tmp_path / "c"), [storage, loss], rtol=1e-5)


def test_what_no_ellipse_loses_is_left_out_with_the_reason(tmp_path):
    energy = np.pi * LOSS * AMPLITUDE**2 / 1e3
    energy[2] *= 20
    columns = [AMPLITUDE, np.full(5, 0.1), np.hypot(STORAGE, LOSS), energy]
    written(tmp_path / "loops.csv", "amplitude_mm,frequency_Hz,stiffness_N_per_mm,E_dissipated_J", columns)
    found = pc.import_files(tmp_path / "loops.csv", tmp_path / "c")
    assert "1 of 5 rows left out, no ellipse of its stiffness and amplitude loses so much energy" in str(found.notes)
    assert read_back(tmp_path / "c").shape == (2, 4)


def test_a_sheet_of_results_is_never_taken_for_a_record(tmp_path):
    """Its stiffness in kN_per_mm had been proposed for the displacement, its energy in J for the force."""
    written(
        tmp_path / "sheet.csv",
        "loading_N,stiffness_kN_per_mm,E_load_J,E_dissipated_J,displacement_max_mm",
        [np.full(5, 2831.0), STORAGE / 1e3, AMPLITUDE, AMPLITUDE / 7, 2 * AMPLITUDE],
    )
    with pytest.raises(UserError, match="no column is the frequency in Hz"):
        pc.import_files(tmp_path / "sheet.csv", tmp_path / "c")
    (tmp_path / "set.csv").write_text("file,frequency_Hz\nsheet.csv,0.1\n")
    columns = "amplitude=displacement_max_mm [0.5 mm]"
    pc.import_files(tmp_path / "sheet.csv", tmp_path / "c", conditions=tmp_path / "set.csv", columns=columns)
    assert read_back(tmp_path / "c").shape == (2, 5)


def sweep(count=12):
    """A rheometer's sheet: results each 4 s of a slow sine, a gap in mm, normal force, and rows of another action."""
    names = ["Time (s)", "Normal force(N)", "Shear strain(%)", "Complex shear strain(%)", "Frequency(Hz)",
             "Shear modulus (elastic component)(Pa)", "Shear modulus (viscous component)(Pa)", "Angle(rad)",
             "Gap(mm)"]  # fmt: skip
    blank = np.full(count, np.nan)
    steady = [4.0 * np.arange(count), 0.2 + 0.001 * np.arange(count) % 3, blank, np.geomspace(0.1, 10, count),
              np.full(count, 0.033), np.geomspace(120, 20, count), np.full(count, 12.0), np.full(count, 0.003),
              np.full(count, 9.15)]  # fmt: skip
    before = [np.arange(-4.0, 0), np.full(4, 0.2), np.geomspace(1, 9, 4), *[np.full(4, np.nan)] * 4,
              np.geomspace(1, 9, 4), np.full(4, 9.15)]  # fmt: skip
    return names, [np.concatenate(both) for both in zip(before, steady, strict=True)]


def test_results_beside_a_time_are_no_record_though_their_sine_is_slow(tmp_path):
    names, columns = sweep()
    assert holds_results(RawTable("", tuple(Channel(n, "", v) for n, v in zip(names, columns, strict=True))))
    written(tmp_path / "r.csv", ",".join(names), columns)
    with pytest.raises(UserError) as told:
        pc.import_files(tmp_path / "r.csv", tmp_path / "c")
    # one option for all that the part's size tells, with the strain that the results are of
    option = shlex.split(re.search(r"--columns .*", str(told.value))[0])[1]
    assert option.startswith("amplitude=Complex shear strain(%) [0.02 mm],storage_stiffness=Shear modulus (elastic")
    pc.import_files(tmp_path / "r.csv", tmp_path / "c", columns=option)
    assert read_back(tmp_path / "c").shape == (2, 12)


def test_a_record_that_also_shows_its_moduli_stays_one():
    time = np.arange(400) / 100
    y = np.sin(2 * np.pi * time)
    held = {"time [s]": time, "displacement [mm]": y, "force [N]": 900 * y, "frequency [Hz]": np.ones(400),
            "storage stiffness [N/mm]": np.full(400, 900.0), "loss stiffness [N/mm]": np.full(400, 90.0)}  # fmt: skip
    assert not holds_results(RawTable("", tuple(Channel(name, "", values) for name, values in held.items())))


def test_the_parts_stiffness_is_asked_with_what_was_stated(tmp_path):
    names, columns = sweep()
    written(tmp_path / "r.csv", ",".join(names), columns)
    with pytest.raises(UserError, match="its moduli are the material's") as told:
        pc.import_files(tmp_path / "r.csv", tmp_path / "c", columns="amplitude=Complex shear strain(%) [0.09 mm]")
    option = shlex.split(re.search(r"--columns .*", str(told.value))[0])[1]
    assert option.startswith("amplitude=Complex shear strain(%) [0.09 mm],storage_stiffness=")
