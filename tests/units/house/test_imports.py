"""The rooms of the house: each package imports only those that stand before it, and what else it may know."""

import ast

import pytest
from project import ROOT, imported

ROOTS = {
    "pipeclamp_models": "models",
    "pipeclamp_fmu": "fmu_src",
    "pipeclamp_system": "fmu_src",
    "pipeclamp_identification": "identification",
    "pipeclamp": "identification",
}
"""Packages in the order in which they may import each other, and their folders."""
ROOMS = {
    "pipeclamp_models": ("base", "equations", "effects", "law", "steps", "realise", "pipe"),
    "pipeclamp_fmu": ("slaves", "describe", "contents", "python", "native"),
    "pipeclamp_system": (
        "description", "fmus", "coupling", "transient", "cosim", "steady", "response", "bands", "study",
    ),
    "pipeclamp_identification": (
        "signals", "units", "campaign", "loops", "fitting", "comparison", "diagnosis", "discovery", "metrics_only",
        "importing", "on_pipe", "attribution", "planning", "workflow",
    ),
    "pipeclamp": ("show", "pages", "api", "studio", "cli"),
}  # fmt: skip
"""The packages inside, in the same order; what stands beside them in the root may import them all."""
NEVER = {
    "pipeclamp_models": {"fmpy", "pythonfmu", "plotly", "typer", "rich", "jinja2"},
    "pipeclamp_fmu": {"polars", "plotly", "typer", "rich"},
    "pipeclamp_system": {"plotly", "typer", "rich", "jinja2"},
    "pipeclamp_identification": {"plotly", "typer", "rich", "jinja2"},
}
"""Libraries that a package doesn't know."""
MOST_MODULES = 20
REGISTRIES = {"pipeclamp_models/effects"}
"""Folders whose every file is one entry of a list."""


def folder(package):
    return ROOT / ROOTS[package] / package


@pytest.mark.parametrize("package", ROOTS)
def test_nothing_imports_to_the_right(package):
    order = list(ROOTS)
    right = set(order[order.index(package) + 1 :]) | NEVER.get(package, set())
    for file in folder(package).rglob("*.py"):
        for name in imported(file):
            assert name.split(".")[0] not in right, f"{file} imports {name}"


@pytest.mark.parametrize("package", ROOMS)
def test_rooms_inside_import_one_way(package):
    rooms = ROOMS[package]
    found = {file.parent.name for file in folder(package).glob("*/__init__.py")}
    assert found == set(rooms)
    for place, room in enumerate(rooms):
        right = {f"{package}.{later}" for later in rooms[place + 1 :]}
        for file in (folder(package) / room).rglob("*.py"):
            for name in imported(file):
                assert ".".join(name.split(".")[:2]) not in right, f"{file} imports {name}"


@pytest.mark.parametrize("package", ROOMS)
def test_a_package_names_its_rooms(package):
    words = ast.get_docstring(ast.parse((folder(package) / "__init__.py").read_text(encoding="utf-8"))) or ""
    rooms = ", ".join(ROOMS[package])
    assert f"Its packages, each importing only those before it: {rooms}." in " ".join(words.split())


@pytest.mark.parametrize("package", ROOTS)
def test_rooms_are_small_and_say_what_they_are_for(package):
    for entrance in folder(package).rglob("__init__.py"):
        room = entrance.parent.relative_to(folder(package).parent).as_posix()
        modules = list(entrance.parent.glob("*.py"))
        assert len(modules) - 1 <= MOST_MODULES or room in REGISTRIES, f"{room} holds {len(modules) - 1} modules"
        words = ast.get_docstring(ast.parse(entrance.read_text(encoding="utf-8"))) or ""
        assert len(words.splitlines()) >= 3, f"{room}: three lines should say what it is for"


def test_rooms_of_tests_are_small():
    for room in {file.parent for file in (ROOT / "tests" / "units").rglob("*.py")}:
        assert len(list(room.glob("test_*.py"))) <= MOST_MODULES, room


def test_polars_is_imported_in_one_place():
    """There Ctrl-C is given back to Python."""
    files = [file for package in ROOTS for file in folder(package).rglob("*.py")]
    assert [file.name for file in files if "polars" in set(imported(file))] == ["tables.py"]


@pytest.mark.parametrize("package", ROOTS)
def test_no_cycles_within_a_package(package):
    """Modules of a package can be put in an order in which each imports only what stands before it."""
    modules = {
        ".".join([package, *file.relative_to(folder(package)).with_suffix("").parts]).removesuffix(".__init__"): file
        for file in folder(package).rglob("*.py")
    }
    left = {
        name: {target for target in imported(file) if target in modules and target != name}
        for name, file in modules.items()
    }
    while ready := [name for name, needs in left.items() if not needs]:
        for name in ready:
            del left[name]
        for needs in left.values():
            needs -= set(ready)
    assert not left, f"cycle among {sorted(left)}"
