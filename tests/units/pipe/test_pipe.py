"""Reduction of a described pipe: what is kept, what it costs, what is refused."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.description import PipeDescription, parse_pipe, read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.pipe.truncation import FullResponse, ModalModel

PIPE = """
name = "bench"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 6.0
material = "316L"
fluid = "water"
[ends]
left = "pinned"
right = { stiffness_N_mm = 200.0 }
[[supports]]
position_m = 4.0
condition = "pinned"
[[clamps]]
name = "clamp1"
position_m = 2.0
[[clamps]]
name = "clamp2"
position_m = 5.0
[[probes]]
name = "middle"
position_m = 3.0
[damping]
ratio = 0.01
[modes]
up_to_Hz = 300
"""


def test_residual_modes_make_the_static_compliance_exact() -> None:
    errors = reduce(parse_pipe(PIPE)).errors
    assert errors.static_truncated > 1e-3  # the left-out modes do carry some
    assert errors.static < 1e-9
    assert errors.response < 0.01


def test_static_deflection_under_a_force_is_the_beam_formula() -> None:
    text = PIPE.replace("{ stiffness_N_mm = 200.0 }", '"pinned"').replace('condition = "pinned"', 'condition = "free"')
    reduced = reduce(parse_pipe(text + '[excitation]\nkind = "force"\nposition_m = 3.0\n'))
    omega, participation = np.array(reduced.omega), np.array(reduced.excitation_participation)
    deflection = float(np.sum(np.array(reduced.probe_shapes[0]) * participation / omega**2))
    assert deflection == pytest.approx(6.0**3 / (48 * reduced.bending_stiffness), rel=1e-9)


def test_base_excitation_moves_all_mass() -> None:
    """A clamped pipe's participations, squared, sum to (nearly) its mass."""
    text = PIPE.replace('left = "pinned"', 'left = "clamped"').replace("{ stiffness_N_mm = 200.0 }", '"free"')
    text = text.replace('condition = "pinned"', 'condition = "free"').replace("up_to_Hz = 300", "up_to_Hz = 2500")
    reduced = reduce(parse_pipe(text))
    effective = sum(value**2 for value in reduced.excitation_participation)
    assert effective == pytest.approx(reduced.mass, rel=0.03)
    assert effective < reduced.mass


def test_a_rigid_end_is_the_limit_of_a_stiff_one_under_base_excitation() -> None:
    """What a held degree of freedom carries of its neighbours' mass is shaken too."""
    rigid = PIPE.replace("{ stiffness_N_mm = 200.0 }", '"pinned"')
    responses = []
    for text in (rigid, rigid.replace('right = "pinned"', "right = { stiffness_N_mm = 1e9 }")):
        reduced = reduce(parse_pipe(text))
        gain = np.array(reduced.probe_shapes[0]) / np.square(reduced.omega)
        responses.append(float(gain @ np.array(reduced.excitation_participation)))
    assert responses[0] == pytest.approx(responses[1], rel=1e-5)


def test_mass_is_steel_and_water() -> None:
    steel = 8030 * pi / 4 * (0.0603**2 - 0.05248**2) * 6.0
    water = 998.2 * pi / 4 * 0.05248**2 * 6.0
    assert reduce(parse_pipe(PIPE)).mass == pytest.approx(steel + water)


def test_a_hot_pipe_is_softer() -> None:
    cold = reduce(parse_pipe(PIPE))
    hot = reduce(parse_pipe(PIPE.replace("length_m = 6.0", "length_m = 6.0\ntemperature_C = 300")))
    grown = 1 + 17.7e-6 * 280
    assert hot.bending_stiffness / cold.bending_stiffness == pytest.approx(176 / 195 * grown**4)
    assert hot.mass < cold.mass  # the wall keeps its mass over a longer pipe, the water thins


def test_rayleigh_damping_is_proportional() -> None:
    text = PIPE.replace("ratio = 0.01", "rayleigh_alpha_1_s = 0.5\nrayleigh_beta_s = 1e-5")
    reduced = reduce(parse_pipe(text))
    assert reduced.damping == pytest.approx([0.5 + 1e-5 * omega**2 for omega in reduced.omega])
    assert reduced.zeta[0] == pytest.approx(reduced.damping[0] / (2 * reduced.omega[0]))


