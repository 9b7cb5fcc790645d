"""The line about a first cut by a twin."""

from armside.scripts.cutting.first_cut import line


def test_the_line_has_the_interval_and_its_rate():
    found = {"arm_rms": 2e-6, "interval": [1e-6, 3e-6], "uncorrected": 1e-4}
    before, after = (line(found, [{"arm_rms": rms}]) for rms in (None, 2.5e-6))
    assert "not measured, 100 um without correction" in before
    assert "2.5 um, 100 um" in after
    assert after.endswith("predicted 2.0 um, 1.0 to 3.0 um (90 %)")
