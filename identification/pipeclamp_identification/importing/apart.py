"""Reading in a process of its own: where a damaged file brings down a foreign library's C code, it ends that alone."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from pipeclamp_identification.importing.raw import Damaged, RawTable


def read_apart(reader: str, path: Path) -> Sequence[RawTable]:
    """Read a file's tables in a process of its own.

    Args:
        reader: name of a module whose `read` gives them.
        path: the file.

    Raises:
        Damaged: the process broke down.
        Exception: whatever `read` raised.
    """
    command = [sys.executable, "-m", __name__, reader, str(path)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    if not done.stdout:
        raise Damaged(
            f"is damaged: the library that reads it broke down (status {done.returncode}); export or copy it again"
        )
    outcome: Sequence[RawTable] | Exception = pickle.loads(done.stdout)
    if isinstance(outcome, Exception):
        raise outcome
    return outcome


def main() -> None:
    """Read the file that the command line names; write its tables, or what was raised, to standard output."""
    reader, path = sys.argv[1:]
    outcome: Sequence[RawTable] | Exception
    try:
        outcome = import_module(reader).read(Path(path))
    except Damaged as error:
        outcome = error
    except Exception as error:  # foreign readers raise anything, and not all of it can be pickled
        outcome = RuntimeError(str(error) or type(error).__name__)
    sys.stdout.buffer.write(pickle.dumps(outcome))


if __name__ == "__main__":
    main()
