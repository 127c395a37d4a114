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
LONGEST_PAGE, FEWEST_SECTIONS = "3_clamp_a.html", 11
FOREIGN = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
"""Variables by which another environment would show through."""


def done(*words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a program that sees nothing of the checkout; end with what it complained of where it fails."""
    clean = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    called = subprocess.run([str(word) for word in words], cwd=cwd, env=clean, capture_output=True, text=True)
    if called.returncode:
        sys.exit(f"{' '.join(map(str, words))}: status {called.returncode}\n{called.stdout}{called.stderr}")
    return called


def run(*words: str | Path, cwd: Path) -> str:
    """Do the same, and give what it printed."""
    return done(*words, cwd=cwd).stdout


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
    story = done(command, "demo", demo, cwd=elsewhere)
    print(story.stdout, end="")
    check_demo(demo, story.stdout, story.stderr)


def check_demo(demo: Path, told: str, warned: str) -> None:
    """Refuse a demo whose story, or a page of it, isn't whole; `told` and `warned` are what it printed."""
    faults = [f"the story lacks {words!r}" for words in TOLD if words not in told]
    pages = [line.removeprefix(OPEN).strip() for line in told.splitlines() if line.startswith(OPEN)]
    if len(pages) < FEWEST_PAGES or any(Path(page).stat().st_size < SMALLEST_PAGE for page in pages):
        faults.append(f"expected {FEWEST_PAGES} pages or more of {SMALLEST_PAGE} bytes; got {pages}")
    if told.splitlines()[-1] != LAST_LINE:
        faults.append(f"expected the last line {LAST_LINE!r}; got {told.splitlines()[-1]!r}")
    if UNTRUSTED in told + warned:
        faults.append(f"the story says {UNTRUSTED!r}")
    files = {path.name for path in demo.iterdir()}
    if {name for name in files if name.endswith(".fmu")} != FMUS or any(name.startswith(".") for name in files):
        faults.append(f"expected {sorted(FMUS)} and nothing half-written; got {sorted(files)}")
    for page in sorted(demo.glob("*.html")):
        text = page.read_text(encoding="utf-8")
        links = re.findall(r'<a href="#section-[0-9]+">([^<]*)</a>', text)
        if UNTRUSTED in text:
            faults.append(f"{page.name} says {UNTRUSTED!r}")
        if len(set(links)) < len(links) or (page.name == LONGEST_PAGE and len(links) < FEWEST_SECTIONS):
            faults.append(f"{page.name}: got links to the sections {links}; expected each once, and all of them")
        if not all(re.search(one, text) for one in ON_EVERY_PAGE):
            faults.append(f"{page.name}: expected when and how it was made, and a line to run next")
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
