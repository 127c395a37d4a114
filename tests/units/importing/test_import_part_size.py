"""Strains and moduli of tables of results become the part's amplitude and stiffness by its stated height and area."""

from __future__ import annotations

import numpy as np
import pytest

import pipeclamp as pc

STRAIN = np.geomspace(0.1, 20, 8)
STORAGE, LOSS = 2e6 * STRAIN**-0.1, 3e5 * STRAIN**-0.05
"""%, Pa."""
NAMES = "Oscillation strain [%],Frequency [Hz],Storage modulus [Pa],Loss modulus [Pa]"


def sweep(path, names=NAMES, frequency=2.0, **further):
    columns = [STRAIN, np.full(8, frequency), STORAGE, LOSS, *further.values()]
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([",".join([names, *further]), *rows]) + "\n")
    return path


def cells(folder):
    lines = (folder / "runs.csv").read_text().splitlines()
    names = lines[0].split(",")
    return names, [dict(zip(names, line.split(","), strict=True)) for line in lines[1:]]


def numbers(rows, name):
    return np.array([float(row[name]) for row in rows])


def test_each_file_has_a_part_of_its_own(tmp_path):
    (tmp_path / "in").mkdir()
    sizes = {"A": (2.0, 100.0), "B": (4.0, 50.0)}
    for name in sizes:
        sweep(tmp_path / "in" / f"{name}.csv", frequency=1.0 + len(list((tmp_path / "in").iterdir())))
    lines = [f"{name}.csv,{height:g},{area:g}" for name, (height, area) in sizes.items()]
    (tmp_path / "set.csv").write_text("\n".join(["file,size_mm,area_mm2", *lines]))
    pc.import_files(tmp_path / "in", tmp_path / "c", conditions=tmp_path / "set.csv")
    names, rows = cells(tmp_path / "c")
    # the size has done its work, and is no condition
    assert "size_mm" not in names and "area_mm2" not in names
    for place, (height, area) in enumerate(sizes.values()):
        own = rows[8 * place : 8 * place + 8]
        np.testing.assert_allclose(numbers(own, "amplitude_mm"), STRAIN / 100 * height, rtol=1e-5)
        np.testing.assert_allclose(numbers(own, "storage_stiffness_N_mm"), STORAGE / 1e6 * area / height, rtol=1e-5)
        np.testing.assert_allclose(numbers(own, "loss_stiffness_N_mm"), LOSS / 1e6 * area / height, rtol=1e-5)


def test_a_height_that_changes_from_row_to_row_is_a_column(tmp_path):
    gap = np.linspace(2.0, 1.6, 8)
    sweep(tmp_path / "a.csv", **{"Gap [mm]": gap})
    (tmp_path / "set.csv").write_text("file,area_mm2\na.csv,100\n")
    found = pc.import_files(
        tmp_path / "a.csv", tmp_path / "c", conditions=tmp_path / "set.csv", columns="size=Gap [mm]"
    )
    _, rows = cells(tmp_path / "c")
    np.testing.assert_allclose(numbers(rows, "amplitude_mm"), STRAIN / 100 * gap, rtol=1e-5)
    np.testing.assert_allclose(numbers(rows, "storage_stiffness_N_mm"), STORAGE / 1e6 * 100 / gap, rtol=1e-5)
    assert "not used" not in str(found.notes)


def test_names_of_files_may_state_it(tmp_path):
    sweep(tmp_path / "h3_a60.csv")
    pc.import_files(tmp_path / "h3_a60.csv", tmp_path / "c", pattern="h{size_mm}_a{area_mm2}")
    _, rows = cells(tmp_path / "c")
    np.testing.assert_allclose(numbers(rows, "loss_stiffness_N_mm"), LOSS / 1e6 * 20, rtol=1e-5)


def test_what_is_stated_counts_before_it(tmp_path):
    sweep(tmp_path / "a.csv")
    (tmp_path / "set.csv").write_text("file,size_mm,area_mm2\na.csv,2,100\n")
    columns = "amplitude=Oscillation strain [%] [0.05 mm]"
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", conditions=tmp_path / "set.csv", columns=columns)
    _, rows = cells(tmp_path / "c")
    np.testing.assert_allclose(numbers(rows, "amplitude_mm"), STRAIN * 0.05, rtol=1e-5)


@pytest.mark.parametrize(
    ("state", "lacks"), [("size_mm", "moduli are the material's"), ("area_mm2", "no column is the amplitude")]
)
def test_half_of_it_asks_for_the_rest(tmp_path, state, lacks):
    sweep(tmp_path / "a.csv")
    (tmp_path / "set.csv").write_text(f"file,{state}\na.csv,2\n")
    with pytest.raises(pc.UserError, match=lacks) as told:
        pc.import_files(tmp_path / "a.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    assert "--conditions TABLE.csv with the columns file,size_mm,area_mm2:" in str(told.value)


def test_several_specimens_are_told_with_the_way_to_a_law_of_each(tmp_path):
    sweep(tmp_path / "A.csv")
    (tmp_path / "set.csv").write_text("file,size_mm,area_mm2,specimen\nA.csv,2,100,A\nB.csv,2,100,B\n")
    one = pc.import_files(tmp_path / "A.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    assert "specimens" not in str(one.notes)
    both = pc.import_files(sweep(tmp_path / "B.csv", frequency=3.0), tmp_path / "c", conditions=tmp_path / "set.csv")
    assert "its tests are of 2 specimens, and one law is fitted to all of them" in str(both.notes)
    assert "identify" in str(both.notes) and "--per specimen" in str(both.notes)


@pytest.mark.parametrize(
    ("names", "modulus", "lost"),
    [
        ("temp_c,freq_hz,e_storage_mpa,tan_delta", STORAGE / 1e6, LOSS / STORAGE),
        ("Temperature [°C],Frequency [Hz],Complex modulus [MPa],Phase [deg]", np.hypot(STORAGE, LOSS) / 1e6,
         np.degrees(np.arctan2(LOSS, STORAGE))),
    ],
)  # fmt: skip
def test_a_modulus_beside_what_was_lost_takes_the_parts_size_too(tmp_path, names, modulus, lost):
    """A storage modulus with tan delta, as analysers export it, had been refused: no column says how stiff it was."""
    lines = [f"23,5,{one:.9g},{other:.9g}" for one, other in zip(modulus, lost, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join([names, *lines]))
    (tmp_path / "set.csv").write_text("file,amplitude_mm,size_mm,area_mm2\na.csv,0.1,2,100\n")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    _, rows = cells(tmp_path / "c")
    np.testing.assert_allclose(numbers(rows, "frequency_Hz"), 5.0)
    np.testing.assert_allclose(numbers(rows, "storage_stiffness_N_mm"), STORAGE / 1e6 * 50, rtol=1e-5)
    np.testing.assert_allclose(numbers(rows, "loss_stiffness_N_mm"), LOSS / 1e6 * 50, rtol=1e-5)
