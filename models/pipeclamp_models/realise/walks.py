"""States stepped along motions by machine code, which LLVM makes of their equations."""

from __future__ import annotations

import base64
import ctypes
import os
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from llvmlite import binding

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.kept import kept

Compiled = Callable[..., Sequence[Any]]
SPEED_LEVEL = 2
"""How hard LLVM tries: beyond that it takes longer than it gains."""
LIBRARY = ("exp", "expm1", "log", "pow", "sin", "cos", "tan", "atan", "tanh")
"""Functions of the C library that machine code may call."""

_ENGINES: list[binding.ExecutionEngine] = []
"""What holds machine code: it lives as long as the process, as the functions do."""


class March:
    """What goes through all samples of all rows.

    Attributes:
        columns: places of what it takes among the arguments that it is given.
    """

    def __init__(self, name: str, columns: Sequence[int], source: str) -> None:
        self._name = name
        self._source = source
        self.columns = columns

    def __call__(self, arguments: Sequence[Array], start: Array, results: int, shape: tuple[int, int]) -> Array:
        """Give the results, shape (K, R, n).

        Args:
            arguments: each (R, n) or what broadcasts to it.
            start: states before the first sample, (J, R).
            results: their count, K.
            shape: (R, n).
        """
        taken = [np.broadcast_to(np.asarray(arguments[place], dtype=np.float64), shape) for place in self.columns]
        places = np.array([each.ctypes.data for each in taken], dtype=np.uintp)
        strides = np.array([each.strides for each in taken], dtype=np.int64)
        written = np.empty((results, *shape))
        begin = np.ascontiguousarray(start, dtype=np.float64)
        addresses = (each.ctypes.data for each in (places, strides, begin, written))
        _function(self._name, self._source)(*shape, *addresses)
        return written


class Walk:
    """How a set of states is stepped along motions.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], columns: Sequence[int], source: str) -> None:
        self.states = list(states)
        self._march = March("walk", columns, source)

    def __call__(self, start: Array, arguments: Sequence[Array], shape: tuple[int, int]) -> Array:
        """Give the set's states after each sample, (J, R, n).

        Args:
            start: all of the law's states before the first sample, (L, R).
            arguments: the update's, without the states, each (R, n) or what broadcasts to it.
            shape: (R, n).
        """
        return self._march(arguments, start[self.states], len(self.states), shape)


class StepSlopes:
    """The slopes of steps of a set of states, so many of them."""

    def __init__(self, count: int, columns: Sequence[int], source: str) -> None:
        self._count = count
        self._march = March("slopes", columns, source)

    def __call__(self, arguments: Sequence[Array], shape: tuple[int, int]) -> Array:
        """Give the slopes at each sample, (K, R, n); arguments are the update's, each what broadcasts to (R, n)."""
        return self._march(arguments, np.empty((0, shape[0])), self._count, shape)


@cache
def _function(name: str, source: str) -> Callable[..., None]:
    """Give a function of a module in LLVM's language; its machine code is kept from one call to the next."""
    described = f"{_target().triple} {_cpu()}"
    encoded = kept(
        f"machine code {binding.llvm_version_info} {described} {source}",
        lambda: base64.b64encode(_machine_code(source)).decode(),
    )
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _target_machine())
    _ENGINES.append(engine)
    engine.add_object_file(binding.ObjectFileRef.from_data(base64.b64decode(encoded)))
    engine.finalize_object()
    takes = [ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 4]
    return ctypes.CFUNCTYPE(None, *takes)(engine.get_function_address(name))


def _machine_code(source: str) -> bytes:
    module = binding.parse_assembly(source)
    machine = _target_machine()
    builder = binding.create_pass_builder(machine, binding.create_pipeline_tuning_options(SPEED_LEVEL))
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


@cache
def _target() -> binding.Target:
    """Give this machine's kind, LLVM made ready for it."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    if os.name == "nt":  # where a process doesn't offer the C library's functions by itself
        library = ctypes.CDLL("ucrtbase")
        for name in LIBRARY:
            binding.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
    return binding.Target.from_default_triple()


def _cpu() -> tuple[str, str]:
    return binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()


def _target_machine() -> binding.TargetMachine:
    name, features = _cpu()
    relocation = "static" if _target().name.startswith("x86") else "default"
    return _target().create_target_machine(name, features, opt=SPEED_LEVEL, reloc=relocation, jit=True)
