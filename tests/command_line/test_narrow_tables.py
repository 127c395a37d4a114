"""Tables in 80 columns: what is typed stays whole, and sentences get the room that numbers leave."""

import pytest

from pipeclamp.cli.terminal import print_table
from pipeclamp.show.layout import hanging, room_of, wrapped
from pipeclamp.show.table import Table

HEADER = (
    "with",
    "error on left-out A, f / %",
    "on left-out temperature / %",
    "takes of missing / %",
    "speaks against it",
)
AGAINST = "z_p ran into its bound (0); the data determines no parameter of directional_slip; memory leaves as little"
ROWS = [
    ("directional_slip", 4.324, 5.048, 64.63, AGAINST),
    ("self_centring + oil_damper", 3.925, 20.35, 70.94, "on left-out temperature the error rises from 5.91% to 20.35%"),
    ("law as it is", 7.239, 5.906, 0.0, "–"),
]


def test_names_stay_whole_and_sentences_get_the_room(capsys):
    print_table(Table(HEADER, ROWS), width=80)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert any("directional_slip" in line for line in lines)
    assert any("self_centring" in line for line in lines)
    sentences = [line.split("│")[5].strip() for line in lines if line.startswith("│")]
    assert max(map(len, sentences)) > 20


def test_a_table_that_fits_stays_as_it_is(capsys):
    print_table(Table(("law", "made of"), [("first", "power and what was added to it")]), width=80)
    assert "power and what was added to it" in capsys.readouterr().out


def test_words_too_long_for_the_screen_are_folded(capsys):
    print_table(Table(("with", "error", "file"), [("a", 1.0, "x" * 120)]), width=80)
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


def test_a_name_stays_whole_where_a_word_of_a_sentence_is_a_little_too_long(capsys):
    header = ("with", "error / %", "on left-out conditions / %", "explained / %", "by scatter alone", "against it")
    row = ("exponential_stiffening", 2.325, 6.08, 67.71, 0.3398, "delta_s ran into its bound (0.09549); and more")
    print_table(Table(header, [row, ("law as it is, refitted", 3.339, 11.24, 0.0, "–", "–")]), width=80)
    told = capsys.readouterr().out
    assert "exponential_stiffening" in told
    assert max(map(len, told.splitlines())) <= 80


LAWS = Table(
    ("law", "made of", "RMS error / %", "scatter / %", "error over scatter"),
    [("clamp_a (law.json)", "power + damping_temperature + exponential_stiffening", 0.4739, 0.4746, 0.9985)],
)
METRICS = Table(
    ("A / mm", "dW / J", "W / J", "eta", "k / N/mm", "paper dW / J", "paper W / J", "paper eta"),
    [(0.2, 0.07793, 0.05656, 0.2193, 2769.0, 0.1281, 0.05523, 0.3708)],
)


def printed(table, width, capsys):
    print_table(table, width=width)
    told = capsys.readouterr().out
    assert max(map(len, told.splitlines())) <= width
    return told


@pytest.mark.parametrize("width", [60, 80])
def test_names_of_a_later_column_stay_whole(width, capsys):
    told = printed(LAWS, width, capsys)
    assert "damping_temperature" in told
    assert "exponential_stiffening" in told


def test_a_name_that_is_too_long_for_its_column_is_cut_at_its_joints():
    assert wrapped("with exponential_stiffening, gap", 16).split("\n") == ["with", "exponential_", "stiffening, gap"]


@pytest.mark.parametrize("width", [40, 50, 60, 80])
def test_numbers_are_never_cut_nor_heads(width, capsys):
    told = printed(METRICS, width, capsys)
    for number in ("0.07793", "0.05656", "0.2193", "2769", "0.1281", "0.05523", "0.3708"):
        assert number in told
    assert "paper" in told


def test_a_unit_stays_beside_its_symbol_where_there_is_room(capsys):
    header = ("run", "A / mm", "f / Hz", "what else is to be known of this run, told at such length that it is folded")
    assert "f / Hz" in printed(Table(header, [("one", 1.0, 1.0, "it is long " * 9)]), 60, capsys)


def test_a_sentence_goes_on_below_its_beginning_and_its_words_stay_whole():
    told = hanging("head\n  a sentence with /a/long/path/that/stays/whole.json at its end", 24)
    assert told.split("\n") == ["head", "  a sentence with", "  /a/long/path/that/stays/whole.json", "  at its end"]


def test_letters_that_take_two_columns_get_them():
    """A channel called 时间 had been cut to "时间 […"."""
    assert room_of("时间 [s]") == 8 and room_of("力") == 2 and room_of("µm") == 2
    assert all(room_of(line) <= 9 for line in wrapped("位移传感器一号 [mm]", 9).split("\n"))
