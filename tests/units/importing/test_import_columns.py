"""Which channel is what, and in which unit: found by names, stated, or asked, and never taken for granted."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

from pipeclamp_identification.importing.channels.columns import (
    map_columns,
    parse_columns,
    refuse_open_questions,
    unused_words,
)
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.units.stated import conversion, conversion_of_rate, unit_in_name
from pipeclamp_models.base.errors import UsageError, UserError


def table(*headings):
    return RawTable("", tuple(Channel(name, "", np.arange(3.0) / 100) for name in headings))


def found(headings, option=""):
    mapped = map_columns(table(*headings), parse_columns(option))
    refuse_open_questions("a.csv", mapped)
    return {column.ours: (column.heading, column.conversion.factor) for column in mapped.columns}


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Axial Force (kN)", "kN"), ("Weg/mm", "mm"), ("Last [kN]", "kN"), ("LVDT in", "in"), ("Zeit, s", "s"),
        ("force_N", "N"), ("T [°F]", "°F"), ("Load (cell 1)", ""), ("Kraft", ""), ("F1", ""), ("Weg in mm", "mm"),
        ("Velocity mm/s", "mm/s"), ("stiffness_N/mm", "N/mm"), ("omega_rad/s", "rad/s"), ("frequency_Hz", "Hz"),
        ("G' Pa", "Pa"), ("strain_pct", "%"), ("Kraft F/kN", "kN"), ("Zeit t/s", "s"), ("Weg s/mm", "mm"),
        ("Channel A", ""), ("Kanal V", ""), ("Temperatura (ºC)", "°C"), ("Temp ˚C", "°C"), ("T [oC]", "oC"),
        ("freq_hz", "Hz"), ("storage_modulus_pa", "Pa"), ("e_storage_mpa", "MPa"), ("FREQ (HZ)", "HZ"),
        ("LOSS MODULUS MPA", "MPa"), ("k_kn_per_mm", "kn/mm"),
        ("load_mn", ""), ("load_mN", "mN"), ("STROKE (IN)", "IN"), ("LOAD IN LBF", "lbf"),
    ],
)  # fmt: skip
def test_units_are_found_in_names(name, unit):
    assert unit_in_name(name)[1] == unit


@pytest.mark.parametrize(
    ("quantity", "unit", "factor", "offset"),
    [
        ("force", "kN", 1e3, 0), ("force", "lbf", 4.4482216152605, 0), ("force", "kp", 9.80665, 0),
        ("force", "0.2 kN", 200, 0), ("displacement", "in", 25.4, 0), ("displacement", "µm", 1e-3, 0),
        ("time", "ms", 1e-3, 0), ("temperature", "K", 1, -273.15), ("temperature", "°F", 5 / 9, -160 / 9),
        ("temperature", "ºC", 1, 0), ("temperature", "˚F", 5 / 9, -160 / 9), ("temperature", "oC", 1, 0),
        ("temperature", "deg_F", 5 / 9, -160 / 9), ("temperature", "Degrees Celsius", 1, 0), ("force", "Newtons", 1, 0),
        ("force", "KILONEWTONS", 1e3, 0), ("force", "Pounds", 4.4482216152605, 0),
        ("displacement", "Micrometres", 1e-3, 0), ("time", "Milliseconds", 1e-3, 0),
        ("force", "n", 1, 0), ("force", "KN", 1e3, 0), ("force", "mN", 1e-3, 0), ("force", "MN", 1e6, 0),
        ("displacement", "MM", 1, 0), ("temperature", "c", 1, 0), ("displacement", "IN", 25.4, 0),
        ("force", "KGF", 9.80665, 0), ("time", "MS", 1e-3, 0),
    ],
)  # fmt: skip
def test_units_are_turned_into_ours(quantity, unit, factor, offset):
    turned = conversion(quantity, unit)
    assert (turned.factor, turned.offset) == pytest.approx((factor, offset), rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "target", "factor"),
    [
        ("kn/mm", "N/mm", 1e3), ("N/MM", "N/mm", 1), ("KN/M", "N/mm", 1), ("n/mm", "N/mm", 1), ("mpa", "Pa", 1e6),
        ("MPA", "Pa", 1e6), ("mPa", "Pa", 1e-3), ("HZ", "Hz", 1), ("khz", "Hz", 1e3), ("MM/S", "mm/s", 1),
    ],
)  # fmt: skip
def test_units_in_small_letters_or_in_capitals_are_those_with_their_own(unit, target, factor):
    """kn/mm had been knots over millimetres, a frequency in HZ none."""
    assert conversion("", unit, target).factor == pytest.approx(factor)


def test_a_temperature_in_c_is_no_speed_of_light():
    assert conversion_of_rate("c") is None
    headings = ["temperature_c", "time_s", "disp_mm", "force_n"]
    assert found(headings) == {
        "time": ("time_s", 1.0),
        "displacement": ("disp_mm", 1.0),
        "force": ("force_n", 1.0),
        "temperature": ("temperature_c", 1.0),
    }
    with pytest.raises(UserError, match="no channel is called a displacement or is in a unit of one"):
        found(["temperature_c", "time_s", "force_n"])


@pytest.mark.parametrize(
    ("headings", "option", "expected"),
    [
        (["Zeit [s]", "Weg/mm", "Last [kN]"], "", {"force": ("Last [kN]", 1e3)}),
        (["Time (s)", "Axial Displacement (m)", "Axial Force (kN)", "Axial Command (mm)"], "",
         {"displacement": ("Axial Displacement (m)", 1e3)}),
        (["Ch1 [kN]", "Ch2 [mm]", "Time [ms]"], "", {"force": ("Ch1 [kN]", 1e3), "time": ("Time [ms]", 1e-3)}),
        (["t [s]", "y [mm]", "F [N]", "T [K]"], "", {"temperature": ("T [K]", 1.0)}),
        (["Zeit", "Weg [mm]", "Kraft [N]"], "time=Zeit [ms],force=-Kraft [N]",
         {"time": ("Zeit", 1e-3), "force": ("Kraft [N]", -1.0)}),
        (["time [s]", "x, y (mm)", "load (N)"], "displacement=x, y (mm), time=time [s]",
         {"displacement": ("x, y (mm)", 1.0)}),
        (["time [s]", "y [mm]", "Load [N]"], "force=Load [N] [kN]", {"force": ("Load [N]", 1e3)}),
        (["time [s]", "y [mm]", "Load"], "force=Load [V] [2 kN]", {"force": ("Load", 2e3)}),
        (["Prüfzeit [s]", "Verformung [mm]", "Prüfkraft [N]"], "", {"displacement": ("Verformung [mm]", 1.0)}),
        (["Temps [s]", "Course [mm]", "Charge [daN]"], "", {"force": ("Charge [daN]", 10.0)}),
        (["t [m]", "y [mm]", "F [N]"], "", {"time": ("t [m]", 60.0)}),
    ],
)  # fmt: skip
def test_channels_are_found(headings, option, expected):
    assert expected.items() <= found(headings, option).items()


def test_metres_of_what_has_no_known_name_are_no_minutes():
    """Beside --rate no channel is the time; a compression in m had been, and nothing was left for the displacement."""
    mapped = map_columns(table("Jounce compression [m]", "Jounce force [N]"))
    taken = {column.ours: column.heading for column in mapped.columns}
    assert taken == {"displacement": "Jounce compression [m]", "force": "Jounce force [N]"}


def test_a_bearings_load_is_not_its_force():
    """The load that it bears is called one, its shear had no name: 100 kN that hardly move had been the force."""
    t = np.arange(40.0)
    moving, still = 8 * np.sin(t), 100 + 0.3 * np.cos(3 * t)

    def asked(name, option=""):
        channels = {"time_s": t, "disp_mm": np.sin(t), "vertical_load_kN": still, name: moving}
        loaded = RawTable("", tuple(Channel(one, "", values) for one, values in channels.items()))
        return [question.why for question in map_columns(loaded, parse_columns(option)).questions]

    assert asked("shear_kN") == ["2 channels may be the force: 'shear_kN', 'vertical_load_kN'"]
    # whatever the other one is called
    assert asked("Ch3_kN") == ["2 channels may be the force: 'Ch3_kN', 'vertical_load_kN'"]
    assert not asked("shear_kN", "force=shear_kN,load_kN=vertical_load_kN")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("largest", [0.0, 1e298, 1e-310])
def test_whether_a_force_moves_is_told_of_any_numbers(largest):
    """As of a damaged file, whose numbers have squares beyond all numbers."""
    t = np.arange(40.0)
    channels = {"time_s": t, "disp_mm": np.sin(t), "force_N": largest * np.sin(t)}
    loaded = RawTable("", tuple(Channel(one, "", values) for one, values in channels.items()))
    assert not map_columns(loaded).questions


def test_channels_of_one_quantity_are_told_apart_by_their_samples():
    """Dewesoft gives each channel its own time; Instron's time of a cycle begins anew with each."""
    t = np.arange(40.0)
    values = {"Time - y": t, "Time - F": t, "Cycle Time": t % 10, "y": np.sin(t), "F": np.sin(t)}
    units = dict.fromkeys(values, "s") | {"y": "mm", "F": "N"}

    def times(**others):
        channels = [Channel(name, units[name], samples) for name, samples in (values | others).items()]
        return map_columns(RawTable("", tuple(channels)))

    assert times().columns[0].heading == "Time - y [s]"
    assert not times().questions
    (question,) = times(**{"Time - F": t + 0.5}).questions
    assert "2 channels may be the time: 'Time - y [s]', 'Time - F [s]'" in question.why


