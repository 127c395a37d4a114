"""A pipe and a clamp coupled by other people's masters; run as a program, since their libraries stay in the process.

python foreign_masters.py ecos|libcosim PIPE.fmu CLAMP.fmu STEP_NS STEPS  ->  JSON on the last line: [[s, f], ...]
"""

import json
import sys
from math import pi, sin

START = {"A": 5e-4, "f": 3.0, "T": 350.0}


def excitation(time):
    return 2.0 * sin(2 * pi * 10 * time)


def ecos(pipe, clamp, step_ns, steps):
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    structure.add_model("pipe", pipe)
    structure.add_model("clamp", clamp)
    structure.make_real_connection("pipe::clamp1.s", "clamp::flange.s")
    structure.make_real_connection("pipe::clamp1.v", "clamp::flange.v")
    structure.make_real_connection("clamp::flange.f", "pipe::clamp1.f")
    structure.add_parameter_set("start", {f"clamp::{name}": value for name, value in START.items()})
    simulation = EcosSimulation(step_size=1e-9 * step_ns, structure=structure)
    assert simulation.init(parameter_set="start")
    rows = []
    for n in range(steps):
        simulation.set_real("pipe::base.a", excitation(1e-9 * step_ns * n))
        simulation.step(1)
        rows.append((simulation.get_real("pipe::clamp1.s"), simulation.get_real("clamp::flange.f")))
    simulation.terminate()
    return rows


def libcosim(pipe, clamp, step_ns, steps):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=step_ns)
    indices = [execution.add_local_slave(CosimLocalSlave(path, name)) for path, name in ((pipe, "p"), (clamp, "c"))]
    p, c = ({v.name.decode(): v.reference for v in execution.slave_variables(index)} for index in indices)
    pipe_index, clamp_index = indices
    for name, value in START.items():
        execution.real_initial_value(clamp_index, c[name], value)
    execution.connect_real_variables(pipe_index, p["clamp1.s"], clamp_index, c["flange.s"])
    execution.connect_real_variables(pipe_index, p["clamp1.v"], clamp_index, c["flange.v"])
    execution.connect_real_variables(clamp_index, c["flange.f"], pipe_index, p["clamp1.f"])
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    rows = []
    for n in range(steps):
        manipulator.slave_real_values(pipe_index, [p["base.a"]], [excitation(1e-9 * step_ns * n)])
        execution.step(1)
        (s,), (f,) = (
            observer.last_real_values(pipe_index, [p["clamp1.s"]]),
            observer.last_real_values(clamp_index, [c["flange.f"]]),
        )
        rows.append((s, f))
    return rows


if __name__ == "__main__":
    master, pipe_path, clamp_path, step, count = sys.argv[1:]
    result = {"ecos": ecos, "libcosim": libcosim}[master](pipe_path, clamp_path, int(step), int(count))
    sys.stdout.write("\n" + json.dumps(result) + "\n")
