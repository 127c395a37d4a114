"""Functions in LLVM's language as machine code of this computer: importing this module loads LLVM."""

from __future__ import annotations

import base64
import ctypes
import os
from collections.abc import Callable
from functools import cache

from llvmlite import binding

from pipeclamp_models.base.kept import kept

SPEED_LEVEL = 2
"""How hard LLVM tries: beyond that it takes longer than it gains."""
LARGE = 400_000
"""Characters of a module beyond which LLVM takes instructions as they come: to choose and to order the best it takes
longer than in proportion, several seconds for some fourteen states that need each other, and gains a third at most."""
LIBRARY = frozenset({"exp", "expm1", "log", "pow", "sin", "cos", "tan", "atan", "tanh"})
"""Functions of the C library that machine code may call."""

_ENGINES: list[binding.ExecutionEngine] = []
"""What holds machine code: it lives as long as the process, as the functions do."""


@cache
def machine_function(name: str, source: str) -> Callable[..., None]:
    """Give a function of a module in LLVM's language; its machine code is kept from one call to the next.

    Args:
        name: of the function.
        source: the module; the function takes what `marches.MarchWriter` says.
    """
    described = f"{_target().triple} {_cpu()}"
    encoded = kept(
        f"machine code {binding.llvm_version_info} {described} {source}",
        lambda: base64.b64encode(_machine_code(source)).decode(),
    )
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), _target_machine(SPEED_LEVEL))
    _ENGINES.append(engine)
    engine.add_object_file(binding.ObjectFileRef.from_data(base64.b64decode(encoded)))
    engine.finalize_object()
    takes = [ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 4]
    return ctypes.CFUNCTYPE(None, *takes)(engine.get_function_address(name))


def _machine_code(source: str) -> bytes:
    module = binding.parse_assembly(source)
    machine = _target_machine(SPEED_LEVEL if len(source) < LARGE else 0)
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


def _target_machine(level: int) -> binding.TargetMachine:
    name, features = _cpu()
    relocation = "static" if _target().name.startswith("x86") else "default"
    return _target().create_target_machine(name, features, opt=level, reloc=relocation, jit=True)
