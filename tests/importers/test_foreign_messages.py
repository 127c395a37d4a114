"""What FMUs of others log reaches the user as it is meant: a format with its arguments, a text untouched."""

import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest
from pythonfmu.builder import FmuBuilder

from pipeclamp_fmu.native.compiler import FLAGS, PLATFORMS, host_platform, system_compiler
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.fmus.participant import FmuParticipant, opened

REFUSED_STEP = 3
NAMES = ("flange.s", "flange.v", "flange.f")
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="spring" guid="{1}">
<CoSimulation modelIdentifier="spring"/>
<ModelVariables>
<ScalarVariable name="flange.s" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="flange.v" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="flange.f" valueReference="2" causality="output"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="3"/></Outputs></ModelStructure>
</fmiModelDescription>"""
TEXT = "100% sure, %d of %s and 5%"
SLAVE = f"""
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from pythonfmu.enums import Fmi2Status

class Percent(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = 0.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, time, h):
        self.log({TEXT!r}, Fmi2Status.warning)
        return True
"""


@pytest.fixture(scope="module")
def spring(tmp_path_factory):
    """A spring in C, which logs in its first step and refuses its fourth one."""
    compiler, platform = system_compiler(), host_platform()
    if compiler is None or platform not in ("linux64", "win64", "darwin64"):
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path, or no name for this platform in FMI 2.0")
    folder = tmp_path_factory.mktemp("spring")
    target = PLATFORMS[platform]
    library = folder / f"spring{target.ending}"
    headers, source = Path(fmpy.__file__).parent / "c-code", Path(__file__).with_name("foreign_spring.c")
    flags = [flag for flag in (*FLAGS, *target.flags) if flag != "-fvisibility=hidden"]
    command = [compiler, f"-DREFUSED_STEP={REFUSED_STEP}", f"-I{headers}", str(source), "-o", str(library), *flags]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(folder / "spring.fmu", "w") as packed:
        packed.writestr("modelDescription.xml", DESCRIPTION)
        packed.write(library, f"binaries/{platform}/{library.name}")
    return folder / "spring.fmu"


def test_a_format_of_c_gets_its_arguments_and_each_fmu_its_own_listener(spring):
    with opened([(spring, "one"), (spring, "other")]) as (one, other):
        one.initialise({})
        driven = FmuParticipant(one, NAMES[:2], NAMES[2:], ())
        driven.set_inputs((1e-3, 0.0))
        for step in range(REFUSED_STEP):
            driven.step(0.1 * step, 0.1)
        assert one.messages.warnings == ["loaded with 12.5 % of 400 N"]
        with pytest.raises(UserError, match=r"'one' refused the step .*; the FMU said: loaded with 12\.5 % of 400 N"):
            driven.step(0.1 * REFUSED_STEP, 0.1)
        assert other.messages.warnings == other.messages.errors == []


def test_a_text_of_a_python_fmu_is_no_format(tmp_path):
    """PythonFMU hands texts over as they are: as a format this one would read a text that isn't there, and crash."""
    (tmp_path / "percent.py").write_text(SLAVE, encoding="utf-8")
    path = FmuBuilder.build_FMU(tmp_path / "percent.py", dest=tmp_path, needsExecutionTool="false")
    with opened([(path, "percent")]) as (percent,):
        percent.initialise({})
        FmuParticipant(percent, (), ("x",), ()).step(0.0, 0.1)
        assert percent.messages.warnings == [TEXT]
