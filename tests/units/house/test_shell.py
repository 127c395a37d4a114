"""Words of a command come out of a shell as they went in."""

import os
import shlex
import shutil
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeclamp.studio.commands import _last_parts
from pipeclamp_models.base.shell import quoted, shell_line

ODD = [
    *("my law.json", "a'b", 'a"b', "$HOME", "`id`", "a\\b", "wow!", "50%", "a;b", "a&b", "*.csv", "#3", "", "~", "{x}"),
    *("=a", "@a", "(1)", "a,b", "x="),
]
TOLD = "import sys; print('\\0'.join(sys.argv[1:]), end='')"


@pytest.mark.parametrize("shell", ["sh", "bash", "zsh", "fish"])
def test_a_shell_takes_them(shell):
    if os.name == "nt" or not shutil.which(shell):
        pytest.skip(f"needs {shell}")
    line = " ".join([quoted(sys.executable), "-c", quoted(TOLD), *map(quoted, ODD)])
    assert subprocess.run([shell, "-c", line], capture_output=True, text=True, check=True).stdout.split("\0") == ODD


@given(st.lists(st.text(st.characters(exclude_categories=("Cc", "Cs"))), max_size=5))
def test_any_words_come_back(words):
    assert shlex.split(shell_line(*words, windows=False)) == ["pipeclamp", *words]


def on_windows(line):
    """Part a line as a program on Windows does: by the rules of Microsoft's C runtime."""
    words, word, inside, place = [], None, False, 0
    while place < len(line):
        slashes = len(line[place:]) - len(line[place:].lstrip("\\"))
        place += slashes
        is_quote = line[place : place + 1] == '"'
        if slashes:
            word = (word or "") + "\\" * (slashes // 2 if is_quote else slashes)
        if is_quote and slashes % 2:
            word += '"'
        elif is_quote:
            word, inside = word or "", not inside
        elif place < len(line) and (inside or line[place] != " "):
            word = (word or "") + line[place]
        elif place < len(line):
            words, word = words + ([word] if word is not None else []), None
        place += 1
    return words + ([word] if word is not None else [])


@given(st.lists(st.text(st.characters(exclude_categories=("Cc", "Cs"), exclude_characters="$`")), max_size=5))
def test_a_program_on_windows_takes_them(words):
    assert on_windows(shell_line(*words, windows=True)) == ["pipeclamp", *words]


@pytest.mark.parametrize(
    ("word", "line"),
    [
        (r"C:\tests\a.json", r"C:\tests\a.json"),
        (r"C:\my tests" + "\\", r'"C:\my tests\\"'),
        ("50%", '"50%"'),
        ("A=0.1..2,f=1..5", "A=0.1..2,f=1..5"),
        ("@a", '"@a"'),
        ("cost$.json", "'cost$.json'"),
        ("o'neill$.json", "'o''neill$.json'"),
    ],
)
def test_windows_shells_keep_them(word, line):
    assert quoted(word, windows=True) == line


@pytest.mark.parametrize("folder", ["/a/b", "/my tests"])
def test_a_law_keeps_the_last_parts_of_paths(folder):
    line = shell_line("add", f"{folder}/law 1.json", "gap,play", f"{folder}/c", windows=False)
    assert _last_parts(line) == 'pipeclamp add "law 1.json" gap,play c'