def test_times_of_channels_are_not_the_channels():
    with pytest.raises(UserError, match=r"time=Data1_time_Weg \[s\],displacement=Data1_Weg \[mm\],force=Data1_Kraft"):
        found(["Data1_time_Weg", "Data1_Weg", "Data1_time_Kraft", "Data1_Kraft"])


@pytest.mark.parametrize(
    ("headings", "option", "told"),
    [
        (["Zeit", "Weg", "Kraft"], "", r'--columns "time=Zeit \[s\],displacement=Weg \[mm\],force=Kraft \[N\]"'),
        (
            ["Time (s)", "LVDT 1 (mm)", "LVDT 2 (mm)", "Load (N)"],
            "",
            r"2 channels may be the displacement.*\n.*--columns",
        ),
        (["Time [s]", "Axial Force [mm]", "Axial Force [N]"], "", "in a unit of displacement, but is called a force"),
        (["Time (s)", "y (mm)", "Ch3 (V)"], "", "no channel is called a force or is in a unit of one"),
        (["Time (s)", "y (mm)", "Load (V)"], "", r"'V' is no unit of force: .*force=Load \(V\) \[1 N\]"),
        (["Time (s)", "y (mm)", "Load [foo]"], "", r"no known unit is stated of 'Load \[foo\]'"),
        (["Time (s)", "y (mm)", "Load [mm]"], "", "'Load .mm.' is called a force, but 'mm' is a unit of displacement"),
        (["y (mm)", "Load (N)", "T [°C]"], "", "--rate 1000"),
        (["Time (s)", "y (mm)", "Load (N)"], "fource=Load (N)", "'fource': did you mean 'force'"),
        (["Time (s)", "Pressure [bar]", "Load (N)"], "", "there are 'Time .s.', 'Pressure .bar.'"),
        (["Time (s)", "Pressure [bar]", "Load (N)"], "", "\n  expected .*--columns OURS=CHANNEL"),
        (["Time (s)", "y (mm)", "Load (V)"], "force=Load (V)", "'V' is no unit of force"),
        (["Time (s)", "Angle", "Load (N)"], "displacement=Angle [rad]", r"what 1 rad stands for, .*\[2.5 mm\]"),
        (["Time (s)", "Angle", "Load (N)"], "displacement=Angle [foo]", "such as mm, m, um or in$"),
        (["Time (s)", "y (mm)", "Load (N)"], "force=Load [kN]", r"the file says 'Load \(N\)'"),
        (["Time (s)", "y (mm)", "Load (N)"], "force=Last", "no channel 'Last'.*there are 'Time"),
        (["Time (s)", "y (mm)", "Load (N)"], "force=Load [V] [2 kN]", r"no channel 'Load \[V\] \[2 kN\]'"),
        (["Time (s)", "y (mm)", "Load (N)"], "force=Load (N),segment=Load", "twice"),
        (
            ["Time (s)", "y (mm)", "Load (N)"],
            "segment=Load",
            r"states 'Load \(N\)' as segment, and no other .* a force",
        ),
        (
            ["Time (s)", "y (mm)", "Load (N)"],
            "current_A=y",
            r"states 'y \(mm\)' as current_A, and no other .* displacem",
        ),
        (
            ["Time (s)", "y (mm)", "Kanal", "Load (N)"],
            "segment=y",
            r"states 'y \(mm\)' as segment, .*\n.*displacement=Kanal \[mm\]",
        ),
    ],
)
def test_what_is_open_is_asked(headings, option, told):
    with pytest.raises(UserError, match="(?s)" + told):
        found(headings, option)


