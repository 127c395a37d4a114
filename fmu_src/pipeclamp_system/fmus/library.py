"""Shared libraries, looked at before they are loaded: one that is cut short ends the whole process."""

from __future__ import annotations

import ast
import struct
from functools import lru_cache
from pathlib import Path

from pipeclamp_models.base.errors import UserError

ELF, PE, MACH_O = b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe"
LOADED, MACH_SEGMENT = 1, 0x19
"""What a segment that is loaded is marked by, in ELF and in Mach-O."""


def refuse_cut_libraries(folder: Path, fmu: Path) -> None:
    """Refuse an unpacked FMU with a library that is shorter than it says itself.

    Args:
        folder: that it was unpacked into.
        fmu: for messages.

    Raises:
        UserError: there is one.
    """
    for path in sorted((folder / "binaries").rglob("*")):
        if path.suffix.lower() in (".so", ".dll", ".dylib") and path.is_file():
            content = path.read_bytes()
            try:
                needed = _size_needed(content)
            except struct.error:
                needed = len(content) + 1
            if needed > len(content):
                raise UserError(
                    f"{fmu}: {path.relative_to(folder).as_posix()} in it is cut short ({len(content)} bytes); expected "
                    "a whole library: build, export or copy the FMU again"
                )


def refuse_cut_program(folder: Path, fmu: Path) -> None:
    """Refuse an unpacked FMU in Python that lacks its program, or has it cut short: loading it ends the process.

    Args:
        folder: that it was unpacked into.
        fmu: for messages.

    Raises:
        UserError: it does.
    """
    resources = folder / "resources"
    place = "slavemodule.txt"
    try:
        name = (resources / place).read_text(encoding="utf-8").strip()
        place = f"{name}.py"
        whole = _holds_a_class((resources / place).read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError, RecursionError, MemoryError) as error:
        raise UserError(
            f"{fmu}: resources/{place} in it is missing or isn't whole; expected the FMU's program: build or copy the "
            "FMU again"
        ) from error
    if not whole:
        raise UserError(f"{fmu}: resources/{place} in it holds no class; expected the FMU's program, whole")


@lru_cache(maxsize=16)
def _holds_a_class(program: str) -> bool:
    """Tell whether a program that Python can read defines a class; FMUs of one program differ by their values alone.

    Raises:
        ValueError, SyntaxError, RecursionError, MemoryError: Python can't read it.
    """
    return any(isinstance(node, ast.ClassDef) for node in ast.parse(program).body)


def _size_needed(content: bytes) -> int:
    """Give how many bytes a library says that it has: of its last segment and of its tables.

    Raises:
        struct.error: it ends within them.
    """
    if not content:
        return 1
    if content.startswith(ELF):
        return _elf_size(content)
    if content.startswith(PE):
        return _pe_size(content)
    if content.startswith(MACH_O):
        return _mach_o_size(content)
    return 0  # of no format that is known here: the system's loader says what it is


def _elf_size(content: bytes) -> int:
    wide, order = content[4:5] == b"\x02", ">" if content[5:6] == b"\x02" else "<"
    header = struct.unpack_from(order + ("QQQIHHHHHH" if wide else "IIIIHHHHHH"), content, 24)
    _, segments, sections, _, _, segment_size, segment_count, section_size, section_count, _ = header
    needed = max(segments + segment_size * segment_count, sections + section_size * section_count)
    for index in range(segment_count):
        place = segments + index * segment_size
        if wide:
            kind, _, offset, _, _, size = struct.unpack_from(order + "IIQQQQ", content, place)
        else:
            kind, offset, _, _, size = struct.unpack_from(order + "IIIII", content, place)
        if kind == LOADED:
            needed = max(needed, offset + size)
    return int(needed)


def _pe_size(content: bytes) -> int:
    (place,) = struct.unpack_from("<I", content, 60)
    _, _, count, _, _, _, optional = struct.unpack_from("<4sHHIIIH", content, place)
    sections = [struct.unpack_from("<8sIIII", content, place + 24 + optional + 40 * index) for index in range(count)]
    return int(max((offset + size for _, _, _, size, offset in sections), default=0))


def _mach_o_size(content: bytes) -> int:
    (count,) = struct.unpack_from("<I", content, 16)
    place, needed = 32, 0
    for _ in range(count):
        kind, size = struct.unpack_from("<II", content, place)
        if kind == MACH_SEGMENT:
            offset, length = struct.unpack_from("<QQ", content, place + 40)
            needed = max(needed, offset + length)
        place += max(size, 8)
    return int(max(needed, place))
