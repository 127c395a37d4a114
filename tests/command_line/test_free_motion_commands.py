"""Commands on campaigns with runs of free motion: `compare` takes them, the others leave them out and say so."""

import json
import re
import time

import numpy as np
import pytest

import pipeclamp as pc

NOTE = "note: 1 run of free motion is left out (shaken)"


@pytest.fixture
def mixed(campaign_folder, harmonic_record, csv_text):
    """Give a function that writes a campaign of two sines and one free motion, or of the latter alone."""
    at = np.arange(3000) / 200.0
    window = np.sin(np.pi * at / 15) ** 2
    y = window * (0.6 * np.sin(2 * np.pi * 1.1 * at) + 0.3 * np.sin(2 * np.pi * 2.7 * at + 1))
    v = np.gradient(y, at)
    force = 1900 * y + 30 * v * np.abs(v + 1e-9) ** -0.5 + np.random.default_rng(4).normal(0, 3, len(at))
    shaken = "time_s,displacement_mm,force_N\n" + "".join(
        f"{a:.4f},{b:.5f},{c:.2f}\n" for a, b, c in zip(at, y, force, strict=True)
    )
    records = {f"runs/{f}.csv": csv_text(harmonic_record(frequency=f)) for f in (2.0, 4.0)}
    rows = [f"{f},runs/{f}.csv,,20\n" for f in (2.0, 4.0)]

    def write(*, sines=True):
        table = "run,file,motion,temperature_C\n" + "".join(rows if sines else []) + "shaken,runs/s.csv,free,20\n"
        return campaign_folder(table=table, records=records | {"runs/s.csv": shaken}, folder=f"tests{sines}")

    return write


@pytest.mark.parametrize("sines", [True, False])
def test_compare_takes_them(pipeclamp, mixed, tmp_path, sines):
    answer, report, campaign = tmp_path / "c.json", tmp_path / "c.html", mixed(sines=sines)
    done = pipeclamp("compare", "emwm2", campaign, "--json", answer, "--report", report)
    assert "left out" not in done.stderr
    found = json.loads(answer.read_text(encoding="utf-8"), parse_constant=lambda name: pytest.fail(name))
    *others, shaken = found["runs"]
    assert [run["motion"] for run in found["runs"]] == ["sine"] * (2 * sines) + ["free"]
    assert (shaken["run"], shaken["noise_nrmse"], shaken["amplitude_mm"]) == ("shaken", None, None)
    assert all(run["noise_nrmse"] is not None and run["tracked_amplitude_mm"] is None for run in others)
    assert found["noise_nrmse"] is None
    lowest, highest = (edge(run["nrmse"] for run in found["runs"]) for edge in (min, max))
    assert lowest <= found["nrmse"] <= highest
    assert bool(found["where"]["phases"]) == sines
    for parts in (found["where"]["free"][name] for name in ("time", "places", "speed", "displacement")):
        assert sum(part["share"] for part in parts) == pytest.approx(1.0)
    page = report.read_text(encoding="utf-8")
    assert "NaN" not in re.sub(r"<script.*?</script>", "", page, flags=re.S)
    for title in ("Answer", "Free motions", "Where along free motions", *(["By harmonic"] if sines else [])):
        assert f"<h2>{title}</h2>" in page
    for sentence in found["where"]["words"]:
        assert sentence in " ".join(done.stdout.split())
    # a law of another clamp: what it lacks is told of loops alone, of more than two; sines say around what
    following = f"plan -o planned --law emwm2 --limits A={'0.4..1.2' if sines else '..0.8'}"
    assert f"Next: pipeclamp {following}" in " ".join(done.stdout.split())
    same = pc.compare("emwm2", campaign)
    assert json.loads(json.dumps(same.to_dict())) == found
    assert same.noise_nrmse is None
    assert same.to_frame()["run"].to_list()[-1] == "shaken"


