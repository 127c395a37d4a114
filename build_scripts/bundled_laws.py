"""Make the bundled law files anew: `python build_scripts/bundled_laws.py`."""

from pathlib import Path

from pipeclamp.parameter_file import write_law
from pipeclamp_identification.identify import software
from pipeclamp_identification.published_tables import bundled_files

FOLDER = Path(__file__).parent.parent / "models" / "pipeclamp" / "data" / "laws"

if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for file in bundled_files(software()):
        write_law(file, FOLDER / f"{file.name}.json")
        print(FOLDER / f"{file.name}.json")
