"""The command line of the digests: no run starts by mistake."""

import pytest

from . import digests


def test_a_name_chooses_the_runs_that_contain_it():
    assert digests.asked(["compare", "laser irb1400"])[1] == [
        f"laser irb1400 p{i}" for i in (1, 2, 3)
    ]
    assert digests.asked(["write"]) == ("write", list(digests.RUNS))


@pytest.mark.parametrize(
    "words", [[], ["show"], ["--all"], ["compare", "nothing like this"], ["write", "laser", "imu"]]
)
def test_unknown_words_print_the_usage_and_start_nothing(words, capsys):
    with pytest.raises(SystemExit) as end:
        digests.asked(words)
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("usage: ")


def test_help_starts_nothing():
    with pytest.raises(SystemExit) as end:
        digests.asked(["--help"])
    assert end.value.code == 0
