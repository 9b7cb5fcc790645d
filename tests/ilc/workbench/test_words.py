"""Values that are given as words."""

from armside.ilc.workbench.words import guessed


def test_words_without_a_type_are_whole_numbers_numbers_or_text():
    found = guessed({"delta": "5", "gain": "0.9", "small": "1e-3", "name": "5 Hz"})
    assert found == {"delta": 5, "gain": 0.9, "small": 0.001, "name": "5 Hz"}
    assert [type(value) for value in found.values()] == [int, float, float, str]
