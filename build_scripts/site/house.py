"""Sphinx extension: a picture of the house and a table of its rooms, drawn from the code's own imports.

`{house}` draws each package as a storey, ground floor below, its rooms from left to right in the order in which they
import each other; arrows at the side say how many imports go down from one storey to another. A table follows.
"""

from __future__ import annotations

import ast
import itertools
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path

from docutils import nodes
from markdown import MarkdownDirective, table
from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
STOREYS = {
    "pipeclamp_models": ("models", "the physics: effects, law, realisations, pipe"),
    "pipeclamp_fmu": ("fmu_src", "makes FMUs"),
    "pipeclamp_system": ("fmu_src", "runs systems of pipes and clamps"),
    "pipeclamp_identification": ("identification", "from measurements to a law and to what it lacks"),
    "pipeclamp": ("identification", "the front door: command line, pages, Python"),
}
"""Packages from the ground up, the folder that each stands in, and what it is for."""
WIDTH, SIDE, A_ROW = 760, 96, 5
BOX_WIDTH, BOX_HEIGHT, GAP, HEAD = 122, 44, 8, 26


@dataclass(frozen=True)
class Room:
    """A package inside a package.

    Attributes:
        package, name: where it is.
        purpose: the first sentence of what its entrance says.
        modules, lines: how large it is.
        imports: how often it imports each other room, by "package.room"; or a package's own modules, by "package".
    """

    package: str
    name: str
    purpose: str
    modules: int
    lines: int
    imports: Mapping[str, int]

    @property
    def full_name(self) -> str:
        """Package and room."""
        return f"{self.package}.{self.name}"


def _imported(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def _room(entrance: Path, package: str) -> Room:
    files = list(entrance.parent.rglob("*.py"))
    names = (name.split(".") for file in files for name in _imported(file))
    imports = Counter(".".join(parts[:2]) for parts in names if parts[0] in STOREYS)
    own = f"{package}.{entrance.parent.name}"
    words = ast.get_docstring(ast.parse(entrance.read_text(encoding="utf-8"))) or ""
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    purpose = " ".join(words.split("\n\n")[0].split())
    return Room(
        package, entrance.parent.name, purpose, len(files) - 1, lines, {k: n for k, n in imports.items() if k != own}
    )


@dataclass(frozen=True)
class House:
    """All rooms of a checkout."""

    root: Path

    @cached_property
    def storeys(self) -> dict[str, list[Room]]:
        """Give each package's rooms, each after all that it imports."""
        return {package: self._in_order(package) for package in STOREYS}

    def _in_order(self, package: str) -> list[Room]:
        folder = self.root / STOREYS[package][0] / package
        waiting = sorted((_room(path, package) for path in folder.glob("*/__init__.py")), key=lambda room: room.name)
        ordered: list[Room] = []
        while waiting:
            left = {room.full_name for room in waiting}
            ready = [room for room in waiting if not left & set(room.imports)] or waiting
            ordered += ready
            waiting = [room for room in waiting if room not in ready]
        return ordered

    def between(self, upper: str, lower: str) -> int:
        """Count a package's imports of another."""
        return sum(n for room in self.storeys[upper] for name, n in room.imports.items() if name.split(".")[0] == lower)


def _room_box(room: Room, x: float, y: float) -> str:
    uses = ", ".join(sorted(name.split(".", 1)[-1] for name in room.imports if name.startswith(f"{room.package}.")))
    below = ", ".join(sorted({name for name in room.imports if not name.startswith(f"{room.package}.")}))
    said = f"{room.purpose} Imports beside it: {uses or 'nothing'}. Below it: {below or 'nothing'}."
    size = f"{room.modules} modules, {room.lines} lines"
    return (
        f'<g class="room" transform="translate({x:g} {y:g})"><title>{escape(said)}</title>'
        f'<rect width="{BOX_WIDTH}" height="{BOX_HEIGHT}" rx="5"/>'
        f'<text class="name" x="8" y="18">{escape(room.name)}</text><text class="size" x="8" y="34">{size}</text></g>'
    )


def picture(house: House) -> str:
    """Draw the house as SVG."""
    parts: list[str] = []
    middle: dict[str, float] = {}
    y = 4.0
    for package in reversed(STOREYS):
        rooms = house.storeys[package]
        rows = -(-len(rooms) // A_ROW)
        height = HEAD + rows * (BOX_HEIGHT + GAP) + 4
        middle[package] = y + height / 2
        parts.append(
            f'<g class="storey"><rect x="{SIDE}" y="{y:g}" width="{WIDTH - SIDE - 2}" height="{height:g}" rx="7"/>'
            f'<text class="package" x="{SIDE + 12}" y="{y + 18:g}">{package}</text>'
            f'<text class="purpose" x="{WIDTH - 14}" y="{y + 18:g}">{escape(STOREYS[package][1])}</text></g>'
        )
        for place, room in enumerate(rooms):
            x = SIDE + 12 + (place % A_ROW) * (BOX_WIDTH + GAP)
            parts.append(_room_box(room, x, y + HEAD + (place // A_ROW) * (BOX_HEIGHT + GAP)))
        y += height + 12
    order = list(reversed(STOREYS))
    parts += [
        _arrow(middle[upper], middle[lower], order.index(lower) - order.index(upper), count)
        for upper, lower in itertools.combinations(order, 2)
        if (count := house.between(upper, lower))
    ]
    return (
        f'<svg class="house" viewBox="0 0 {WIDTH} {y:g}" role="img" aria-label="The packages and their rooms">'
        '<defs><marker id="head" markerUnits="userSpaceOnUse" markerWidth="7" markerHeight="6" refX="6" refY="3" '
        f'orient="auto"><path d="M0 0 7 3 0 6z"/></marker></defs>{"".join(parts)}</svg>'
    )


def _arrow(start: float, end: float, floors: int, count: int) -> str:
    """Draw an arrow from a storey down to another, the further out the further it goes."""
    out = SIDE - 20 * floors - 6
    a, b = start + 7 * (floors - 1), end - 7 * floors + 3
    width = 0.8 + min(count, 120) / 40
    words = f"{count} imports"
    return (
        f'<path class="arrow" d="M{SIDE} {a:g}C{out} {a:g} {out} {b:g} {SIDE - 2} {b:g}" stroke-width="{width:.1f}" '
        f'marker-end="url(#head)"><title>{words}</title></path>'
    )


class HouseDirective(MarkdownDirective):
    """The picture and the table of rooms."""

    def lines(self) -> list[str]:
        """Give the table."""
        rooms = [room for storey in House(ROOT).storeys.values() for room in storey]
        return table(
            ("room", "what it is for", "modules", "lines"),
            [(f"`{room.full_name}`", room.purpose, str(room.modules), str(room.lines)) for room in rooms],
        )

    def run(self) -> list[nodes.Node]:
        """Give the picture, then the table."""
        return [nodes.raw("", f"<figure>{picture(House(ROOT))}</figure>", format="html"), *super().run()]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("house", HouseDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
