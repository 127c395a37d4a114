"""What isn't to be trusted says so in the file, on each picture and on stderr; what is says how much it errs."""

import html
import re
import zipfile

import polars as pl
import pytest
from cantilever import cantilever
from typer.testing import CliRunner

from pipeclamp.cli.app import app
from pipeclamp.demo import co_simulated
from pipeclamp_system.cosim import parallel_step

FREQUENCY = 28.021
"""Hz, of the first resonance: the clamp is 85 times as stiff as the pipe."""


@pytest.fixture
def shaken(tmp_path):
    """Give a function that writes SYSTEM.toml for a scheme and steps in a cycle."""

    def write(scheme, parts, more=""):
        (tmp_path / "pipe.toml").write_text(
            cantilever(ratio=0.005, up_to_Hz=200.0, modes="error = 0.4"), encoding="utf-8"
        )
        (tmp_path / "system.toml").write_text(
            '[pipe]\nfile = "pipe.toml"\n[[clamps]]\nat = "clamp1"\nlaw = "emwm2"\ntemperature_C = 20.0\n'
            f'amplitude_mm = 0.5\n[excitation]\nkind = "sine"\nacceleration_m_s2 = 5.0\nfrequency_Hz = {FREQUENCY}\n'
            f'[run]\nscheme = "{scheme}"\nstop_s = {20 / FREQUENCY!r}\nstep_s = {1 / (FREQUENCY * parts)!r}\n{more}',
            encoding="utf-8",
        )
        return tmp_path

    return write


def titles(page):
    """Give the titles of a report's pictures."""
    return re.findall(r'"text":"((?:Displacement|Loop|Where)[^"]*)"', page.read_text(encoding="utf-8"))


def ssd(path):
    """Give the description that an SSP holds."""
    return zipfile.ZipFile(path).read("SystemStructure.ssd").decode()


def test_steps_that_are_too_long_are_marked_though_the_energy_is_right(pipeclamp, shaken):
    folder = shaken("sequential", 256)
    done = pipeclamp("cosim", "system.toml", "-o", "result.csv", "--report", "result.html", cwd=folder)
    mark = re.search(
        r"^NOT TO BE TRUSTED: the displacement errs by ([\d.]+)% .*use step_s = (\S+) or less", done.stderr
    )
    assert mark, done.stderr
    assert float(mark[1]) == pytest.approx(5.7, abs=0.4)
    assert "the coupling itself made" not in done.stderr
    assert "NOT TO BE TRUSTED" not in done.stdout
    result = pl.read_csv(folder / "result.csv")
    assert set(result["trusted [1 yes, 0 no]"]) == {0.0}
    assert result["step_error [share of the displacement, empty where not known]"][0] == pytest.approx(
        0.0575, abs=0.004
    )
    drawn = titles(folder / "result.html")
    assert len(drawn) == 3
    assert all("NOT TO BE TRUSTED" in title for title in drawn), drawn
    assert '<p class="doubt">NOT TO BE TRUSTED: the displacement errs by' in (folder / "result.html").read_text(
        encoding="utf-8"
    )

    shaken("sequential", 1 / (FREQUENCY * float(mark[2])))
    done = pipeclamp("cosim", "system.toml", "-o", "result.csv", "--report", "result.html", cwd=folder)
    assert "NOT TO BE TRUSTED" not in done.stdout + done.stderr
    assert re.search(r"The displacement errs by [01]\.\d+% in amplitude and phase", done.stdout)
    assert set(pl.read_csv(folder / "result.csv")["trusted [1 yes, 0 no]"]) == {1.0}
    drawn = titles(folder / "result.html")
    assert len(drawn) == 3
    assert not any("NOT TO BE TRUSTED" in title for title in drawn)


