"""MATLAB's files, versions 4 to 7.3, by pymatreader (SciPy, and h5py for 7.3).

SciPy's C code reads some damaged files beyond their ends, so they are read in a process of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.apart import read_apart
from pipeclamp_identification.importing.nested import tables_of
from pipeclamp_identification.importing.raw import COMPRESSED, Format, RawTable, refuse_size

OWN = ("__header__", "__version__", "__globals__")


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each structure with channels, and of the variables beside them."""
    from pymatreader import read_mat

    _refuse_sizes(path)
    return tables_of({name: value for name, value in read_mat(str(path)).items() if name not in OWN})


def _refuse_sizes(path: Path) -> None:
    """Refuse variables that claim more than the file holds, before they are read."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(128)
    if b"MATLAB 7.3" in head:
        import h5py

        def refuse(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.shape:
                refuse_size(f"variable {name!r}", float(np.prod(item.shape, dtype=np.float64)), size, COMPRESSED)

        with h5py.File(path, "r") as file:
            file.visititems(refuse)
        return
    from scipy.io import whosmat

    for name, shape, _ in whosmat(str(path)):
        refuse_size(f"variable {name!r}", float(np.prod(shape, dtype=np.float64)), size, COMPRESSED)


FORMAT = Format(
    name="MATLAB",
    suffixes=(".mat",),
    begins=lambda head: head[:6] == b"MATLAB",
    read=lambda path: read_apart(__name__, path),
    module="pymatreader",
    package="pymatreader",
)
