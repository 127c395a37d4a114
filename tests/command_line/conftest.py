"""What the tests of the command line share: calling it as a user does, and a small campaign and its law."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from project import DATA, ROOT

import pipeclamp as pc
from pipeclamp.__main__ import main

ROOMS = [str(ROOT / room) for room in ("models", "fmu_src", "identification")]

LONGEST = 1800
"""A command that takes longer, s, is ended."""

Run = Callable[..., "subprocess.CompletedProcess[str]"]


def command(*words: str | Path) -> list[str]:
    return [sys.executable, "-m", "pipeclamp", *(str(word) for word in words)]


def environment(*modules: Path) -> dict[str, str]:
    """Give the environment of a command; folders of `modules` come before all others."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([*map(str, modules), *ROOMS]), "PYTHONIOENCODING": "utf-8"}


class Calls:
    """Runs commands, each in a process of its own: the first of each name from nothing, so that what a command fails to
    load is seen, further ones with all modules loaded, which saves most of a short one's time.

    Attributes:
        folder: its own.
        known: of all processes of tests, where the names of commands are kept that were run.
    """

    def __init__(self, folder: Path, known: Path) -> None:
        self.folder, self.known = folder, known
        known.mkdir(exist_ok=True)
        self.loaded: subprocess.Popen[str] | None = None

    def __call__(self, words: Sequence[str], cwd: Path) -> subprocess.CompletedProcess[str]:
        if sys.platform == "linux" and self._is_known(words[0] if words else "none"):  # elsewhere a fork isn't safe
            return self._forked(words, cwd)
        pipe, whole = subprocess.PIPE, command(*words)
        return subprocess.run(
            whole, cwd=cwd, env=environment(), stdout=pipe, stderr=pipe, encoding="utf-8", timeout=LONGEST, check=False
        )

    def _is_known(self, name: str) -> bool:
        """Tell whether a command of this name was run before, in any process of tests; from now on it was."""
        try:
            (self.known / name.replace("/", " ")).touch(exist_ok=False)
        except FileExistsError:
            return True
        return False

    def _forked(self, words: Sequence[str], cwd: Path) -> subprocess.CompletedProcess[str]:
        if self.loaded is None:
            program, pipe = [sys.executable, str(Path(__file__).with_name("loaded_program.py"))], subprocess.PIPE
            self.loaded = subprocess.Popen(program, env=environment(), stdin=pipe, stdout=pipe, encoding="utf-8")
        out, told = self.folder / "stdout", self.folder / "stderr"
        for path in (out, told):
            path.write_bytes(b"")
        asked = {"words": words, "cwd": str(cwd), "environment": environment(), "out": str(out), "told": str(told)}
        assert self.loaded.stdin and self.loaded.stdout
        print(json.dumps(asked | {"longest": LONGEST}), file=self.loaded.stdin, flush=True)
        status = int(self.loaded.stdout.readline())
        return subprocess.CompletedProcess(words, status, out.read_text("utf-8"), told.read_text("utf-8"))

    def end(self) -> None:
        if self.loaded:
            self.loaded.communicate()


@pytest.fixture(scope="session")
def pipeclamp(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    """Give a function that runs a command and holds its exit status; nothing may ever be a traceback."""
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    folder = tmp_path_factory.mktemp("calls")
    everybodys = tmp_path_factory.getbasetemp().parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    calls = Calls(folder, everybodys / "called")

    def run(*words: str | Path, status: int = 0, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        done = calls([str(word) for word in words], cwd or elsewhere)
        assert "Traceback" not in done.stderr, done.stderr
        assert done.returncode == status, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done

    yield run
    calls.end()


@pytest.fixture(scope="session")
def started() -> Callable[..., subprocess.Popen[str]]:
    """Give a function that starts a command, with `modules` instead of those that it would import, and its process."""

    def start(*words: str | Path, modules: Sequence[Path] = ()) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        return subprocess.Popen(command(*words), env=environment(*modules), stdout=pipe, stderr=pipe, encoding="utf-8")

    return start


@pytest.fixture
def refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Give a function that runs a command that can't serve and gives its one message; nothing may be on stdout.

    It calls the program's `main` in this process, which saves a second a call; whatever escapes it is an error.
    """

    def run(*words: str | Path, status: int = 1) -> str:
        monkeypatch.setattr(sys, "argv", ["pipeclamp", *(str(word) for word in words)])
        capsys.readouterr()
        with warnings.catch_warnings(record=True) as warned, pytest.raises(SystemExit) as ended:
            warnings.simplefilter("always")
            main()
        told = capsys.readouterr()
        assert ended.value.code == status, told.err
        assert not warned, warned[0].message
        message, *further = [line for line in told.err.splitlines() if not line.startswith("warning: ")]
        assert message.startswith("pipeclamp: ")
        assert all(line.startswith("  ") for line in further), told.err
        assert told.out == ""
        return "\n".join([message, *further])

    return run


@pytest.fixture(scope="session")
def clamp_a() -> Path:
    return DATA / "campaigns" / "clamp_a"


@pytest.fixture(scope="session")
def heldout(clamp_a: Path) -> Path:
    return clamp_a.with_name("clamp_a_heldout")


@pytest.fixture(scope="session")
def half(clamp_a: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half of clamp_a's runs: those at 1 and 5 Hz, but none at 100 °C."""
    folder = Path(shutil.copytree(clamp_a, tmp_path_factory.mktemp("half") / "half"))
    rows = (folder / "runs.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [row for row in rows if "_f3_" not in row and "_T100" not in row]
    assert len(kept) == 1 + 24
    (folder / "runs.csv").write_text("".join(kept), encoding="utf-8")
    return folder


@pytest.fixture(scope="session")
def law(pipeclamp: Run, clamp_a: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The base law of clamp_a."""
    path = tmp_path_factory.mktemp("law") / "law.json"
    pipeclamp("identify", clamp_a, "-o", path, "--reproducible")
    return path


@pytest.fixture(scope="session")
def small(pipeclamp: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small virtual campaign, 8 runs."""
    path = tmp_path_factory.mktemp("small") / "virtual"
    plan = ("--amplitudes", "0.3,0.9", "--frequencies", "1,4", "--temperatures", "20,250", "--rate", "300")
    pipeclamp("rig", "emwm2", "-o", path, *plan)
    return path


@pytest.fixture(scope="session")
def tests(small: Path) -> pc.Tests:
    """That campaign, as Python reads it."""
    return pc.read_campaign(small)
