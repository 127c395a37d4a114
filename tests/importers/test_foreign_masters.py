"""Pipe and clamp, Python and native, coupled in Ecos and in libcosim give what our own parallel scheme gives."""

import foreign_masters
import numpy as np
import pytest
from masters import assert_the_same, told_by

from pipeclamp_system.coupling.march import Explicit, System, march
from pipeclamp_system.fmus.participant import FmuParticipant, opened

STEP_NS, STEPS = 20_000, 3000


@pytest.fixture(scope="module", params=["python", "native", "further"])
def clamp_fmu(request, fmus):
    """Give the path of a clamp of each kind, and of one that follows density, a further condition and load cycles."""
    if request.param == "native":
        return request.getfixturevalue("native_fmus")[2]
    return fmus["memory" if request.param == "python" else "further"]


@pytest.fixture(scope="module")
def own(fmus, clamp_fmu):
    """Our parallel scheme's displacement and force, (STEPS, 2)."""
    with opened([(fmus["pipe"], "pipe"), (clamp_fmu, "clamp")]) as (pipe, clamp):
        pipe.initialise({})
        clamp.initialise(foreign_masters.START)
        system = System(
            FmuParticipant(pipe, ["base.a", "clamp1.f"], ["clamp1.s", "clamp1.v"], []),
            (FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], []),),
            foreign_masters.excitation,
        )
        points = list(march(system, Explicit(system, sequential=False), 1e-9 * STEP_NS, STEPS))
    return np.array([(point.displacement[0], point.force[0]) for point in points[1:]])


@pytest.mark.parametrize("master", ["ecos", "libcosim"])
def test_it_gives_what_our_parallel_scheme_gives(fmus, clamp_fmu, own, master):
    assert_the_same(told_by(master, foreign_masters, fmus["pipe"], clamp_fmu, STEP_NS, STEPS), own)
