"""pythonfmu's slave with values in flat lists: fast getters and setters, and a state that is exact.

The slaves' common part. Its text goes into each FMU's one module, and its class keeps pythonfmu's name, because
pythonfmu's library takes the first `class ...(Fmi2Slave):` of the module's file for the model.

A step that can't be done is discarded. Other calls fail by an exception alone, of which pythonfmu makes the status
"fatal"; see `refused` for what keeps the host alive then.
"""

from __future__ import annotations

import ctypes
import json
from typing import Any, NoReturn

import pythonfmu
from pythonfmu import Boolean, Fmi2Causality, Fmi2Variability, Real
from pythonfmu.enums import Fmi2Status

Names = tuple[str, ...]


def tuples(value: Any) -> Any:
    """Give lists, as JSON reads them, as the tuples that they were."""
    return tuple(tuples(item) for item in value) if isinstance(value, list) else value


class Fmi2Slave(pythonfmu.Fmi2Slave):  # type: ignore[misc]
    """A slave with Real inputs, parameters, outputs and fixed parameters, then Boolean parameters and locals.

    Value references count from 1 in that order. pythonfmu's own getters and setters cost more than a
    clamp's law; its saved states hold registered variables only, and not exactly. A subclass keeps what else changes
    in attributes named in `KEPT`, as immutable values that JSON can hold.
    """

    KEPT: Names = ()

    def __init__(
        self,
        inputs: Names,
        parameters: Names,
        outputs: Names,
        boolean_parameters: Names,
        boolean_locals: Names,
        kwargs: dict[str, Any],
        fixed: Names = (),
    ) -> None:
        super().__init__(**kwargs)
        for kind, names, causality, variability in (
            (Real, inputs, "input", "continuous"),
            (Real, parameters, "parameter", "tunable"),
            (Real, outputs, "output", "continuous"),
            (Real, fixed, "parameter", "fixed"),
            (Boolean, boolean_parameters, "parameter", "tunable"),
            (Boolean, boolean_locals, "local", "discrete"),
        ):
            for reference, name in enumerate(names, start=len(self.vars) + 1):
                variable = kind(name, causality=Fmi2Causality[causality], variability=Fmi2Variability[variability])
                variable.value_reference = reference
                self.vars[reference] = variable
        self._reals = [0.0] * (len(inputs) + len(parameters) + len(outputs) + len(fixed))
        self._flags = [False] * (len(boolean_parameters) + len(boolean_locals))
        self._signals = len(inputs)  # these many, the first, may change with every step and unsettle nothing
        self._settable = len(inputs) + len(parameters)
        self._first_fixed = self._settable + len(outputs)
        self._settable_flags = len(boolean_parameters)
        self._settled = False  # no parameter has changed since the last step
        self._initialising = True
        self._lost = ""  # why no step can be done until a state of this model is set

    # --- Values

    def get_real(self, vrs: list[int]) -> list[float]:
        """Give Real variables."""
        if self._initialising:
            self._evaluate_start()
        reals = self._reals
        if min(vrs, default=1) < 1 or max(vrs, default=1) > len(reals):
            self.refused(f"value references {vrs}: expected Real variables, from 1 to {len(reals)}")
        return [reals[vr - 1] for vr in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set inputs and parameters, or none where one may not be set; outputs show it after the next step."""
        reals = self._reals
        if min(vrs, default=1) < 1 or max(vrs, default=1) > self._signals:
            for vr in vrs:
                if not (0 < vr <= self._settable or (self._initialising and self._first_fixed < vr <= len(reals))):
                    self._refuse_setting(vr)
            self._settled = self._settled and all(
                vr <= self._signals or reals[vr - 1] == value for vr, value in zip(vrs, values, strict=True)
            )
        for vr, value in zip(vrs, values):  # noqa: B905 (equally long by the standard; `strict` costs time)
            reals[vr - 1] = value

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Give Boolean variables."""
        if self._initialising:
            self._evaluate_start()
        first = len(self._reals) + 1
        if not all(0 <= vr - first < len(self._flags) for vr in vrs):
            self.refused(f"value references {vrs}: expected Boolean variables, from {first} on")
        return [self._flags[vr - first] for vr in vrs]

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set Boolean parameters, or none where one may not be set."""
        first = len(self._reals) + 1
        for vr in vrs:
            if not 0 <= vr - first < self._settable_flags:
                self._refuse_setting(vr)
        for vr, value in zip(vrs, values, strict=True):
            self._flags[vr - first] = bool(value)
            self._settled = False

    def _refuse_setting(self, vr: int) -> NoReturn:
        name = self.vars[vr].name if vr in self.vars else f"value reference {vr}"
        fixed = self._first_fixed < vr <= len(self._reals)
        reason = "fixed after initialization" if fixed else "no input or parameter of this type"
        self.refused(f"{name} is {reason}; the value is ignored")

    def refused(self, reason: str) -> NoReturn:
        """Fail a call that has changed nothing.

        pythonfmu 0.7 then lets go of the instance, its class and its messages, and does so again when the host frees
        the instance: they are held once more, and the host may also go on.
        """
        for held in (self, type(self), self._get_log_queue()):
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(held))
        raise ValueError(reason)

    # --- Initialisation

    def _evaluate_start(self) -> None:
        """Evaluate the outputs at the inputs and parameters as they stand before the first step."""
        raise NotImplementedError

    def exit_initialization_mode(self) -> None:
        """Take the inputs and parameters as the start."""
        self._evaluate_start()
        self._initialising = False

    def _refuse(self, current_time: float, step_size: float, reason: str) -> bool:
        """Say why a step can't be done; a subclass hands this to the host as a discarded step."""
        self.log(f"step from {current_time:g} s by {step_size:g} s discarded: {reason}", Fmi2Status.error)
        return False

    # --- State

    def _get_fmu_state(self) -> tuple[Any, ...]:
        return (
            type(self).__name__,
            tuple(self._reals),
            tuple(self._flags),
            self._settled,
            self._initialising,
            *[getattr(self, name) for name in self.KEPT],
        )

    def _set_fmu_state(self, state: Any) -> None:
        if not (isinstance(state, tuple) and state[:1] == (type(self).__name__,)):
            self._lost = f"the state that was set is not one of {type(self).__name__}"
            self._settled = False
            self.log(f"{self._lost}; steps are discarded until one is", Fmi2Status.error)
            return
        _, reals, flags, self._settled, self._initialising, *kept = state
        self._reals, self._flags = list(reals), list(flags)
        for name, value in zip(self.KEPT, kept, strict=True):
            setattr(self, name, value)
        self._lost = ""

    @staticmethod
    def _fmu_state_to_bytes(state: tuple[Any, ...]) -> bytes:
        return json.dumps(state).encode("utf-8")

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> Any:
        try:
            return tuples(json.loads(state.decode("utf-8")))
        except ValueError:
            return None  # refused when it is set
