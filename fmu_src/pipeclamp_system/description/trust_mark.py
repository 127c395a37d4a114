"""The mark of a result that can't be used, by which what is said of it is known wherever it is shown."""

DOUBT = "NOT TO BE TRUSTED"
"""What such a line begins with; the reason, what was expected and the remedy follow."""


def doubt(what: str) -> str:
    """Give the line that marks a result: what is wrong, what was expected, what helps."""
    return f"{DOUBT}: {what}"


def is_doubt(line: str) -> bool:
    """Tell whether a line is such a mark."""
    return line.startswith(DOUBT)