def test_a_free_pipe_keeps_its_rigid_body_modes() -> None:
    text = PIPE.replace('left = "pinned"', 'left = "free"').replace("{ stiffness_N_mm = 200.0 }", '"free"')
    reduced = reduce(parse_pipe(text.replace('condition = "pinned"', 'condition = "free"')))
    assert reduced.omega[:2] == (0.0, 0.0)
    assert reduced.omega[2] > 1.0
    assert reduced.errors.response < 0.01


def test_more_modes_are_kept_until_the_stated_error_is_met() -> None:
    kept = []
    for error in (0.1, 1e-3, 1e-5):
        reduced = reduce(parse_pipe(PIPE.replace("up_to_Hz = 300", f"up_to_Hz = 300\nerror = {error!r}")))
        assert max(reduced.errors.response, reduced.errors.static) <= error
        kept.append(reduced.kept)
    assert kept[0] < kept[1] < kept[2]


def test_a_stated_error_that_is_not_reached_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeclamp_models.pipe.truncation.MOST_MODES", 2)
    reduced = reduce(parse_pipe(PIPE.replace("up_to_Hz = 300", "up_to_Hz = 300\nerror = 1e-6")))
    assert max(reduced.errors.response, reduced.errors.static) > 1e-6
    assert f"modes.error = 1e-06 isn't reached: with {reduced.kept} modes" in reduced.summary()
    monkeypatch.undo()
    assert "isn't reached" not in reduce(parse_pipe(PIPE)).summary()


@pytest.mark.parametrize("distance", [1e-10, 1e-5, 1e-4, 1e-3, 1e-2])
def test_positions_that_nearly_coincide_cost_no_digits(distance: float) -> None:
    plain = reduce(parse_pipe(PIPE))
    reduced = reduce(parse_pipe(PIPE + f'[[probes]]\nname = "near"\nposition_m = {2 + distance!r}\n'))
    assert reduced.omega[: plain.kept] == pytest.approx(plain.omega[: plain.kept], rel=1e-6)
    shift = np.abs(np.array(reduced.probe_shapes[1]) - reduced.clamp_shapes[0])[: plain.kept]
    assert np.all(shift <= 2 * distance)  # slopes are about 1 1/m here
    assert distance < 1e-9 or shift.max() > 0.1 * distance


def test_supports_that_nearly_coincide_are_refused() -> None:
    with pytest.raises(UserError, match=r"held at 4 m and at 4.0005 m; expected the same position, or at least 1.2 mm"):
        reduce(parse_pipe(PIPE + "[[masses]]\nposition_m = 4.0005\nmass_kg = 1.0\n"))


