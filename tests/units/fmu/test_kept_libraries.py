"""What was compiled is kept: the same compiler isn't asked again of the same sources."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pipeclamp_fmu.native import compiler
from pipeclamp_fmu.native.compiler import compile_sources
from pipeclamp_models.base.errors import UserError


@pytest.mark.skipif(os.name != "posix", reason="a shell script stands for the compiler")
def test_a_library_is_made_once_of_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def written(output: str = "so") -> None:
        stand_in.write_text(f"#!/bin/sh\necho once >>{asked}\ncat fmu.c >linux64.{output}\n", encoding="utf-8")
        stand_in.chmod(0o755)

    def times(text: str) -> int:
        asked.write_text("", encoding="utf-8")
        assert compile_sources({"fmu.c": text}, ["linux64"]) == {"linux64": text.encode()}
        return len(asked.read_text(encoding="utf-8").splitlines())

    stand_in, asked = tmp_path / "cc", tmp_path / "asked"
    monkeypatch.setattr(compiler, "_compiler", lambda name: [str(stand_in)])
    monkeypatch.setenv("PIPECLAMP_CACHE", str(tmp_path / "kept"))
    written("none")
    with pytest.raises(UserError, match="failed for linux64"):
        times("int one;")
    written()
    assert [times("int one;"), times("int one;")] == [1, 0], "what failed isn't kept, what was made is"
    assert times("int other;") == 1
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-O3"))
    assert times("int one;") == 1
    os.utime(stand_in, (1.0, 1.0))  # another compiler in its place
    assert times("int one;") == 1
    monkeypatch.setenv("PIPECLAMP_CACHE", "")
    assert times("int one;") == 1
