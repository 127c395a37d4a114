"""A steel pipe of 3 m whose left end is clamped, and its shaker test with one clamp: their files' text.

Tests give what they vary. Everything else is the same, so that figures of one test can be held against another's.
"""

from __future__ import annotations

from collections.abc import Mapping

PIPE = """
name = "cantilever"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 3.0
material = "316L"
{fluid}
[ends]
left = "clamped"
right = "free"
{places}
[damping]
ratio = {ratio}
[modes]
up_to_Hz = {up_to_Hz}
{further}
"""
SHAKEN = """
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp1"
law = "law.json"
temperature_C = 20.0
amplitude_mm = {amplitude_mm}
frequency_Hz = {frequency_Hz}
{clamp}
[excitation]
kind = "sine"
acceleration_m_s2 = {acceleration_m_s2}
frequency_Hz = {frequency_Hz}
[run]
stop_s = 1.0
step_s = 0.001
"""
FOUR_METRES = """
name = "pipe"
pipe = { outer_diameter_mm = 60.3, wall_mm = 3.9, length_m = 4.0, material = "carbon steel", fluid = "water" }
ends = { left = "clamped", right = "free" }
clamps = [{ name = "c", position_m = 3.2 }]
damping = { ratio = 0.01 }
modes = { up_to_Hz = 25.0 }
"""
"""PIPE.toml of another, with water inside and a clamp near its free end, for responses that have several branches."""
ONE_CLAMP = {"clamp1": 2.0}


def cantilever(
    ratio: float,
    up_to_Hz: float,
    clamps: Mapping[str, float] = ONE_CLAMP,
    probes: Mapping[str, float] | None = None,
    flow_m_s: float | None = None,
    modes: str = "",
) -> str:
    """Give PIPE.toml.

    Args:
        ratio: of damping.
        up_to_Hz: highest natural frequency.
        clamps, probes: positions, m, by name.
        flow_m_s: of the water that it is then filled with.
        modes: further lines of that table.
    """
    entries = [("clamps", clamps), ("probes", probes or {})]
    places = [
        f'[[{kind}]]\nname = "{name}"\nposition_m = {position}\n'
        for kind, positions in entries
        for name, position in positions.items()
    ]
    flow = "" if flow_m_s is None else f"[flow]\nvelocity_m_s = {flow_m_s}"
    return PIPE.format(
        fluid="" if flow_m_s is None else 'fluid = "water"',
        places="".join(places), ratio=ratio, up_to_Hz=up_to_Hz, further=f"{modes}\n{flow}",
    )  # fmt: skip


def shaken(amplitude_mm: float, frequency_Hz: float, acceleration_m_s2: float = 1.0, clamp: str = "") -> str:
    """Give SYSTEM.toml of pipe.toml under a sine, its clamp1 by law.json.

    Args:
        amplitude_mm, frequency_Hz: that the law is taken for; the frequency is the sine's, too.
        acceleration_m_s2: the sine's amplitude.
        clamp: further lines of the clamp's table.
    """
    return SHAKEN.format(
        amplitude_mm=amplitude_mm, frequency_Hz=frequency_Hz, acceleration_m_s2=acceleration_m_s2, clamp=clamp
    )
