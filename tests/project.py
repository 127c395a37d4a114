"""Where things of the project lie, and what a file of its code imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUILD_SCRIPTS = ROOT / "build_scripts"
TRUTH_TABLE = BUILD_SCRIPTS / "truth_table"
PIPE_TRUTH = BUILD_SCRIPTS / "pipe_truth"
DATA = ROOT / "identification" / "pipeclamp_identification" / "data"
EXAMPLES = DATA / "examples"
DECLARED_EFFECTS = ROOT / "tests" / "effects" / "declared"


def imported(file: Path) -> Iterator[str]:
    """Names of modules that a file imports, relative ones refused."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            assert node.module is not None
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
