"""The rooms: nothing imports to the right of pipeclamp <- pipeclamp_fmu <- pipeclamp_identification."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = {
    "pipeclamp": ROOT / "models" / "pipeclamp",
    "pipeclamp_fmu": ROOT / "fmu_src" / "pipeclamp_fmu",
    "pipeclamp_identification": ROOT / "identification" / "pipeclamp_identification",
}
ORDER = list(ROOMS)
HEAVY = {
    "pipeclamp": {"fmpy", "pythonfmu", "polars", "plotly", "typer", "rich", "jinja2"},
    "pipeclamp_fmu": {"polars", "plotly", "typer"},
}


def imported(file):
    """Names of modules that a file imports, relative ones refused."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("room", ORDER)
def test_nothing_imports_to_the_right(room):
    right = set(ORDER[ORDER.index(room) + 1 :]) | HEAVY.get(room, set())
    for file in ROOMS[room].rglob("*.py"):
        for name in imported(file):
            assert name.split(".")[0] not in right, f"{file} imports {name}"


def test_polars_is_imported_in_one_place():
    """There Ctrl-C is given back to Python."""
    files = ROOMS["pipeclamp_identification"].rglob("*.py")
    assert [file.name for file in files if "polars" in set(imported(file))] == ["tables.py"]


def test_no_cycles_within_a_room():
    """Modules of a room can be put in an order in which each imports only what stands before it."""
    for room, folder in ROOMS.items():
        modules = {
            ".".join([room, *file.relative_to(folder).with_suffix("").parts]).removesuffix(".__init__"): file
            for file in folder.rglob("*.py")
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
