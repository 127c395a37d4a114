"""An SSP run by other people's masters; run as a program, since their libraries stay in the process.

python foreign_ssp.py fmpy|ecos|libcosim SYSTEM.ssp FOLDER STEP_NS STEPS  ->  JSON on the last line: [[s, f, f], ...]
"""

import json
import sys
import zipfile

CLAMPS = ("clamp1", "clamp2")


def fmpy(ssp, folder, step_ns, steps):
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import read_ssv

    sets = {name: read_ssv(ssp, resource=f"resources/{name}.ssv") for name in CLAMPS}
    for name, parameters in sets.items():
        for parameter in parameters.parameters:
            parameter.name = f"{name}.{parameter.name}"
            if parameter.type == "Boolean":  # fmpy holds "false" for true
                parameter.value = float(parameter.value == "true")
    whole = sets["clamp1"]  # fmpy takes one set for the whole system
    whole.parameters.extend(sets["clamp2"].parameters)
    step = 1e-9 * step_ns
    result = simulate_ssp(ssp, stop_time=(steps - 0.5) * step, step_size=step, parameter_set=whole)
    columns = [result["pipe.clamp1.s"], *(result[f"{name}.flange.f"] for name in CLAMPS)]
    return list(zip(*(column.tolist() for column in columns), strict=True))


def ecos(ssp, folder, step_ns, steps):
    from ecospy import EcosSimulation

    simulation = EcosSimulation(step_size=1e-9 * step_ns, ssp_path=ssp)
    assert simulation.init(parameter_set="parameters")
    rows = []
    for _ in range(steps):
        simulation.step(1)
        forces = [simulation.get_real(f"{name}::flange.f") for name in CLAMPS]
        rows.append((simulation.get_real("pipe::clamp1.s"), *forces))
    simulation.terminate()
    return rows


def libcosim(ssp, folder, step_ns, steps):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
    execution = CosimExecution.from_ssp_file(folder, step_ns)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    indices = {info.name.decode(): info.index for info in execution.slave_infos()}
    references = {
        name: {variable.name.decode(): variable.reference for variable in execution.slave_variables(index)}
        for name, index in indices.items()
    }
    rows = []
    for _ in range(steps):
        execution.step(1)
        (s,) = observer.last_real_values(indices["pipe"], [references["pipe"]["clamp1.s"]])
        forces = [observer.last_real_values(indices[name], [references[name]["flange.f"]])[0] for name in CLAMPS]
        rows.append((s, *forces))
    return rows


if __name__ == "__main__":
    master, ssp_path, scratch, nanoseconds, count = sys.argv[1:]
    rows_made = {"fmpy": fmpy, "ecos": ecos, "libcosim": libcosim}[master](
        ssp_path, scratch, int(nanoseconds), int(count)
    )
    sys.stdout.write("\n" + json.dumps(rows_made) + "\n")
