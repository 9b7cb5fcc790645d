"""Ports of a controller."""

import pytest

from armside.scripts.workbench.controllers import whole_port


def test_a_port_is_from_zero_which_is_any_to_65535():
    assert [whole_port(port) for port in (0, 65535)] == [0, 65535]
    for port, least in ((-1, 0), (65536, 0), (0.5, 0), (0, 1)):
        with pytest.raises(ValueError, match=f"from {least} to 65535"):
            whole_port(port, least)
