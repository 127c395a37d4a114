"""An icon: a loop of force over displacement, as PNG."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence

import numpy as np

SIZE, MARGIN, WIDTH = 128, 14.0, 2.2
OUTWARD = np.array([[-WIDTH], [WIDTH]])
LINE, GROUND = np.array([11, 83, 148.0]), np.array([255, 255, 255.0])


def loop_icon(across: Sequence[float], up: Sequence[float]) -> bytes:
    """Give a picture of a closed line, scaled to the picture's size.

    Args:
        across: to the right, (n,).
        up: upwards, (n,).
    """
    points = np.array([across, up]).T
    low, high = points.min(axis=0), points.max(axis=0)
    placed = MARGIN + (SIZE - 2 * MARGIN) * (points - low) / np.where(high > low, high - low, 1.0)
    placed[:, 1] = SIZE - placed[:, 1]
    begins, steps = placed, np.roll(placed, -1, axis=0) - placed
    middles = np.arange(SIZE) + 0.5
    nearest = np.full((SIZE, SIZE), np.inf)
    for begin, step in zip(begins, steps, strict=True):
        # A line reaches no pixel farther off than its own width.
        (left, top), (right, bottom) = (np.sort([begin, begin + step], axis=0) + OUTWARD).astype(int)
        near = slice(top, bottom + 1), slice(left, right + 1)
        x, y = middles[near[1]] - begin[0], middles[near[0], None] - begin[1]
        along = np.clip((x * step[0] + y * step[1]) / max(float(step @ step), 1e-12), 0.0, 1.0)
        nearest[near] = np.minimum(nearest[near], np.hypot(x - along * step[0], y - along * step[1]))
    cover = np.clip(WIDTH / 2 + 0.5 - nearest, 0.0, 1.0)[..., None]
    image = (cover * LINE + (1 - cover) * GROUND).round().astype(np.uint8).reshape(SIZE, SIZE * 3)
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
