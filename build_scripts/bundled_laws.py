"""Make the bundled law files anew: `python build_scripts/bundled_laws.py`."""

from pathlib import Path

from pipeclamp_identification.fitting.identify import software
from pipeclamp_identification.metrics_only.published import bundled_files
from pipeclamp_models.law.file import write_law

FOLDER = Path(__file__).parent.parent / "models" / "pipeclamp_models" / "data" / "laws"

if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for file in bundled_files(software()):
        write_law(file, FOLDER / f"{file.name}.json")
        print(FOLDER / f"{file.name}.json")
