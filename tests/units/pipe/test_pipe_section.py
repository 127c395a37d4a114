"""The described section as a beam: what temperature, pressure, anchors and insulation do to it."""

from __future__ import annotations

from math import pi

import pytest

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.description import PipeDescription, parse_pipe
from pipeclamp_models.pipe.materials import MATERIALS, find_fluid, find_material
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.pipe.section import beam_of, section_of

PIPE = """
name = "line"
[pipe]
outer_diameter_mm = 114.3
wall_mm = 3.6
length_m = 10.0
material = "carbon steel"
fluid = "water"
temperature_C = {temperature}
{pipe}
[ends]
left = "{left}"
right = "pinned"
{more}
[damping]
ratio = 0.01
[modes]
up_to_Hz = 50.0
"""


def described(more: str = "", temperature: float = 20.0, pipe: str = "", left: str = "pinned") -> PipeDescription:
    return parse_pipe(PIPE.format(more=more, temperature=temperature, pipe=pipe, left=left))


def test_insulation_adds_its_ring() -> None:
    bare = beam_of(described())
    clad = beam_of(described(pipe="insulation = { thickness_mm = 50.0, density_kg_m3 = 100.0 }"))
    ring = pi / 4 * (0.2143**2 - 0.1143**2)
    assert clad.mass_per_length - bare.mass_per_length == pytest.approx(100.0 * ring)
    assert clad.bending_stiffness == bare.bending_stiffness


def test_a_hot_wall_keeps_its_mass() -> None:
    """A metre of the cold pipe is 1 + strain metres of the hot one."""
    cold, hot = section_of(described()), section_of(described(temperature=300.0))
    grown = 1 + hot.strain
    assert hot.strain == pytest.approx(13.3e-6 * 280)
    assert hot.density * hot.wall_area * grown == pytest.approx(cold.density * cold.wall_area)


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_gets_softer_and_lighter_when_hot(name: str) -> None:
    material = find_material(name)
    moduli = [material.youngs_modulus(t) for t in (20.0, 150.0, 300.0, 450.0)]
    assert moduli == sorted(moduli, reverse=True)
    assert moduli[-1] < moduli[0]
    assert material.density(300.0) < material.density(20.0) == material.cold_density


def test_water_thins_along_its_table() -> None:
    water = find_fluid("water")
    assert water.density(20.0) == 998.2
    assert water.density(275.0) == pytest.approx((799.1 + 712.1) / 2)


def test_rigid_anchors_carry_the_whole_expansion() -> None:
    section = section_of(described(temperature=60.0))
    pipe = beam_of(described(temperature=60.0, more='[axial]\nanchors = "rigid"'))
    assert pipe.compression == pytest.approx(section.modulus * section.wall_area * section.strain)
    assert beam_of(described(temperature=60.0)).compression == 0.0
    installed = described(temperature=60.0, more='[axial]\nanchors = "rigid"\ninstalled_at_C = 60.0')
    assert beam_of(installed).compression == 0.0


def test_anchors_as_stiff_as_the_pipe_carry_half() -> None:
    section = section_of(described(temperature=60.0))
    own = section.modulus * section.wall_area / 10.0 / 1e3
    rigid = beam_of(described(temperature=60.0, more='[axial]\nanchors = "rigid"')).compression
    half = beam_of(described(temperature=60.0, more=f"[axial]\nanchors = {own!r}")).compression
    assert half == pytest.approx(rigid / 2)


def test_pressure_pushes_unless_the_wall_takes_its_thrust() -> None:
    on_bore = 40e5 * section_of(described()).bore_area
    flow = "[flow]\npressure_bar = 40.0\n[axial]\n"
    assert beam_of(described(flow)).compression == pytest.approx(on_bore)
    assert beam_of(described(flow + 'end_thrust = "pipe"')).compression == pytest.approx(0.0, abs=1e-9)
    anchored = flow + 'anchors = "rigid"\n'
    rigid = [beam_of(described(anchored + text)).compression for text in ("", 'end_thrust = "pipe"')]
    assert rigid == pytest.approx([on_bore * (1 - 2 * 0.3)] * 2)  # Paidoussis' p A (1 - 2 nu)


def test_flow_between_elbows_that_can_move_does_not_press() -> None:
    flow = "[flow]\nvelocity_m_s = 8.0\n[axial]\n"
    elbows = beam_of(described(flow + 'end_thrust = "pipe"'))
    assert elbows.compression == pytest.approx(-elbows.fluid_mass * 8.0**2)
    assert beam_of(described(flow)).compression == 0.0


def test_an_anchored_pipe_that_buckles_says_so() -> None:
    reduced = reduce(described(temperature=150.0, more='[axial]\nanchors = "rigid"'))
    euler = pi**2 * reduced.bending_stiffness / 10.0**2
    assert reduced.buckling_load == pytest.approx(euler, rel=1e-4)
    assert reduced.compression > euler
    assert reduced.stability.kind == "divergence"
    summary = reduced.summary()
    assert "UNSTABLE" in summary
    assert f"{reduced.compression / euler:.0%} of its buckling load" in summary


def test_a_hot_fluid_without_a_table_is_said() -> None:
    text = PIPE.format(more="", temperature=200.0, pipe="", left="pinned")
    hot = parse_pipe(text.replace('"water"', '"hydraulic oil"'))
    assert "hydraulic oil is taken with its density at 20 °C" in reduce(hot).summary()
    assert "density at" not in reduce(described(temperature=200.0)).summary()


@pytest.mark.parametrize(("temperature", "end"), [(600.0, "at 200 °C, where its table ends"), (-150.0, "at 25 °C")])
def test_a_material_beyond_its_table_is_said(temperature: float, end: str) -> None:
    def aluminium(temperature: float) -> str:
        text = PIPE.format(more="", temperature=temperature, pipe="", left="pinned").replace('"water"', '"empty"')
        return reduce(parse_pipe(text.replace('"carbon steel"', '"aluminium 6061"'))).summary()

    assert f"aluminium 6061 is taken with its stiffness and expansion {end}" in aluminium(temperature)
    assert "aluminium 6061" not in aluminium(20.0)


@pytest.mark.parametrize("fluid", ['"empty"', "{ density_kg_m3 = 0.0 }"])
def test_a_flow_of_nothing_is_refused(fluid: str) -> None:
    text = PIPE.format(more="[flow]\nvelocity_m_s = 2.0", temperature=20.0, pipe="", left="pinned")
    with pytest.raises(UserError, match=r"flow\.velocity_m_s = 2 needs a fluid.*expected for example"):
        parse_pipe(text.replace('"water"', fluid))


def test_a_flow_in_a_solid_bar_is_refused() -> None:
    text = PIPE.format(more="[flow]\nvelocity_m_s = 2.0", temperature=20.0, pipe="", left="pinned")
    with pytest.raises(UserError, match=r"needs a bore"):
        parse_pipe(text.replace("wall_mm = 3.6", "wall_mm = 57.15"))


def test_a_free_inlet_is_refused() -> None:
    with pytest.raises(UserError, match=r"flow\.velocity_m_s.*ends\.left is 'free'"):
        described("[flow]\nvelocity_m_s = 1.0", left="free")
