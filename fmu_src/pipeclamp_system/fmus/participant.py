"""FMUs as participants of a coupling, driven by fmpy."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import byref
from math import nan
from pathlib import Path
from typing import Any

from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2Boolean, fmi2FMUstate, fmi2Real, fmi2True, fmi2ValueReference

from pipeclamp_models.base.archive import unpack_archive
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.fmus.library import refuse_cut_libraries, refuse_cut_program
from pipeclamp_system.fmus.messages import PYTHON_FMU, Messages, callbacks_for
from pipeclamp_system.fmus.unpacking import unpacking_folder
from pipeclamp_system.fmus.variables import EXPECTED, find_variables, read_model_description, renamed, variables_of


class LoadedFmu:
    """An FMU of FMI 2.0 co-simulation that is loaded and instantiated."""

    def __init__(self, path: Path, instance: str, folder: Path) -> None:
        """Unpack an FMU into an empty folder and instantiate it.

        Raises:
            UserError: the file is no FMU that can be co-simulated here.
        """
        self.path, self.instance = path, instance
        self.messages = Messages()
        description = read_model_description(path)
        unpack_archive(path, folder, EXPECTED)
        refuse_cut_libraries(folder, path)
        if PYTHON_FMU in (description.generationTool or ""):
            refuse_cut_program(folder, path)
        self.variables = variables_of(description)
        self.can_roll_back = bool(description.coSimulation.canGetAndSetFMUstate)
        self.has_derivatives = bool(description.coSimulation.providesDirectionalDerivative)
        self._callbacks = callbacks_for(self.messages, description.generationTool)
        try:
            self.slave: Any = FMU2Slave(
                guid=description.guid,
                unzipDirectory=str(folder),
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName=instance,
            )
            self.slave.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:
            raise UserError(f"{path}: this FMU can't be instantiated here ({error}){self.said()}") from error

    def said(self) -> str:
        """Give the FMU's last error messages, to be put behind one of ours."""
        recent = "; ".join(self.messages.errors[-3:])
        return f"; the FMU said: {recent}" if recent else ""

    def references(self, names: Sequence[str]) -> list[int]:
        """Give the value references of variables.

        Raises:
            UserError: the FMU has no such variable.
        """
        return [variable.reference for variable in find_variables(self.variables, names, self.path)]

    def rename(self, names: Mapping[str, str]) -> None:
        """Let variables be known by our names: ours to the FMU's.

        Raises:
            UserError: the FMU has no such variable.
        """
        self.variables = renamed(self.variables, names, self.path)

    def set_parameters(self, values: Mapping[str, float | bool]) -> None:
        """Set parameters, and inputs before the start."""
        for name, value in values.items():
            (reference,) = self.references([name])
            if self.variables[name].kind == "Boolean":
                self.slave.setBoolean([reference], [bool(value)])
            else:
                self.slave.setReal([reference], [float(value)])

    def initialise(self, values: Mapping[str, float | bool]) -> None:
        """Set parameters and start inputs, and initialise at time 0.

        Raises:
            UserError: the FMU refuses.
        """
        try:
            self.slave.setupExperiment(startTime=0.0)
            self.set_parameters(values)
            self.slave.enterInitializationMode()
            self.slave.exitInitializationMode()
        except FMICallException as error:
            raise UserError(f"{self.path}: the FMU can't start ({error}){self.said()}") from error
        if self.messages.errors:
            raise UserError(f"{self.path}: the FMU can't start{self.said()}")

    def close(self) -> None:
        """Free the instance."""
        self.slave.freeInstance()


@contextmanager
def opened(fmus: Sequence[tuple[Path, str]]) -> Iterator[list[LoadedFmu]]:
    """Load FMUs, each given with its instance's name, and free them at the end.

    Raises:
        UserError: one of them can't be loaded, or fails in a call while they are open.
    """
    folder = unpacking_folder([path for path, _ in fmus])
    search_path = list(sys.path)
    loaded: list[LoadedFmu] = []
    try:
        for index, (path, instance) in enumerate(fmus):
            loaded.append(LoadedFmu(path, instance, folder / str(index)))
        yield loaded
    except FMICallException as error:  # of others than start and step, which say more of themselves
        names = ", ".join(str(fmu.path) for fmu in loaded)
        said = "".join(fmu.said() for fmu in loaded)
        raise UserError(
            f"{names}: one of these FMUs failed ({error}){said}; expected FMUs that answer each call of FMI 2.0"
        ) from error
    finally:
        for fmu in loaded:
            fmu.close()
        sys.path[:] = search_path  # a Python FMU leaves its folder there
        shutil.rmtree(folder, ignore_errors=True)  # Windows keeps a library locked that is still mapped


