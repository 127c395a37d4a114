"""Making one module of a slave's source and what it imports from us.

All Python FMUs of a process share one interpreter and its table of modules: a helper imported by a common name would be
the first FMU's helper for all of them. So a slave goes into its FMU as one file, under a name that its content gives.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib import resources


def source_text(module: str) -> str:
    """Give the text of a module by its full name."""
    package, *path, name = module.split(".")
    return resources.files(package).joinpath(*path, f"{name}.py").read_text(encoding="utf-8")


def _without(source: str, nodes: Iterable[tuple[ast.stmt, str]]) -> str:
    """Give the source with each statement replaced by a text."""
    lines = source.splitlines()
    for node, text in sorted(nodes, key=lambda pair: -pair[0].lineno):
        lines[node.lineno - 1 : node.end_lineno] = text.splitlines()
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def _parsed(source: str) -> ast.Module:
    """Parse a module, which nobody may change; the same few stand in every FMU, whose studies build hundreds."""
    return ast.parse(source)


def body_of(source: str) -> str:
    """Give a module's source without its docstring and its imports from `__future__`, to stand inside another."""
    nodes = _parsed(source).body
    heading = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module == "__future__"]
    if ast.get_docstring(_parsed(source)) is not None:
        heading.append(nodes[0])  # type: ignore[arg-type]
    return _without(source, ((node, "") for node in heading)).strip("\n") + "\n"


def with_inlined(source: str, parts: Mapping[str, str]) -> str:
    """Put texts in place of a source's `from <module> import ...` statements.

    Args:
        source: a module's text.
        parts: text by the module whose import it replaces.

    Raises:
        ValueError: a module of `parts` is imported other than exactly once.
    """
    found = [
        (node, f"# {node.module}\n{body_of(parts[node.module])}")
        for node in _parsed(source).body
        if isinstance(node, ast.ImportFrom) and node.module is not None and node.module in parts
    ]
    if sorted(str(node.module) for node, _ in found) != sorted(parts):
        raise ValueError(f"expected one import from each of {sorted(parts)}, got {len(found)}")
    return _without(source, found)


def content_hash(*texts: str) -> str:
    """Give 64 hexadecimal digits (SHA-256) that the texts, in their order, determine."""
    digest = hashlib.sha256()
    for text in texts:
        data = text.encode("utf-8")
        digest.update(len(data).to_bytes(8, "big"))
        digest.update(data)
    return digest.hexdigest()
