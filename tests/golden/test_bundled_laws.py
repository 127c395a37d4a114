"""Pinned files: `python build_scripts/bundled_laws.py` makes them anew."""

import json

import pytest

from pipeclamp_identification.metrics_only.published import bundled_files
from pipeclamp_models.law.bundled import bundled_laws, open_law
from pipeclamp_models.law.file import law_text


def numbers(value, path=""):
    """Flatten a JSON value into (path, leaf)."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from numbers(entry, f"{path}.{key}")
    elif isinstance(value, list):
        for index, entry in enumerate(value):
            yield from numbers(entry, f"{path}[{index}]")
    else:
        yield path, value


@pytest.fixture(scope="module")
def made():
    return {file.name: file for file in bundled_files(open_law("emwm2").software)}


def test_names(made):
    assert set(made) == set(bundled_laws())


@pytest.mark.parametrize("name", bundled_laws())
def test_bundled_law_is_what_the_script_makes(made, name):
    """To 1e-4, standard errors to 2e-3: the optimiser's last digits differ between machines."""
    ours = dict(numbers(json.loads(law_text(made[name]))))
    pinned = dict(numbers(json.loads(law_text(open_law(name)))))
    assert ours.keys() == pinned.keys()
    for path, value in pinned.items():
        if isinstance(value, float):
            assert ours[path] == pytest.approx(value, rel=2e-3 if "error" in path else 1e-4), path
        else:
            assert ours[path] == value, path
