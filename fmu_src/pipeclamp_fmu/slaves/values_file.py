"""The file of values in an FMU's resources: what can be replaced while the program that reads it stays.

A line each: a name, a number as the 16 hexadecimal digits of its bits, then for people the number and its unit. So the
numbers are exact and don't depend on how a language writes "0.5". `native/values.c` reads the same file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

FILE_NAME = "values.txt"

TOLD = "as told to build-fmu"
"""Behind a start value that another law's parameters leave as it is."""


def values_text(token: str, name: str, numbers: Iterable[tuple[str, float, str]]) -> str:
    """Give the file's text.

    Args:
        token: of the model description that belongs to it.
        name: the name that messages use.
        numbers: name, value and unit of each.
    """
    lines = [f"token {token}", f"name {' '.join(name.split())}"]
    lines += [f"{key} {struct.pack('>d', value).hex()} {value!r} {unit}".rstrip() for key, value, unit in numbers]
    return "\n".join(lines) + "\n"


def read_values(folder: str, names: Sequence[str]) -> tuple[str, list[float]]:
    """Read the name that messages use and the numbers of these names, in this order.

    Raises:
        ValueError: a line is not the one that is expected.
        OSError: the file can't be read.
    """
    lines = iter(Path(folder, FILE_NAME).read_text(encoding="utf-8").splitlines())

    def after(name: str) -> str:
        line = next(lines, "")
        if not line.startswith(f"{name} "):
            raise ValueError(f"resources/{FILE_NAME}: expected {name}")
        return line[len(name) + 1 :]

    def number(name: str) -> float:
        digits = after(name)[:16]
        if len(digits) != 16 or not set(digits) <= set("0123456789abcdef"):
            raise ValueError(f"resources/{FILE_NAME}: expected 16 hexadecimal digits after {name}")
        value: float = struct.unpack(">d", bytes.fromhex(digits))[0]
        return value

    after("token")
    return after("name"), [number(name) for name in names]


def told_values(text: str) -> dict[str, float]:
    """Give the start values of a file's text that were told when the FMU was built, by name."""
    lines = [line.split(" ") for line in text.splitlines() if line.endswith(TOLD)]
    return {name: struct.unpack(">d", bytes.fromhex(digits))[0] for name, digits, *_ in lines}
