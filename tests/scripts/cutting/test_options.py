"""Ends of the options of a cut."""

import pytest

from armside.scripts.cutting.options import BEAM


def test_a_beam_is_from_ten_micrometres_to_ten_centimetres():
    BEAM.check("beam", (0.01, 100.0))
    for width in (0.0099, 100.1):
        with pytest.raises(ValueError, match=r"beam must be 0\.01 to 100 mm"):
            BEAM.check("beam", width)