def test_a_system_for_other_masters_tells_and_holds_the_step_that_they_may_take(pipeclamp, shaken):
    folder = shaken("iterated", 32)
    done = pipeclamp("system", "system.toml", "-o", "system.ssp", cwd=folder)
    told = re.search(r"give them steps of (\S+) s or less, in which the displacement errs by ([\d.]+)%", done.stdout)
    assert told, done.stdout
    step, error = float(told[1]), float(told[2])
    assert step == pytest.approx(1 / (FREQUENCY * 1024))
    assert 0.5 < error <= 2.0
    assert f'<osp:FixedStepAlgorithm baseStepSize="{told[1]}" />' in ssd(folder / "system.ssp")

    shaken("parallel", 1 / (FREQUENCY * step))
    assert "NOT TO BE TRUSTED" not in pipeclamp("cosim", "system.toml", "-o", "result.csv", cwd=folder).stderr
    shaken("parallel", 0.5 / (FREQUENCY * step))
    assert "NOT TO BE TRUSTED" in pipeclamp("cosim", "system.toml", "-o", "result.csv", cwd=folder).stderr


@pytest.mark.parametrize(("most", "said"), [(128, "in no step down to"), (512, "foretold from")])
def test_where_the_step_would_take_too_long_to_find_it_is_foretold_or_none_is_named(shaken, monkeypatch, most, said):
    """In 1/128 of a cycle the coupling is too far off to foretell anything by."""
    monkeypatch.setattr(parallel_step, "MOST_STEPS_OF_A_TRIAL", 20 * most)
    folder = shaken("iterated", 32)
    done = CliRunner().invoke(app, ["system", str(folder / "system.toml"), "-o", str(folder / "system.ssp")])
    assert done.exit_code == 0
    assert said in done.output
    held = [float(step) * FREQUENCY for step in re.findall(r'baseStepSize="(\S+)"', ssd(folder / "system.ssp"))]
    if most == 128:
        assert held == []
        assert "NOT TO BE TRUSTED" in done.stderr
    else:  # 1/1024 would do, as the test above finds: it may be foretold as half of it, but no longer
        assert len(held) == 1
        assert 1 / 2049 < held[0] < 1 / 1023


@pytest.mark.parametrize(("parts", "marked"), [(256, True), (1024, False)])
def test_a_page_of_the_demo_and_its_lines_bear_the_same_marks(shaken, parts, marked):
    folder, told = shaken("sequential", parts), []
    page = co_simulated(folder / "system.toml", folder / "page.html", "20 degC", told.append)
    on_page = re.findall(r'<p class="doubt">(.*)</p>', page.read_text(encoding="utf-8"))
    assert bool(on_page) == marked
    # On a page a mark is a sentence of its own, with its full stop.
    assert [html.unescape(mark) for mark in on_page] == [f"{line.strip()}." for line in told if "NOT TO BE" in line]
    assert all("NOT TO BE TRUSTED" in title for title in titles(page)) == marked
    assert re.search(r"displacement errs by \d+\.\d+% for its steps", told[0]), told


@pytest.mark.parametrize(("parts", "marked"), [(256, True), (1024, False)])
def test_co_simulated_cases_of_a_study_that_are_not_to_be_trusted_are_marked(pipeclamp, shaken, parts, marked):
    folder = shaken("sequential", parts)
    vary = '[vary]\n"system.excitation.acceleration_m_s2" = [4.0, 5.0]\n'
    (folder / "study.toml").write_text(f'system = "system.toml"\nmeasure = "cosim"\n{vary}', encoding="utf-8")
    options = ("-o", "study.parquet", "--report", "study.html", "--jobs", "1")
    done = pipeclamp("sweep", "study.toml", *options, cwd=folder)
    assert "NOT TO BE TRUSTED" not in done.stdout
    said = re.findall(r"^NOT TO BE TRUSTED: .*the displacement errs by .*$", done.stderr, re.MULTILINE)
    page = (folder / "study.html").read_text(encoding="utf-8")
    assert [html.unescape(mark) for mark in re.findall(r'<p class="doubt">(.*)</p>', page)] == said
    assert bool(said) == marked
    drawn = re.findall(r'"text":"([^"]*: amplitude[^"]*)"', page)
    assert len(drawn) == 1
    assert ("NOT TO BE TRUSTED" in drawn[0]) == marked
    frame = pl.read_parquet(folder / "study.parquet")
    assert frame["trusted"].to_list() == [not marked] * 2
    assert all(bool(why) == marked for why in frame["doubts"])
