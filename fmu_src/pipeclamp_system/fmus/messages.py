"""What FMUs log, each to a listener of its own, with their messages' arguments put in."""

from __future__ import annotations

from ctypes import byref
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakValueDictionary

from fmpy import calloc, free
from fmpy.fmi1 import printLogMessage
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Warning,
)

try:
    from fmpy.logging import addLoggerProxy
except (ImportError, OSError):  # on platforms that fmpy has no binary for, formats are shown as they are
    addLoggerProxy = None

PYTHON_FMU = "PythonFMU"
"""Tool whose FMUs log texts that are no formats: a percent sign in one would read arguments that aren't there."""


@dataclass
class Messages:
    """What an FMU has logged: warnings, and worse."""

    warnings: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def __call__(self, environment: int | None, instance: bytes, status: int, category: bytes, message: bytes) -> None:
        """Take a message, as FMI's logger."""
        if status >= fmi2Warning:
            text = message.decode("utf-8", "replace").strip()
            (self.warnings if status == fmi2Warning else self.errors).append(text)


_listeners: WeakValueDictionary[int | None, Messages] = WeakValueDictionary()
"""Of the FMUs that are loaded, by the environment that each hands back."""


def _hand_over(environment: int | None, instance: bytes, status: int, category: bytes, message: bytes) -> None:
    """Give a message to its FMU's listener; those of FMUs that others drive by fmpy are printed, as fmpy does."""
    listener = _listeners.get(environment, printLogMessage)
    listener(environment, instance, status, category, message)


_LOGGER = fmi2CallbackLoggerTYPE(_hand_over)
"""For all FMUs, and never freed: fmpy's proxy has one logger for the whole process, and keeps it."""


def callbacks_for(messages: Messages, tool: str | None) -> Any:
    """Give the callbacks of an FMU that `tool` made, whose messages go to a listener; both must outlive the FMU."""
    callbacks = fmi2CallbackFunctions()
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    if addLoggerProxy is None or PYTHON_FMU in (tool or ""):
        callbacks.logger = fmi2CallbackLoggerTYPE(messages)
    else:
        callbacks.logger = _LOGGER
        callbacks.componentEnvironment = id(messages)
        _listeners[id(messages)] = messages
        addLoggerProxy(byref(callbacks))
    return callbacks
