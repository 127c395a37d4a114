"""A process that has loaded all of the program, and becomes a command at each call: loading takes most of a short one.

It reads one call a line from stdin, as JSON, and answers with its exit status. Each call is a process of its own,
forked from this one, which never computes: loaded modules are all that tells it from `python -m pipeclamp`.
"""

import atexit
import gc
import importlib
import json
import multiprocessing
import os
import pkgutil
import runpy
import signal
import sys

PACKAGES = ("pipeclamp_models", "pipeclamp_fmu", "pipeclamp_system", "pipeclamp_identification", "pipeclamp")
LOADED_LATE = ("control", "pint", "rich.console", "rich.table")
"""Libraries that functions load, and that take long to."""


def load_all() -> None:
    """Load all modules but those that are run, and libraries."""
    for library in LOADED_LATE:
        importlib.import_module(library)
    for package in PACKAGES:
        for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)


def become(words: list[str], cwd: str, environment: dict[str, str], out: str, told: str, longest: int) -> None:
    """Take the place of a process that was just started with these words."""
    signal.alarm(longest)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    for number, path in enumerate((os.devnull, out, told)):
        os.dup2(os.open(path, os.O_RDWR), number)
    sys.argv = ["pipeclamp", *words]
    sys.path[0] = cwd
    try:
        runpy.run_module("pipeclamp", run_name="__main__", alter_sys=True)
    finally:
        atexit._run_exitfuncs()  # a fork's end leaves them out


def serve() -> None:
    """Answer calls until nobody asks."""
    load_all()
    gc.freeze()  # what is shared with each call isn't searched by it
    for line in sys.stdin:
        call = multiprocessing.get_context("fork").Process(target=become, kwargs=json.loads(line))
        call.start()
        call.join()
        sys.stdout.write(f"{call.exitcode}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    serve()