def test_fits_and_metrics_leave_them_out_and_say_so(pipeclamp, mixed, tmp_path):
    campaign, law = mixed(), tmp_path / "law.json"
    assert NOTE in pipeclamp("identify", campaign, "-o", law, "--reproducible").stderr
    page = tmp_path / "m.html"
    assert NOTE in pipeclamp("metrics", campaign, "--report", page).stderr
    assert "free motion is left out (shaken)" in page.read_text(encoding="utf-8")
    table = (campaign / "runs.csv").read_text(encoding="utf-8")
    (campaign / "runs.csv").write_text(table[: table.index("shaken")], encoding="utf-8")
    again = pc.identify(campaign).to_dict()["coefficients"]
    assert json.loads(law.read_text(encoding="utf-8"))["coefficients"] == again


@pytest.mark.parametrize(
    "words", [("identify", "-o", "law.json"), ("metrics",), ("diagnose",), ("add", "-o", "l.json")]
)
def test_free_motions_alone_are_an_error_that_tells_what_to_do(refused, mixed, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    command, *options = words
    before = {"diagnose": ["emwm2"], "add": ["emwm2", "memory"]}.get(command, [])
    message = refused(command, *before, mixed(sines=False), *options)
    assert "its only run has free motion (shaken); expected sines" in message
    assert "pipeclamp compare" in message


def test_python_names_them(mixed):
    tests = pc.read_campaign(mixed())
    assert repr(tests) == "<tests small: 3 runs, 1 of free motion, 0 left out>"
    assert "1 run of free motion is left out (shaken)" in str(tests)
    alone = pc.read_campaign(mixed(sines=False))
    assert repr(alone) == "<tests small: 1 runs, 1 of free motion, 0 left out>"
    with pytest.raises(pc.UserError, match="expected sines"):
        pc.identify(alone)


def test_a_bad_word_is_told_with_its_row(refused, campaign_folder):
    message = refused("compare", "emwm2", campaign_folder(table="run,file,motion\nA,runs/A.csv,random\n"))
    assert "runs.csv, row 2, column 'motion': got 'random'" in message
    assert "expected one of sine, free" in message


def test_earthquakes_on_a_measured_device(pipeclamp, measured_data, tmp_path):
    """Two records of 27 s at 1024 Hz, evaluated in seconds; what the law lacks (backlash) makes most of the error."""
    law, answer = tmp_path / "law.json", tmp_path / "answer.json"
    campaign = measured_data / "friction_device"
    pipeclamp("identify", campaign, "-o", law, "--effects", "condition:tension_lb,memory")
    begun = time.monotonic()
    done = pipeclamp("compare", law, campaign / "other_motions", "--json", answer)
    assert time.monotonic() - begun < 20
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert {run["run"] for run in found["runs"]} == {"ImperialValleyDBE", "KocaeliDBE"}
    assert all(0.1 < run["nrmse"] < 2.0 for run in found["runs"])
    assert all(run["tracked_amplitude_mm"]["outside_share"] > 0.5 for run in found["runs"])
    assert "outside the law's range" in done.stdout


def test_python_gives_a_free_motion_and_the_law_along_it(mixed):
    """Only loops of sines had been given: an earthquake couldn't be drawn."""
    found = pc.compare("emwm2", mixed())
    along = found.free_motion("shaken")
    error = (along["force_N"] - along["law_force_N"]).to_numpy()
    (told,) = found.to_frame().filter(run="shaken")["nrmse"]
    assert np.sqrt(np.mean(error**2) / np.mean(along["force_N"].to_numpy() ** 2)) == pytest.approx(told, rel=1e-6)
    assert np.all(np.diff(along["time_s"].to_numpy()) > 0)
    with pytest.raises(pc.UserError, match=r"no sine; .*or \.free_motion for it"):
        found.loop("shaken")
    with pytest.raises(pc.UserError, match=r"'2\.0': its motion is a sine; .*or \.loop for it"):
        found.free_motion("2.0")
    with pytest.raises(pc.UserError, match="did you mean 'shaken'"):
        found.free_motion("shakn")
