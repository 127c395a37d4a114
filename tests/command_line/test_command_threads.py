"""A command's linear algebra has one thread, SciPy's too, which is loaded when the command is well under way."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

TOLD = "LINEAR_ALGEBRA"
CALL = f"""
import atexit, json, os, pathlib, runpy, sys
def tell():
    import threadpoolctl
    pathlib.Path(os.environ["{TOLD}"]).write_text(json.dumps(threadpoolctl.threadpool_info()))
atexit.register(tell)
runpy.run_module("pipeclamp", run_name="__main__")
"""


def test_a_commands_linear_algebra_has_one_thread(tmp_path: Path):
    told = tmp_path / "told.json"
    call = [sys.executable, "-c", CALL, "identify", "clamp_a", "-o", str(tmp_path / "law.json")]
    ours = {"PYTHONPATH": os.pathsep.join(sys.path), TOLD: str(told), "OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run(call, env={**os.environ, **ours}, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    libraries = [one for one in json.loads(told.read_text()) if one["user_api"] == "blas"]
    assert libraries
    assert {one["num_threads"] for one in libraries} == {1}
