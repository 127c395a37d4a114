"""Messages that are too long: the file's name, what was got and what was expected stay."""

from pipeclamp_models.base.said import LONGEST_LINE, message

SAID = "runs/A.csv: has no column 'time_s' (it has 'time_s;force_N'); expected comma-separated columns"


def test_a_long_path_loses_its_upper_folders_alone():
    said = message(f"/home/{'folder/' * 60}{SAID}")
    assert said.startswith("[...] ")
    assert said.endswith(f"/{SAID}")
    assert len(said) == LONGEST_LINE


def test_a_long_line_loses_its_middle():
    said = message(f"/a/b.csv: {'got ' * 200}; expected less")
    assert said.startswith("/a/b.csv: got")
    assert said.endswith("; expected less")
    assert len(said) == LONGEST_LINE


def test_a_long_line_of_a_list_stays_one():
    first, line = message(f"two can't be read\n  /home/{'folder/' * 60}{SAID}").split("\n")
    assert first == "two can't be read"
    assert line.startswith("  [...] ")
    assert len(line) == LONGEST_LINE


def test_a_command_to_copy_stays_whole():
    command = f"  pipeclamp import {'a/' * 200}exports -o campaign"
    assert message(f"exports: no campaign.toml in it:\n{command}").splitlines()[1] == command
