"""The bundled campaign of metrics holds the paper's own numbers."""

from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.loops.published_rows import published_rows
from pipeclamp_identification.workflow.reading import read_tests


def test_the_published_tables_campaign_is_the_tables():
    tests = read_tests(bundled_campaign("emwm2_tables")).metrics()
    ours = {
        (run.amplitude_mm, run.frequency_Hz, run.setup.temperature_C): (
            run.dissipated_energy_J,
            run.max_elastic_energy_J,
        )
        for run in tests.runs
    }
    printed = {
        (row.amplitude_mm, row.frequency_Hz, row.temperature_C): (row.dissipated_energy_J, row.max_elastic_energy_J)
        for row in published_rows()
        if row.specimen == "EMWM2"
    }
    assert ours == printed
    assert len(ours) == len(tests.runs) == 11
    assert {run.setup.density_g_cm3 for run in tests.runs} == {2.286}