@pytest.mark.parametrize("option", ["force", "force=", "force=a,force=b", "force=a,time=a", "=a", "displacement=none"])
def test_a_statement_that_makes_no_sense_is_refused(option):
    with pytest.raises(UsageError, match="--columns"):
        parse_columns(option)


@pytest.mark.parametrize(
    ("headings", "force"),
    [
        (["Zeit", "Weg, links", "Kraft"], ("Kraft", 1.0)),
        (["Time [s]", "Displacement [N]", "Force [N]"], ("Force [N]", 1.0)),
        (["Time [s]", "Displacement [mm]", "Force [mm]"], ("Force [mm]", 1.0)),
        (["Time [s]", "Displacement [N]", "Force [mm]"], ("Force [mm]", 1.0)),
        (["Time [s]", "Stroke [mm]", "Load [V]"], ("Load [V]", 1.0)),
        (["Time [s]", "Stroke [mm]", "Load [1/[current_A]]"], ("Load [1/[current_A]]", 1.0)),
        (["A", "B", "C"], ("C", 1.0)),
        (["t", "A", "D", "Y", "V", "F"], ("F", 1.0)),
        (["Time [s]", 'Weg "links"', "Kraft $1"], ("Kraft $1", 1.0)),
        (["Time [s]", "y (mm)", "Load (N)", "Temperatur [V]"], ("Load (N)", 1.0)),
        (["Cycle", "A", "B [mm]", "C [N]"], ("C [N]", 1.0)),
        (["Millis", "Load_Cell", "Linear_Pot (scaled)", "Velocity"], ("Load_Cell", 1.0)),
        ([f"{'long ' * 20}{end}" for end in ("Time", "Weg [N]", "Load [kN]")], (f"{'long ' * 20}Load [kN]", 1e3)),
    ],
)
def test_the_ready_option_serves(headings, force):
    """What an error proposes is taken as a shell gives it."""
    with pytest.raises(UserError) as refused:
        found(headings)
    lines = str(refused.value).splitlines()
    (option,) = (shlex.split(line)[1] for line in lines if line.strip().startswith("--columns"))
    assert found(headings, option)["force"] == force


