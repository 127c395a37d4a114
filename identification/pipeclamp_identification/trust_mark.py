"""The mark of a result that can't be used, by which what is said of it is known wherever it is shown."""

DOUBT = "NOT TO BE TRUSTED"
"""What such a line begins with; the reason, what was expected and the remedy follow."""
