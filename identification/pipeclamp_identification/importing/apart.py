"""Reading in a process of its own: where a damaged file brings down a foreign library's C code, it ends that alone."""

from __future__ import annotations

import atexit
import json
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from pipeclamp_identification.importing.raw import Damaged, RawTable

IDLE_S = 10.0
"""A process that is asked for nothing so long ends."""
SIZE_BYTES = 8
"""An answer begins with its size."""

Outcome = Sequence[RawTable] | Exception


class _Reader:
    """A process that reads one file after the other: to load a library takes many times what most files take."""

    def __init__(self) -> None:
        self.owner, self.fresh = os.getpid(), True
        command, pipe = [sys.executable, "-m", __name__], subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)

    def asked(self, reader: str, path: Path) -> Outcome | None:
        """Give what comes of a file; None where the process ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        asked = json.dumps([reader, str(path), str(Path.cwd())])
        try:
            self._process.stdin.write(f"{asked}\n".encode())
            self._process.stdin.flush()
        except OSError:
            return None
        size = int.from_bytes(self._process.stdout.read(SIZE_BYTES), "big")
        content = self._process.stdout.read(size)
        if not content or len(content) < size:
            return None
        self.fresh = False
        return pickle.loads(content)  # type: ignore[no-any-return]

    def ended(self) -> int:
        """End it; give its status."""
        for stream in (self._process.stdin, self._process.stdout):
            try:
                if stream is not None:
                    stream.close()
            except OSError:  # what was left to be written, to a process that is no more
                pass
        return self._process.wait()

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self.ended()


_WAITING: list[_Reader] = []
"""Processes that go on to the next file: as many as threads ever read at once."""


def read_apart(reader: str, path: Path) -> Sequence[RawTable]:
    """Read a file's tables in a process of its own, which goes on to the next file where this one is sound.

    Args:
        reader: name of a module whose `read` gives them.
        path: the file.

    Raises:
        Damaged: the process broke down, though it had read nothing before.
        Exception: whatever `read` raised.
    """
    while True:
        process = _waiting() or _Reader()
        begun_anew = process.fresh
        try:
            outcome = process.asked(reader, path)
        except BaseException:
            process.kill()  # what it answers later would be taken for the next file's
            raise
        if isinstance(outcome, Exception):
            process.ended()  # a damaged file may have left damage behind
            raise outcome
        if outcome is not None:
            _WAITING.append(process)
            return outcome
        status = process.ended()
        if begun_anew:
            raise Damaged(
                f"is damaged: the library that reads it broke down (status {status}); export or copy it again"
            )


def _waiting() -> _Reader | None:
    """Take a process that waits; a fork of this one has none."""
    while _WAITING:
        process = _WAITING.pop()
        if process.owner == os.getpid():
            return process
    return None


@atexit.register
def _end_waiting() -> None:
    """Leave no process behind."""
    while process := _waiting():
        process.ended()


def main() -> None:
    """Read files that standard input names, and write their tables, or what was raised, to standard output.

    It ends after a file that can't be read, where nobody asks any more, and where nobody does for long.
    """
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what a library prints is no answer
    outcome: Outcome = ()
    while not isinstance(outcome, Exception):
        idle = threading.Timer(IDLE_S, os._exit, (0,))
        idle.daemon = True
        idle.start()
        line = sys.stdin.buffer.readline()
        idle.cancel()
        if not line:
            return
        reader, path, folder = json.loads(line)
        os.chdir(folder)
        outcome = _read(reader, Path(path))
        content = pickle.dumps(outcome)
        answers.write(len(content).to_bytes(SIZE_BYTES, "big") + content)
        answers.flush()


def _read(reader: str, path: Path) -> Outcome:
    try:
        return import_module(reader).read(path)  # type: ignore[no-any-return]
    except Damaged as error:
        return error
    except Exception as error:  # foreign readers raise anything, and not all of it can be pickled
        return RuntimeError(str(error) or type(error).__name__)


if __name__ == "__main__":
    main()