def test_channels_that_are_not_used_are_told_with_what_keeps_one():
    headings = ["Time [s]", "y [mm]", "F [N]", "Command [mm]", "Density [kg/m3]", "Spulenstrom, soll [A]"]
    mapped = map_columns(table(*headings))
    words = unused_words(["a.csv", "b.csv"], headings[3:], mapped)
    assert words.startswith("a.csv and 1 more: not used: 'Command [mm]', 'Density [kg/m3]'")
    assert shlex.split(words)[-1] == "measured_density_kg_m3=Density [kg/m3]"
    assert parse_columns(shlex.split(words)[-1])


def test_no_channel_in_a_unit_of_something_else_is_proposed():
    """A dynamometer's sums had been proposed as "displacement=Compression (lbf) [mm]"."""
    sums = table("Velocity (in/s)", "Compression (lbf)", "Rebound (lbf)")
    with pytest.raises(UserError, match=r"'Velocity \(in/s\)' is a speed, and forces over speeds are no loops") as told:
        refuse_open_questions("a.csv", map_columns(sums))
    assert "[mm]" not in str(told.value)


def test_milliseconds_of_a_microcontroller_are_its_time():
    """A shock dyno's channels had been "no channel of numbers": its load cell had been proposed for a displacement."""
    channels = tuple(Channel(name, "", np.arange(3.0) * 10) for name in ("Millis", "Load_Cell", "Linear_Pot"))
    with pytest.raises(UserError) as told:
        refuse_open_questions("a.csv", map_columns(RawTable("", channels)))
    assert '--columns "time=Millis [ms],displacement=Linear_Pot [mm],force=Load_Cell [N]"' in str(told.value)


