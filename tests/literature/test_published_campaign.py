"""The bundled campaign of metrics holds the paper's own numbers."""

from pipeclamp_identification.bundled_campaigns import bundled_campaign
from pipeclamp_identification.metric_campaign import read_tests
from pipeclamp_identification.published_rows import published_rows


def test_the_published_tables_campaign_is_the_tables():
    tests = read_tests(bundled_campaign("emwm2_tables"))
    ours = {
        (run.amplitude_mm, run.frequency_Hz, run.temperature_C): (run.dissipated_energy_J, run.max_elastic_energy_J)
        for run in tests.runs
    }
    printed = {
        (row.amplitude_mm, row.frequency_Hz, row.temperature_C): (row.dissipated_energy_J, row.max_elastic_energy_J)
        for row in published_rows()
        if row.specimen == "EMWM2"
    }
    assert ours == printed
    assert len(ours) == len(tests.runs) == 11
    assert {run.density_g_cm3 for run in tests.runs} == {2.286}
