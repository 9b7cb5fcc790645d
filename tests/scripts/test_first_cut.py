"""The line about a first cut by a twin."""

from armside.scripts.cutting.learning import predicted_line as line

FOUND = {"arm_rms": 2e-6, "interval": [1e-6, 3e-6], "uncorrected": 1e-4, "trusted": True}


def test_the_line_has_the_interval_and_its_rate():
    before, after = (line(FOUND, [{"arm_rms": rms}]) for rms in (None, 2.5e-6))
    assert "not measured, 100 um without correction" in before
    assert "2.5 um, 100 um" in after
    assert after.endswith("predicted 2.0 um, 1.0 to 3.0 um (90 %)")


def test_the_interval_of_a_correction_that_is_not_used_is_not_printed():
    said = line(FOUND | {"trusted": False}, [{"arm_rms": 1.2e-4}])
    assert said.startswith("First cut without correction: 120.0 um, 100 um by the twin")
    assert "90 %" not in said


def test_an_interval_that_is_not_known_is_not_printed():
    said = line(FOUND | {"interval": None}, [{"arm_rms": 2.5e-6}])
    assert said.endswith("predicted 2.0 um, of unknown accuracy for a twin of so few cuts")
