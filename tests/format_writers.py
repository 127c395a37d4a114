"""A run written by each format's own library, in that format's usual units."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from exports import Loop


@dataclass(frozen=True)
class Writer:
    """How a format is written: the ending, what writes it, the modules that it takes, and the digits it keeps."""

    ending: str
    write: Callable[[Path, Loop], None]
    modules: tuple[str, ...] = ()
    relative: float = 1e-12


def channels(run: Loop) -> dict[str, np.ndarray]:
    return {"Zeit": run.time, "Weg": run.y, "Last": run.force / 1e3}


UNITS = {"Zeit": "s", "Weg": "mm", "Last": "kN"}


def write_xlsx(path: Path, run: Loop) -> None:
    import xlsxwriter

    with xlsxwriter.Workbook(str(path)) as book:
        book.add_worksheet("Protocol").write(0, 0, "Operator")
        _write_sheet(book.add_worksheet("Data"), run)


def write_sheets(path: Path, runs: Iterable[Loop]) -> None:
    """One workbook with a sheet for each run, which bears its name."""
    import xlsxwriter

    with xlsxwriter.Workbook(str(path)) as book:
        for run in runs:
            _write_sheet(book.add_worksheet(run.name), run)


def _write_sheet(sheet: Any, run: Loop) -> None:
    sheet.write_row(0, 0, ["Test machine 7"])
    sheet.write_row(2, 0, list(UNITS))
    sheet.write_row(3, 0, list(UNITS.values()))
    for column, values in enumerate(channels(run).values()):
        sheet.write_column(4, column, values.tolist())


def write_ods(path: Path, run: Loop) -> None:
    from odf.opendocument import OpenDocumentSpreadsheet
    from odf.table import Table, TableCell, TableRow
    from odf.text import P

    document = OpenDocumentSpreadsheet()
    table = Table(name="Data")
    heads = TableRow()
    for name, unit in UNITS.items():
        cell = TableCell(valuetype="string")
        cell.addElement(P(text=f"{name} [{unit}]"))
        heads.addElement(cell)
    table.addElement(heads)
    for values in zip(*channels(run).values(), strict=True):
        row = TableRow()
        for value in values:
            row.addElement(TableCell(valuetype="float", value=repr(float(value))))
        table.addElement(row)
    document.spreadsheet.addElement(table)
    document.save(str(path))


def write_mat(path: Path, run: Loop) -> None:
    from scipy.io import savemat

    held = {name: {"value": values, "unit": UNITS[name]} for name, values in channels(run).items()}
    savemat(path, {"test": held, "operator": "N. N."}, do_compression=True)


def write_mat_matrix(path: Path, run: Loop) -> None:
    from scipy.io import savemat

    names = np.array([f"{name} [{unit}]" for name, unit in UNITS.items()], dtype=object)
    savemat(path, {"data": np.column_stack(list(channels(run).values())), "names": names})


def write_mat73(path: Path, run: Loop) -> None:
    """As MATLAB does it: HDF5 behind a block of 512 bytes that names the version."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("test")
        for name, values in channels(run).items():
            data = group.create_dataset(f"{name}_{UNITS[name]}", data=values.reshape(1, -1))
            data.attrs["MATLAB_class"] = np.bytes_("double")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan 01 00:00:00 2024 HDF5 schema 1.00 ."
    with path.open("r+b") as stream:
        stream.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


def write_tdms(path: Path, run: Loop) -> None:
    from nptdms import ChannelObject, TdmsWriter

    step = {"wf_increment": float(run.time[1]), "wf_start_offset": 0.0}
    with TdmsWriter(str(path)) as writer:
        writer.write_segment(
            [
                ChannelObject("Measurement", name, values, properties={"unit_string": UNITS[name], **step})
                for name, values in channels(run).items()
                if name != "Zeit"
            ]
        )


def write_uff(path: Path, run: Loop, binary: int = 0) -> None:
    import pyuff

    file = pyuff.UFF(str(path))
    for name, values in channels(run).items():
        if name != "Zeit":
            held = {
                "type": 58, "binary": binary, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_dir": 1, "ref_node": 1,
                "data": values, "x": run.time, "id1": name, "abscissa_spacing": 1, "ord_data_type": 4,
                "abscissa_axis_units_lab": "s", "ordinate_axis_units_lab": UNITS[name], "ordinate_axis_lab": name,
                "orddenom_spec_data_type": 0,
            }  # fmt: skip
            file.write_sets(held, "add")


def write_uff_binary(path: Path, run: Loop) -> None:
    write_uff(path, run, binary=1)


def write_mdf(path: Path, run: Loop) -> None:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append(
            [
                Signal(values, run.time, name=name, unit=UNITS[name])
                for name, values in channels(run).items()
                if name != "Zeit"
            ]
        )
        file.save(path, overwrite=True, compression=1)


def write_hdf5(path: Path, run: Loop) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in channels(run).items():
            file.create_dataset(f"test/{name}", data=values, compression="gzip").attrs["unit"] = UNITS[name]


def write_parquet(path: Path, run: Loop) -> None:
    import polars as pl

    pl.DataFrame({f"{name}/{UNITS[name]}": values for name, values in channels(run).items()}).write_parquet(path)


WRITERS = {
    "Excel": Writer(".xlsx", write_xlsx, ("xlsxwriter", "python_calamine")),
    "OpenDocument": Writer(".ods", write_ods, ("odf", "python_calamine")),
    "MATLAB 5": Writer(".mat", write_mat, ("pymatreader",)),
    "MATLAB 5, a matrix": Writer(".mat", write_mat_matrix, ("pymatreader",)),
    "MATLAB 7.3": Writer(".mat", write_mat73, ("pymatreader", "h5py")),
    "TDMS": Writer(".tdms", write_tdms, ("nptdms",)),
    "UFF 58": Writer(".uff", write_uff, ("pyuff",), 1e-10),
    "UFF 58b": Writer(".uff", write_uff_binary, ("pyuff",)),
    "MDF4": Writer(".mf4", write_mdf, ("asammdf",)),
    "HDF5": Writer(".h5", write_hdf5, ("h5py",)),
    "Parquet": Writer(".parquet", write_parquet),
}
