"""pythonfmu's slave with values in flat lists: fast getters and setters, and a state that is exact.

The slaves' common part. Its text goes into each FMU's one module, and its class keeps pythonfmu's name, because
pythonfmu's library takes the first `class ...(Fmi2Slave):` of the module's file for the model.

No exception leaves a slave where it can be helped: after one, pythonfmu 0.7 ends the instance, and frees it a second
time when the host does, which kills the host later.
"""

from __future__ import annotations

import json
import math
from typing import Any

import pythonfmu
from pythonfmu import Boolean, Fmi2Causality, Fmi2Variability, Real
from pythonfmu.enums import Fmi2Status

Names = tuple[str, ...]


def tuples(value: Any) -> Any:
    """Give lists, as JSON reads them, as the tuples that they were."""
    return tuple(tuples(item) for item in value) if isinstance(value, list) else value


class Fmi2Slave(pythonfmu.Fmi2Slave):  # type: ignore[misc]
    """A slave with Real inputs, parameters, outputs and fixed parameters, then Boolean parameters and outputs.

    A value reference is a variable's position in that order. pythonfmu's own getters and setters cost more than a
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
        boolean_outputs: Names,
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
            (Boolean, boolean_outputs, "output", "discrete"),
        ):
            for name in names:
                variable = kind(name, causality=Fmi2Causality[causality], variability=Fmi2Variability[variability])
                self.register_variable(variable, nested=False)
        self._reals = [0.0] * (len(inputs) + len(parameters) + len(outputs) + len(fixed))
        self._flags = [False] * (len(boolean_parameters) + len(boolean_outputs))
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
        try:
            return [reals[vr] for vr in vrs]
        except IndexError:
            self.log(f"value references {vrs}: expected Real variables, below {len(reals)}", Fmi2Status.error)
            return [math.nan] * len(vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set inputs and parameters; what is set shows in the outputs after the next step."""
        reals = self._reals
        signals = self._signals
        for vr, value in zip(vrs, values):  # noqa: B905 (equally long by the standard; `strict` costs time)
            if vr < signals:
                reals[vr] = value
            elif vr < self._settable or (self._initialising and self._first_fixed <= vr < len(reals)):
                if reals[vr] != value:
                    reals[vr] = value
                    self._settled = False
            else:
                self._refuse_setting(vr)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Give Boolean variables."""
        if self._initialising:
            self._evaluate_start()
        first = len(self._reals)
        if not all(0 <= vr - first < len(self._flags) for vr in vrs):
            self.log(f"value references {vrs}: expected Boolean variables, from {first} on", Fmi2Status.error)
            return [False] * len(vrs)
        return [self._flags[vr - first] for vr in vrs]

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set Boolean parameters."""
        first = len(self._reals)
        for vr, value in zip(vrs, values, strict=True):
            if 0 <= vr - first < self._settable_flags:
                self._flags[vr - first] = bool(value)
                self._settled = False
            else:
                self._refuse_setting(vr)

    def _refuse_setting(self, vr: int) -> None:
        name = self.vars[vr].name if vr in self.vars else f"value reference {vr}"
        fixed = self._first_fixed <= vr < len(self._reals)
        reason = "fixed after initialization" if fixed else "no input or parameter of this type"
        self.log(f"{name} is {reason}; the value is ignored", Fmi2Status.error)

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
