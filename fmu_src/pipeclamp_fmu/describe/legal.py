"""Who made an FMU, under which licences its parts are, and what it needs of its host."""

from __future__ import annotations

import importlib.metadata

AUTHOR = "pipeclamp"
COPYRIGHT = "Copyright (c) the pipeclamp engineers"
FOLDER = "documentation/licenses"
ATTRIBUTES = {"author": AUTHOR, "copyright": COPYRIGHT, "license": f"MIT, see {FOLDER}"}
"""Of the model description, in both versions of FMI."""


def licence_files(*packages: str) -> dict[str, bytes]:
    """Give the licences of this program, whose code is inside, and of further packages, by their place in an FMU."""
    places = {"pipeclamp": f"{FOLDER}/license.txt"} | {name: f"{FOLDER}/{name}.txt" for name in packages}
    return {place: licence(name).encode("utf-8") for name, place in places.items()}


def licence(package: str) -> str:
    """Give the text of an installed package's licence, or its name and version where it came without one."""
    distribution = importlib.metadata.distribution(package)
    texts = (distribution.read_text(place) for place in ("licenses/LICENSE", "LICENSE"))
    return next(filter(None, texts), f"{package} {distribution.version}: see there for its licence\n")


PYTHON_NEEDS = """\
This FMU runs Python. It needs, of the tool that imports it:

- Linux (glibc 2.32 or newer) or Windows on x86-64, and a 64-bit CPython 3.10 or newer whose library it has loaded;
- nothing beside Python's standard library: the package pythonfmu is inside;
- a place to unpack it whose path holds only characters that stand as they are in a URI (letters, digits, - . _ ~ /) and
  spaces: pythonfmu undoes no other encoding, and ends the tool's process where it doesn't find its files.

A native FMU (pipeclamp build-fmu --kind native) needs none of this.
"""
"""The text of `documentation/externalDependencies.txt` in a Python FMU."""