def test_the_axis_of_a_spectrum_is_proposed_for_no_time():
    """It had been "time=Freq_domain [s]": it rises as a time does."""
    t = np.arange(200) / 100
    samples = {"disp_mm": np.sin(6 * t), "force_N": np.cos(6 * t), "Freq_domain": t}
    channels = tuple(Channel(name, "", values) for name, values in samples.items())
    with pytest.raises(UserError, match="expected its samples per second, for example --rate 1000") as told:
        refuse_open_questions("a.mat", map_columns(RawTable("", channels)))
    assert "Freq_domain" not in str(told.value)


def test_a_rate_of_change_is_proposed_last():
    """Of a damper's record without names, the speed beside the displacement had been proposed for the force."""
    t = np.arange(200) / 100
    y = np.sin(2 * np.pi * t) + 0.1 * np.sin(6 * np.pi * t)
    speed = np.gradient(y, t)
    for samples in ((t, y, speed, np.tanh(3 * speed)), (t, speed, y, np.tanh(3 * speed))):
        channels = tuple(Channel(f"column {place}", "", one) for place, one in enumerate(samples, 1))
        with pytest.raises(UserError) as told:
            refuse_open_questions("a.txt", map_columns(RawTable("", channels)))
        where = 2 if samples[1] is y else 3
        assert f"displacement=column {where} [mm],force=column 4 [N]" in str(told.value)


def test_a_force_in_proportion_to_speed_is_still_proposed():
    t = np.arange(200) / 100
    samples = (t, np.sin(2 * np.pi * t), 40 * np.cos(2 * np.pi * t))
    channels = tuple(Channel(f"column {place}", "", one) for place, one in enumerate(samples, 1))
    with pytest.raises(UserError, match=r"displacement=column 2 \[mm\],force=column 3 \[N\]"):
        refuse_open_questions("a.txt", map_columns(RawTable("", channels)))


def test_letters_of_a_quantity_are_proposed_before_others():
    """Of a damper's record with t, A, D, Y, V and F, the acceleration had been proposed for a displacement."""
    with pytest.raises(UserError) as told:
        found(["t", "A", "D", "Y", "V", "F"])
    assert '--columns "time=t [s],displacement=D [mm],force=F [N]"' in str(told.value)


def test_what_each_cycle_reached_is_no_record():
    peaks = [f"{name}:{end} ({unit})" for name, unit in (("Position", "mm"), ("Force", "kN")) for end in ("Max", "Min")]
    with pytest.raises(UserError, match=r"'Position:Max \(mm\)' is what a cycle reached.*take the file of samples"):
        found(["Time (s)", "Step", "Frequency (Hz)", *peaks])
    # beside its samples it is one channel of many
    assert found(["Time (s)", "Position (mm)", "Force (kN)", *peaks])["displacement"][0] == "Position (mm)"


def test_a_number_of_the_step_is_proposed_for_no_displacement():
    with pytest.raises(UserError) as refused:
        found(["Time (s)", "Step", "a", "b"])
    assert "displacement=a" in str(refused.value) and "displacement=Step" not in str(refused.value)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("step", "first"), [(0.02, "s"), (20.0, "ms")])
def test_a_time_in_every_other_row_without_a_unit_is_asked_by_its_steps(step, first):
    time = np.where(np.arange(12) % 2 == 0, 0.5 * step * np.arange(12), np.nan)
    motion = [Channel(name, unit, np.arange(12.0)) for name, unit in (("Weg", "mm"), ("Kraft", "N"))]
    mapped = map_columns(RawTable("", (Channel("Time", "", time), *motion)))
    (question,) = mapped.questions
    assert question.choices[0].text == f"time=Time [{first}]"
