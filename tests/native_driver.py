"""One instance of a native clamp FMU, by variable names, the same way in FMI 2.0 and 3.0, both interfaces."""

import fmpy
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

INTERFACES = [(fmi, kind) for fmi in (2, 3) for kind in ("CoSimulation", "ModelExchange")]


class NativeDriver:
    """Steps a clamp from point to point; in model exchange each point ends an integrator step."""

    def __init__(self, path, folder, kind, start):
        description = fmpy.read_model_description(str(path))
        fmpy.extract(str(path), unzipdir=str(folder))
        self.description = description
        self.fmi = int(description.fmiVersion[0])
        self.exchanged = kind == "ModelExchange"
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.booleans = {variable.name for variable in description.modelVariables if variable.type == "Boolean"}
        classes = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model)}
        self.fmu = classes[self.fmi][self.exchanged](
            guid=description.guid or description.instantiationToken,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="clamp",
        )
        self.fmu.instantiate()
        self.start(start)

    def start(self, values):
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=0.0)
        self.set(values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if self.exchanged:
            self.fmu.newDiscreteStates() if self.fmi == 2 else self.fmu.updateDiscreteStates()
            self.fmu.enterContinuousTimeMode()
        self.time = 0.0

    def set(self, values):
        for name, value in values.items():
            if name in self.booleans:
                self.fmu.setBoolean([self.references[name]], [value])
            else:
                (self.fmu.setReal if self.fmi == 2 else self.fmu.setFloat64)([self.references[name]], [value])

    def get(self, *names):
        references = [self.references[name] for name in names]
        return self.fmu.getReal(references) if self.fmi == 2 else self.fmu.getFloat64(references)

    def flag(self, name):
        return bool(self.fmu.getBoolean([self.references[name]])[0])

    def place(self, time, s, v):
        """In model exchange, give the clamp a time and a motion, for evaluation."""
        self.fmu.setTime(time)
        self.set({"flange.s": s, "flange.v": v})

    def step(self, h, s, v, **further):
        self.time += h
        if self.exchanged:
            self.set(further)
            self.place(self.time, s, v)
            self.fmu.completedIntegratorStep()
        else:
            self.set({"flange.s": s, "flange.v": v, **further})
            self.fmu.doStep(self.time - h, h)

    def jacobian(self, unknowns, knowns):
        """Give the derivatives, a row for each unknown, one directional derivative for each known."""
        rows, columns = ([self.references[name] for name in names] for names in (unknowns, knowns))
        by_known = [self.fmu.getDirectionalDerivative(rows, [column], [1.0]) for column in columns]
        return [list(row) for row in zip(*by_known, strict=True)]

    def free(self):
        self.fmu.freeInstance()
