"""Readers of files fuzzed by coverage: whatever the bytes, a reader takes them or says in a line what is wrong.

Run: pip install atheris; python build_scripts/fuzz/readers.py READER [-max_total_time=60] [CORPUS]

READER is one of those below; what stands behind it is libFuzzer's. A finding ends it, with the bytes in a file.
"""

import sys
import tempfile
import warnings
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["pipeclamp", "pipeclamp_models", "pipeclamp_fmu", "pipeclamp_identification"]):
    from pipeclamp_fmu.set_parameters import set_parameters
    from pipeclamp_identification.campaign.description import read_description
    from pipeclamp_identification.importing.conditions import read_conditions
    from pipeclamp_identification.importing.records.planner import plan_import
    from pipeclamp_identification.importing.stated import Options
    from pipeclamp_identification.workflow.reading import read_tests
    from pipeclamp_models.base.errors import UserError
    from pipeclamp_models.base.said import LONGEST_LINE
    from pipeclamp_models.law.bundled import open_law
    from pipeclamp_models.law.declaration_files import read_declaration
    from pipeclamp_models.law.file import read_law

FOLDER = Path(tempfile.mkdtemp())
RUNS = "run,file\na,a.csv\n"
# MATLAB's and MDF's files are read in processes of their own, a second each: tests/properties damages them
IMPORTED = {"import": "csv", "workbook": "xlsx", "hdf5": "h5", "parquet": "parquet", "tdms": "tdms", "unv": "unv"}
READERS = {
    **{name: (f"a.{ending}", lambda path: plan_import([path], Options(), FOLDER)) for name, ending in IMPORTED.items()},
    "conditions": ("set.csv", read_conditions),
    "campaign": ("campaign.toml", lambda path: read_description(path.parent)),
    "record": ("a.csv", lambda path: read_tests(path.parent)),
    "runs": ("runs.csv", lambda path: read_tests(path.parent)),
    "law": ("law.json", read_law),
    "declaration": ("effect.toml", read_declaration),
    "fmu": ("a.fmu", lambda path: set_parameters(path, open_law("emwm2"), path.with_name("out.fmu"))),
}


def main(name):
    """Fuzz a reader until time is over or something else than a UserError is raised."""
    file, read = READERS[name]
    (FOLDER / "campaign.toml").write_text('name = "a"\n', encoding="utf-8")
    (FOLDER / "runs.csv").write_text(RUNS, encoding="utf-8")
    (FOLDER / "a.csv").write_text("time_s,displacement_mm,force_N\n0,0,0\n", encoding="utf-8")
    warnings.simplefilter("ignore")

    def once(content):
        (FOLDER / file).write_bytes(content)
        try:
            read(FOLDER / file)
        except UserError as error:
            first = str(error).split("\n")[0]
            if not 0 < len(first) <= 2 * LONGEST_LINE:
                raise AssertionError(first) from error

    atheris.Setup([sys.argv[0], *sys.argv[2:]], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1])
