"""Bytes to text: UTF-8, UTF-16 and UTF-32 by their marks or zeros, else the Windows code page, as machines write it."""

from __future__ import annotations

import codecs

from pipeclamp_identification.importing.raw import Damaged

MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
"""Byte order marks, the longer ones before those that they begin with."""
LOOKED_AT = 4096
ZEROS = 0.3
"""Share of the bytes at even, or at odd places that are zero in UTF-16 text of numbers."""


def decoded(content: bytes) -> tuple[str, str]:
    """Give a file's text with line ends of one kind, and the name of its encoding.

    Without a byte order mark it is UTF-8 where it can be; other bytes are of the Windows code page 1252, which holds
    Latin-1's letters. That decides about names alone: numbers are the same in all of these.

    Raises:
        Damaged: it is no text.
    """
    encoding = _encoding(content)
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding != "utf-8":
            raise Damaged(f"is no whole text in {encoding} (byte {error.start})") from error
        encoding = "cp1252"
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            encoding = "latin-1"
            text = content.decode(encoding)
    if "\0" in text:
        raise Damaged("holds zero bytes, as no text does")
    return text.replace("\r\n", "\n").replace("\r", "\n"), encoding.removesuffix("-sig")


def _encoding(content: bytes) -> str:
    for mark, name in MARKS:
        if content.startswith(mark):
            return name
    head = content[:LOOKED_AT]
    if len(head) >= 4:
        even, odd = head[::2].count(0) / len(head[::2]), head[1::2].count(0) / len(head[1::2])
        if odd > ZEROS > 2 * even:
            return "utf-16-le"
        if even > ZEROS > 2 * odd:
            return "utf-16-be"
    return "utf-8"