def test_the_check_of_the_reduction_sees_a_reduction_that_is_wrong() -> None:
    reduced = reduce(parse_pipe(PIPE))
    omega, damping = np.array(reduced.omega), np.array(reduced.damping)
    shapes = np.array(reduced.clamp_shapes)
    good = ModalModel(omega, damping, shapes.T, shapes)
    reference = FullResponse(good, reduced.kept, 2 * pi * 300)
    assert reference.errors(good, reduced.kept).response == 0.0
    bad = ModalModel(omega * 1.001, damping, shapes.T, shapes)
    errors = reference.errors(bad, reduced.kept)
    assert errors.static == pytest.approx(0.002, rel=0.01)
    assert errors.response > 0.01


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('"316L"', '"316l"'), ["pipe.material", "'316l'", "did you mean '316L'"]),
        (("wall_mm = 3.91", "wall_mm = 39"), ["wall_mm = 39", "at most 30.15"]),
        (("wall_mm", "wal_mm"), ["pipe", "'wal_mm'", "did you mean 'wall_mm'"]),
        (('left = "pinned"', 'left = "pined"'), ["ends.left", "'pined'", "'pinned'"]),
        (("stiffness_N_mm", "stifness"), ["ends.right", "did you mean 'stiffness_N_mm'"]),
        (("position_m = 5.0", "position_m = 50"), ["clamps[2] 'clamp2'", "50", "length_m = 6"]),
        (("up_to_Hz = 300", "up_to_Hz = '300'"), ["modes.up_to_Hz", "'300'", "number"]),
        (("length_m = 6.0", "length_m = nan"), ["pipe.length_m", "finite"]),
        (("length_m = 6.0", "length_m = 1e300"), ["pipe.length_m", "1e-12 and 1e+15, got 1e+300"]),
        (("wall_mm = 3.91", "wall_mm = 1e-300"), ["pipe.wall_mm", "got 1e-300"]),
        (
            ('"316L"', "{ E_GPa = 195e9, density_kg_m3 = 8030 }"),
            ["pipe.material.E_GPa", "expected a number of at most 2000"],
        ),
        (
            ('"316L"', "{ E_GPa = 195, density_kg_m3 = 8.03 }"),
            ["pipe.material.density_kg_m3", "expected a number of at least 100"],
        ),
        (("ratio = 0.01", ""), ["damping", "ratio"]),
        (('"clamp2"', '"clamp1"'), ["'clamp1'", "taken"]),
        (('"clamp2"', '"clamp 2"'), ["clamps[2].name", "clamp 2"]),
        (("[modes]\nup_to_Hz = 300", ""), ["modes", "is missing"]),
        (('"water"', '"watr"'), ["pipe.fluid", "did you mean 'water'"]),
        (("length_m = 6.0", "length_m = "), ["not valid TOML", "line 6"]),
        (("[modes]", '[excitation]\nkind = "force"\n[modes]'), ["excitation", "position_m"]),
        (("[modes]", "[axial]\nanchors = -3.0\n[modes]"), ["axial.anchors", "got -3.0; expected a number above 0"]),
        (("right = { stiffness_N_mm = 200.0 }", 'right = "free"\n[axial]\nanchors = "rigid"'), ["both ends", "right"]),
        (("right = { stiffness_N_mm = 200.0 }", 'right = "free"\n[flow]\npressure_bar = 3.0'), ["open end", "capped"]),
    ],
)
def test_a_wrong_description_is_refused_with_its_place(change: tuple[str, str], words: list[str]) -> None:
    with pytest.raises(UserError) as refused:
        parse_pipe(PIPE.replace(*change), "PIPE.toml")
    message = str(refused.value)
    assert message.startswith("PIPE.toml: ")
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("position_m = 2.0", "position_m = 4.0"), ["'clamp1'", "4 m", "rigid support"]),
        (("up_to_Hz = 300", "up_to_Hz = 1"), ["no mode", "10.35 Hz"]),
        (("up_to_Hz = 300", "up_to_Hz = 3e8"), ["elements", "at most 600"]),
        (
            ("[modes]", "[[masses]]\nposition_m = 1.0\nmass_kg = 1e14\n[modes]"),
            ["moves with 1e+14 kg", "expected masses"],
        ),
        (("[modes]", '[excitation]\nkind = "force"\nposition_m = 0.0\n[modes]'), ["force at 0 m", "rigid support"]),
    ],
)
def test_a_pipe_that_cannot_serve_is_refused(change: tuple[str, str], words: list[str]) -> None:
    with pytest.raises(UserError) as refused:
        reduce(parse_pipe(PIPE.replace(*change)))
    assert all(word in str(refused.value) for word in words), refused.value


def test_reading_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "PIPE.toml"
    file.write_text(PIPE, encoding="utf-8")
    assert isinstance(read_pipe(file), PipeDescription)
    with pytest.raises(UserError, match=r"nothing\.toml"):
        read_pipe(tmp_path / "nothing.toml")


def test_the_summary_says_what_was_kept_and_what_it_costs() -> None:
    reduced = reduce(parse_pipe(PIPE))
    summary = reduced.summary()
    assert f"{reduced.kept} modes kept for 300 Hz" in summary
    assert f"{reduced.errors.static_truncated:.1%}" in summary
