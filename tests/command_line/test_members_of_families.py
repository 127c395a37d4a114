"""One member of a family of effects in a law, by the commands as a user calls them."""

from __future__ import annotations

import json

from few_effects import few_effects

import pipeclamp as pc


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def test_a_smaller_memory_is_added_diagnosed_and_replaced(pipeclamp, half, law, tmp_path):
    """From `add law.json memory` on, as the README walks."""
    one, two = tmp_path / "one.json", tmp_path / "two.json"
    pipeclamp("add", law, "memory", half, "-o", one)
    with few_effects("damping_temperature", "memory", "relaxation"):
        assert pc.diagnose(one, half).verdict in ("missing", "ambiguous")
    done = pipeclamp("add", one, "memory", half, "-o", tmp_path / "again.json", status=1)
    assert "effect 'memory' is in the law already" in done.stderr
    pipeclamp("add", one, "memory:2", half, "-o", two)
    assert read(two)["effects"] == ["memory:2"]
    assert {"k_s1", "k_s2"} <= set(read(two)["coefficients"])
    assert "k_s" not in read(two)["coefficients"]
    done = pipeclamp("add", two, "memory", half, "-o", tmp_path / "again.json", status=1)
    assert "the law has 'memory:2' already" in done.stderr
    assert not (tmp_path / "again.json").exists()


def test_two_members_are_refused(pipeclamp, small, law, tmp_path):
    words = "effects 'memory' and 'memory:2' are one effect with different numbers, and a law has one of them"
    done = pipeclamp("identify", small, "-o", tmp_path / "a.json", "--effects", "memory,memory:2", status=1)
    assert words in done.stderr
    content = read(law)
    content["effects"] = ["memory", "memory:2"]
    for name, unit in {"k_s": "N/mm", "z_s": "N", "k_s1": "N/mm", "z_s1": "N", "k_s2": "N/mm", "z_s2": "N"}.items():
        content["coefficients"][name] = {"value": 1.0, "unit": unit, "state": "given"}
    both = tmp_path / "both.json"
    both.write_text(json.dumps(content), encoding="utf-8")
    done = pipeclamp("compare", both, small, status=1)
    assert f"{both}: {words}" in done.stderr.replace("\n", " ")
