"""Tables in 80 columns: what is typed stays whole, and sentences get the room that numbers leave."""

from pipeclamp.cli.terminal import print_table
from pipeclamp.show.table import Table

HEADER = (
    "with",
    "estimated error on left-out A, f / %",
    "on left-out temperature / %",
    "of what is missing it takes / %",
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
    header = ("with", "error / %", "on left-out conditions / %", "explained / %", "by scatter alone / %", "against it")
    row = ("exponential_stiffening", 2.325, 6.08, 67.71, 0.3398, "delta_s ran into its bound (0.09549); and more")
    print_table(Table(header, [row, ("law as it is, refitted", 3.339, 11.24, 0.0, "–", "–")]), width=80)
    told = capsys.readouterr().out
    assert "exponential_stiffening" in told
    assert max(map(len, told.splitlines())) <= 80
