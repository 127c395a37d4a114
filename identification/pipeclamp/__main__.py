"""`pipeclamp`, which is also `python -m pipeclamp`.

The command line is imported inside, so that an interrupt has its one message while that still loads.
"""

import atexit
import gc
import signal
import sys
from types import FrameType

INTERRUPTED = 130
"""Exit status after Ctrl-C, as of a shell."""
TERMINATED = 143
"""Exit status after SIGTERM, as of a shell."""
OBJECTS_BETWEEN_SEARCHES = 200_000
"""Python looks for unreachable cycles of objects after so many new ones, more than `identify` of 240 runs makes: after
its usual 700, a command spends a twentieth of its time on looking through what its libraries load, in vain."""


def main() -> None:
    """Run the command line; an interrupt is one message on stderr and status 130, a termination one and 143."""
    gc.set_threshold(OBJECTS_BETWEEN_SEARCHES)
    # Before a process ends, Python looks for such cycles once more, among all that was ever loaded: a twelfth of what
    # `identify` takes. What is frozen is left out of the search; the process gives it back as a whole.
    atexit.register(gc.freeze)
    terminated: list[int] = []

    def terminate(number: int, frame: FrameType | None) -> None:
        # What Ctrl-C doesn't break in the middle, this doesn't either; who ignores Ctrl-C is still ended by this.
        terminated.append(number)
        if callable(signal.getsignal(signal.SIGINT)):
            signal.raise_signal(signal.SIGINT)
        else:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, terminate)
    try:
        from pipeclamp.cli import app as cli

        cli.main()
    except KeyboardInterrupt as interrupt:
        how, status = ("terminated", TERMINATED) if terminated else ("interrupted", INTERRUPTED)
        sys.stderr.write(f"pipeclamp: {how}: {str(interrupt) or 'the same command begins anew'}\n")
        sys.exit(status)
    finally:
        signal.signal(signal.SIGTERM, before)


if __name__ == "__main__":
    main()