class FmuParticipant:
    """A loaded FMU as a participant of a coupling: its coupled inputs and outputs, in a fixed order."""

    def __init__(
        self,
        fmu: LoadedFmu,
        inputs: Sequence[str],
        outputs: Sequence[str],
        watched: Sequence[str],
        flags: Sequence[str] = (),
    ) -> None:
        """Choose the variables that couple, and the Real and Boolean ones that are watched where the FMU has them."""
        self._fmu = fmu
        self._slave = fmu.slave
        self._component = fmu.slave.component
        self._inputs = (fmi2ValueReference * len(inputs))(*fmu.references(inputs))
        self._input_values = (fmi2Real * len(inputs))()
        self._outputs = (fmi2ValueReference * len(outputs))(*fmu.references(outputs))
        self._output_values = (fmi2Real * len(outputs))()
        self.watched_names = tuple(watched)
        self._known = [name in fmu.variables for name in watched]
        watched = [name for name, known in zip(watched, self._known, strict=True) if known]
        flags = [name for name in flags if name in fmu.variables]
        self._watched = (fmi2ValueReference * len(watched))(*fmu.references(watched))
        self._watched_values = (fmi2Real * len(watched))()
        self._flags = (fmi2ValueReference * len(flags))(*fmu.references(flags))
        self._flag_values = (fmi2Boolean * len(flags))()
        self._state = fmi2FMUstate()

    def set_inputs(self, values: Sequence[float]) -> None:
        """Set all coupled inputs."""
        self._input_values[:] = values
        self._slave.fmi2SetReal(self._component, self._inputs, len(self._inputs), self._input_values)

    def step(self, time: float, h: float) -> None:
        """Step from `time` to `time + h`.

        Raises:
            UserError: the FMU refuses the step.
        """
        try:
            self._slave.fmi2DoStep(self._component, time, h, fmi2True)
        except FMICallException as error:
            raise UserError(
                f"t = {time:.6g} s: the FMU of {self._fmu.instance!r} refused the step ({error}){self._fmu.said()}"
            ) from error

    def outputs(self) -> list[float]:
        """Give all coupled outputs."""
        self._slave.fmi2GetReal(self._component, self._outputs, len(self._outputs), self._output_values)
        return self._output_values[:]  # type: ignore[no-any-return]

    def slopes(self) -> tuple[float, float] | None:
        """Give the first output's derivatives by the first two inputs, where the FMU provides them."""
        if not self._fmu.has_derivatives:
            return None
        by = [
            self._slave.getDirectionalDerivative([self._outputs[0]], [reference], [1.0])[0]
            for reference in self._inputs[:2]
        ]
        return by[0], by[1]

    def watched(self) -> list[float]:
        """Give the watched outputs, in the order of `watched_names`; NaN for those that the FMU doesn't have."""
        self._slave.fmi2GetReal(self._component, self._watched, len(self._watched), self._watched_values)
        values = iter(self._watched_values)
        return [next(values) if known else nan for known in self._known]

    def flags(self) -> list[bool]:
        """Give the watched Boolean outputs."""
        self._slave.fmi2GetBoolean(self._component, self._flags, len(self._flags), self._flag_values)
        return [bool(value) for value in self._flag_values]

    def save(self) -> None:
        """Keep the present state, in the place of the one before."""
        self.release()  # pythonfmu doesn't reuse the memory of a state that it is handed
        self._slave.fmi2GetFMUstate(self._component, byref(self._state))

    def restore(self) -> None:
        """Go back to the state that was kept."""
        self._slave.fmi2SetFMUstate(self._component, self._state)

    def release(self) -> None:
        """Free the state that was kept."""
        if self._state:
            self._slave.fmi2FreeFMUstate(self._component, byref(self._state))
            self._state = fmi2FMUstate()


class HeldInputs:
    """A participant whose inputs are held over a step, given their mean, where they are meant as those at its end.

    The motion then errs by O(h^2), as with inputs that are linear over the step.
    """

    def __init__(self, participant: FmuParticipant, start: Sequence[float]) -> None:
        """Take a participant and its inputs at time 0."""
        self._participant = participant
        self._saved = self._before = self._last = tuple(start)

    def set_inputs(self, values: Sequence[float]) -> None:
        """Set the inputs at the step's end."""
        self._last = tuple(values)
        self._participant.set_inputs([(a + b) / 2 for a, b in zip(self._before, values, strict=True)])

    def step(self, time: float, h: float) -> None:
        """Step from `time` to `time + h`."""
        self._participant.step(time, h)
        self._before = self._last

    def outputs(self) -> list[float]:
        """Give all coupled outputs."""
        return self._participant.outputs()

    def slopes(self) -> tuple[float, float] | None:
        """Give none."""
        return None

    def save(self) -> None:
        """Keep the present state; the last inputs are those that it begins with."""
        self._saved = self._before
        self._participant.save()

    def restore(self) -> None:
        """Go back to the state that was kept."""
        self._before = self._last = self._saved
        self._participant.restore()
