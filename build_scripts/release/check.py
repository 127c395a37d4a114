"""Whether a release works: archives are built, and the wheel runs the demo away from the checkout, which tells a story.

Run: python build_scripts/release/check.py [FOLDER for the demo's results]

The source archive and, from it, the wheel are left in dist/.
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
DIST = ROOT / "dist"
IN_SOURCE = (
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
    "pyproject.toml",
    "docs/index.md",
    "tests/conftest.py",
)
"""What a source archive must hold besides the packages."""
TOLD = ("as printed", "rests on one row", "tests never seen", "300 °C")
"""What the demo's story tells."""
OPEN, LAST_LINE = "  open ", "Next: pipeclamp identify clamp_a -o law.json"
UNTRUSTED = "NOT TO BE TRUSTED"
ON_EVERY_PAGE = (r"Made on \S+ by pipeclamp \S+: pipeclamp (demo|cosim)", r"<code[^>]*>pipeclamp ")
FMUS = {"clamp_a.fmu", "pipe.fmu"}
FEWEST_PAGES, SMALLEST_PAGE = 5, 10_000
FOREIGN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
"""Variables by which another environment would show through."""


def run(*words: str | Path, cwd: Path) -> str:
    """Run a program that sees nothing of the checkout; give what it printed, or end with what it complained of."""
    clean = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    done = subprocess.run([str(word) for word in words], cwd=cwd, env=clean, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def new_environment(folder: Path) -> Path:
    """Make an environment with nothing in it but pip; give its Python."""
    venv.create(folder, with_pip=True)
    return folder / ("Scripts" if os.name == "nt" else "bin") / ("python.exe" if os.name == "nt" else "python")


def build(work: Path) -> tuple[Path, Path]:
    """Build the source archive, and the wheel from it; give both."""
    shutil.rmtree(DIST, ignore_errors=True)
    python = new_environment(work / "builder")
    run(python, "-m", "pip", "install", "-q", "build", cwd=work)
    run(python, "-m", "build", "--outdir", DIST, ROOT, cwd=work)
    return next(DIST.glob("*.tar.gz")), next(DIST.glob("*.whl"))


def check_archives(source: Path, wheel: Path) -> None:
    """Refuse archives that lack a file."""
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]["targets"]
    with tarfile.open(source) as archive:
        held = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    with zipfile.ZipFile(wheel) as archive:
        installed = set(archive.namelist())
    listed = run("git", "ls-files", "--cached", "--others", "--exclude-standard", cwd=ROOT).splitlines()
    tracked = [name for name in listed if (ROOT / name).is_file()]
    missing = [name for name in IN_SOURCE if name not in held]
    for folder in packages["wheel"]["packages"]:
        inside = [name for name in tracked if name.startswith(f"{folder}/")]
        missing += [f"{name} (source)" for name in inside if name not in held]
        missing += [f"{name} (wheel)" for name in inside if name[len(folder.rsplit("/", 1)[0]) + 1 :] not in installed]
    if missing:
        sys.exit(f"the archives lack {len(missing)} files: {', '.join(missing[:10])}")
    print(f"{source.name}: {len(held)} files; {wheel.name}: {len(installed)} files")


def check_installed(wheel: Path, work: Path, demo: Path) -> None:
    """Install the wheel alone, and run the demo away from the checkout."""
    python = new_environment(work / "user")
    elsewhere = work / "elsewhere"
    elsewhere.mkdir()
    run(python, "-m", "pip", "install", "-q", wheel, cwd=elsewhere)
    place = run(python, "-c", "import pipeclamp; print(pipeclamp.__file__)", cwd=elsewhere).strip()
    if Path(place).is_relative_to(ROOT):
        sys.exit(f"pipeclamp is read from the checkout: {place}")
    command = python.with_name("pipeclamp.exe" if os.name == "nt" else "pipeclamp")
    print(run(command, "--version", cwd=elsewhere).strip())
    run(python, "-m", "pip", "check", cwd=elsewhere)
    told = run(command, "demo", demo, cwd=elsewhere)
    print(told, end="")
    check_demo(demo, told)


def check_demo(demo: Path, told: str) -> None:
    """Refuse a demo whose story, or a page of it, isn't whole; `told` is what it printed."""
    faults = [f"the story lacks {words!r}" for words in TOLD if words not in told]
    pages = [line.removeprefix(OPEN).strip() for line in told.splitlines() if line.startswith(OPEN)]
    if len(pages) < FEWEST_PAGES or any(Path(page).stat().st_size < SMALLEST_PAGE for page in pages):
        faults.append(f"expected {FEWEST_PAGES} pages or more of {SMALLEST_PAGE} bytes; got {pages}")
    if told.splitlines()[-1] != LAST_LINE:
        faults.append(f"expected the last line {LAST_LINE!r}; got {told.splitlines()[-1]!r}")
    files = {path.name for path in demo.iterdir()}
    if not files >= FMUS or any(name.startswith(".") for name in files):
        faults.append(f"expected {sorted(FMUS)} and nothing half-written; got {sorted(files)}")
    for page in sorted(demo.glob("*.html")):
        text = page.read_text(encoding="utf-8")
        links = re.findall(r'<a href="#section-[0-9]+">([^<]*)</a>', text)
        if (
            UNTRUSTED in text
            or len(set(links)) < len(links)
            or not all(re.search(one, text) for one in ON_EVERY_PAGE)
        ):  # fmt: skip
            faults.append(
                f"{page.name}: it says {UNTRUSTED!r}, names a section twice, or lacks when and how it was made"
            )
    for name in ("system.csv", "system_hot.csv"):
        with (demo / name).open(encoding="utf-8", newline="") as table:
            if {float(row["trusted [1 yes, 0 no]"]) for row in csv.DictReader(table)} != {1.0}:
                faults.append(f"{name}: not all of it is to be trusted")
    if faults:
        sys.exit("the demo: " + "; ".join(faults))


def main() -> None:
    """Build, look, install, run."""
    demo = Path(sys.argv[1] if len(sys.argv) > 1 else "pipeclamp_demo").resolve()
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary).resolve()
        source, wheel = build(work)
        check_archives(source, wheel)
        check_installed(wheel, work, demo)


if __name__ == "__main__":
    main()
