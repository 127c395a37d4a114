"""Bytes to text: UTF-8, UTF-16 and UTF-32 by their marks or zeros, else a Windows code page, as machines write it."""

from __future__ import annotations

import codecs
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

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
WESTERN, CENTRAL = "cp1252", "cp1250"
CODE_PAGES = ("gb18030", "big5hkscs", "cp932", "cp949", "cp1251", CENTRAL, WESTERN)
"""Of Windows in Chinese, Japanese, Korean, Cyrillic, central European and western languages; the last where none is
surely the text's."""
FEWEST_DIFFERENT = 8
"""Bytes beyond ASCII, different ones, that tell a language that isn't written in Latin letters: units alone (°, µ, ²)
are fewer."""
MORE_LIKELY = 2.0
"""Factor by which central European letters must be likelier than western ones, which are taken without asking: with one
to ten names of channels in eleven western languages, drawn at random, it was 1.9 at most."""
POWERS = re.compile(rb"(?<=[A-Za-z])[\xb2\xb3\xb9](?![A-Za-z\x80-\xff])")
"""Of units (mm², m³) in the western page, which are letters in the central European one."""
BEYOND_ASCII = re.compile(rb"[^\n]*[\x80-\xff][^\n]*")
"""A line with such a byte; lines of numbers tell nothing, and are most of a file."""
ASCII = frozenset(range(128))
ASKED = 1 << 20
"""Bytes of a text that are asked for its language: its header's, and some thousand lines."""


def decoded(content: bytes) -> tuple[str, str]:
    """Give a file's text with line ends of one kind, and the name of its encoding; see `text_blocks`.

    Raises:
        Damaged: it is no text.
    """
    return next(text_blocks(io.BytesIO(content), len(content), len(content)), ("", "utf-8"))


def text_blocks(stream: BinaryIO, size: int, most: int) -> Iterator[tuple[str, str]]:
    """Give a file's text in blocks of whole lines, with line ends of one kind, and the name of its encoding.

    Without a byte order mark it is UTF-8 where it can be; other bytes are of the Windows code page of their language
    or, where too few tell it, of page 1252, which holds Latin-1's letters. That decides about names alone: numbers are
    the same in all of these.

    Args:
        stream: of the file.
        size: bytes of a block, about; all of the text is in one where it holds no more.
        most: bytes that it may hold.

    Raises:
        Damaged: it is no text, or holds more.
    """
    content, rest, read = stream.read(size), "", 0
    decoder = _Decoder(content)
    while content:
        read += len(content)
        if read > most:
            raise Damaged(f"holds more than {most / 2**30:.3g} GiB of text")
        following = stream.read(size)
        text = rest + decoder.text(content, final=not following)
        if "\0" in text:
            raise Damaged("holds zero bytes, as no text does: export or copy it again")
        # a line, and a line end of two characters, may be parted
        end = len(text) - (bool(following) and text.endswith("\r"))
        whole, rest = text[:end], text[end:]
        if "\r" in whole:
            whole = whole.replace("\r\n", "\n").replace("\r", "\n")
        if following:
            whole, _, begun = whole.rpartition("\n")
            rest = begun + rest
        if whole or not following:
            yield whole, decoder.encoding.removesuffix("-sig")
        content = following


def file_name(path: Path) -> str:
    """Give the name of a file or folder as text: one that isn't UTF-8, as older archives leave it, by its code page."""
    name = os.fsencode(path.name)
    try:
        return name.decode("utf-8")
    except UnicodeDecodeError:
        return name.decode(_code_page(name), "replace")


class _Decoder:
    """Bytes to text, block by block; where they can't be of one encoding, the next one is taken from there on."""

    def __init__(self, head: bytes) -> None:
        encoding = _encoding(head)
        self._others = [WESTERN, "latin-1"] if encoding == "utf-8" else []
        self._read = 0
        self._begin(encoding)

    def _begin(self, encoding: str) -> None:
        self.encoding = encoding
        self._decoder = codecs.getincrementaldecoder(encoding)()

    def text(self, content: bytes, *, final: bool) -> str:
        """Give the text of a block.

        Raises:
            Damaged: it is none of any encoding.
        """
        pending = self._decoder.getstate()[0]
        try:
            text = self._decoder.decode(content, final)
        except UnicodeDecodeError as error:
            self._read -= len(pending)
            if not self._others:
                place = self._read + error.start
                raise Damaged(f"is no whole text in {self.encoding} (byte {place})") from error
            if self.encoding == "utf-8" and (own := _code_page(pending + content)) not in self._others:
                self._others.insert(0, own)
            self._begin(self._others.pop(0))
            return self.text(pending + content, final=final)
        self._read += len(content)
        return text


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


def _code_page(content: bytes) -> str:
    """Give the Windows code page of a text's language."""
    # most texts do without
    from chardet import detect

    telling = b"\n".join(BEYOND_ASCII.findall(content[:ASKED]))
    if len(set(telling) - ASCII) >= FEWEST_DIFFERENT:
        found = detect(telling, include_encodings=CODE_PAGES, compat_names=False)["encoding"]
        if found in CODE_PAGES and found not in (WESTERN, CENTRAL):
            return found
    return CENTRAL if _is_central(POWERS.sub(b"", telling)) else WESTERN


def _is_central(text: bytes) -> bool:
    """Tell whether letters of Polish, Czech, Hungarian and their neighbours are surely meant, not western ones."""
    from chardet import detect_all

    if text.decode(CENTRAL, "replace") == text.decode(WESTERN, "replace"):
        return False
    asked = detect_all(text, ignore_threshold=True, include_encodings=(WESTERN, CENTRAL), compat_names=False)
    likely = {one["encoding"]: one["confidence"] for one in asked}
    return likely.get(CENTRAL, 0.0) > MORE_LIKELY * likely.get(WESTERN, 0.0)
