"""`pipeclamp`, which is also `python -m pipeclamp`.

The command line is imported inside, so that an interrupt has its one message while that still loads.
"""

import sys

INTERRUPTED = 130
"""Exit status after Ctrl-C, as of a shell."""


def main() -> None:
    """Run the command line; an interrupt is one message on stderr and status 130."""
    try:
        from pipeclamp.cli import app as cli

        cli.main()
    except KeyboardInterrupt as interrupt:
        sys.stderr.write(f"pipeclamp: interrupted: {str(interrupt) or 'the same command begins anew'}\n")
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
