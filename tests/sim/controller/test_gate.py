"""The gate before a real robot, each limit against a calculation of its own."""

import numpy as np
import pytest

from armside.sim.controller import GuidanceLimits, InProcess, StreamedPlant
from armside.sim.controller.gate import LIMITS, GateError, exceeded, let_through

from .robots import CELL, path, programmed

T = 0.004
RAMP = np.arange(60.0)[:, None] * T
"""(60, 1) [s], rises by one a second."""
SHAPES = {
    "size": np.sin(0.5 * np.pi * np.arange(4001)[:, None] / 4000),
    "speed": np.minimum(RAMP, 0.1),
    "acceleration": np.where(np.arange(60)[:, None] % 2, T**2 / 2, 0.0),
}
"""Signals whose largest value, speed and acceleration are 1."""
SHOWN = {
    "size": ("5 deg", "5 mm"),
    "speed": ("50 deg/s", "100 mm/s"),
    "acceleration": ("10000 deg/s^2", "20000 mm/s^2"),
}


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_each_limit_holds_back_what_just_exceeds_it_and_nothing_below(name, sliding):
    signal = LIMITS[name][sliding] * SHAPES[name]
    above, below = (exceeded(f * signal, T, slides=(sliding,)) for f in (1.001, 0.999))
    assert f"axis 1 must be within {SHOWN[name][sliding]}" in above[name]
    assert name not in below


def test_a_correction_that_begins_beside_zero_is_a_step():
    step = np.full((60, 1), np.deg2rad(0.25))
    assert set(exceeded(step, T)) == {"speed", "acceleration"}
    assert not exceeded(0.5 * step, T)


def test_path_and_correction_together_keep_the_ranges_and_speeds_of_the_joints():
    limits, u = GuidanceLimits.of_cell(CELL), np.zeros_like(path())
    edge = path() - path()[0] + [limits.upper[0] - 0.01, 1.0]
    found = exceeded(u, T, path=edge, limits=limits)
    k = int(np.argmax(edge[:, 0] > limits.upper[0]))
    assert f"sample {k}: axis 1 must be" in found["range"]
    assert not exceeded(u, T, path=path(), limits=limits)
    fast = exceeded(u, T / 20.0, path=path(), limits=limits)
    assert set(fast) == {"speed"}


def test_what_is_named_is_let_through_with_a_line_and_anything_else_is_not():
    found = exceeded(np.full((60, 1), 1.0), T)
    assert [line.split(":")[0] for line in let_through(found, LIMITS)] == [
        f"beyond {name}" for name in LIMITS
    ]
    with pytest.raises(GateError, match="; beyond speed acceleration lets it through"):
        let_through(found, ["size"])


def test_a_plant_without_limits_still_sends_no_correction_beyond_the_gate():
    controller = programmed()
    plant = StreamedPlant(InProcess(controller, additive=True), path())
    with pytest.raises(GateError, match=r"size: the correction of axis 1 .* nothing was sent"):
        plant.run(np.full_like(path(), 1e6))
    assert controller.state().number == 0
    with pytest.raises(ValueError, match="Unknown name 'fast'"):
        StreamedPlant(InProcess(controller), path(), beyond=("fast",))
