"""Two-stage learning on an arm: its gains, its torque, and the finding of the paper."""

from dataclasses import replace

import numpy as np
import pytest

from armside.ilc.models.elastic_bench import TwoMass
from armside.sim.laser.experiment import prepare
from armside.sim.laser.strokes import Strokes, robot_of
from armside.sim.papers.two_stage import (
    TwoStageJob,
    TwoStageLaw,
    TwoStageOutput,
    TwoStagePlant,
    assumed,
    first_input,
)

M16IB = "m16ib_like.toml"
AXIS = TwoMass(Jm=40.0, Jl=90.0, k=7.5e5, d=280.0, N=1.0, viscous=100.0)


def test_gains_start_and_adapt_as_printed():
    law, n = TwoStageLaw("motor", (AXIS,)), 1000
    wave = np.sin(np.linspace(0.0, 40.0, n))[:, None]
    zero, e = np.zeros((n, 2)), np.hstack([1e-3 * wave, wave])
    learned, gains = law.step(zero, e, None)
    np.testing.assert_allclose(gains.torque, 1.0)
    np.testing.assert_allclose(learned[:, :1], 0.2 * law.smooth(e[:, :1]))
    np.testing.assert_allclose(learned[:, 1:], law.smooth(e[:, 1:]))
    for growth, expected in ((0.5, 0.2), (1.1, 0.6), (2.0, 1.0)):
        learned, now = law.step(zero, e * [0.25, growth], gains)
        np.testing.assert_allclose(now.torque, expected)
        g_r = (1.0 - 0.8 * expected) * 0.5  # twice the largest error over the first
        np.testing.assert_allclose(learned[:, :1], g_r * 0.25 * law.smooth(e[:, :1]))


def test_an_error_that_stays_zero_gives_finite_gains_and_one_that_appears_full_torque():
    law, n = TwoStageLaw("motor", (AXIS,)), 1000
    wave = np.hstack([np.zeros((n, 1)), np.sin(np.linspace(0.0, 40.0, n))[:, None]])
    zero = 0.0 * wave
    _, gains = law.step(zero, zero, None)
    for error, expected in ((zero, 0.2), (wave, 1.0)):
        learned, now = law.step(zero, error, gains)
        np.testing.assert_allclose(now.torque, expected)
        assert np.isfinite(learned).all()


def test_the_torque_of_an_output_is_not_filtered_before_the_law_does(experiment):
    output = TwoStageOutput("motor", experiment, first_input(experiment))
    plant = TwoStagePlant(experiment, first_input(experiment).motor)
    n, axes = experiment.loaded.reference.shape
    run = plant.run(np.zeros((n, 2 * axes)))
    spiked = np.zeros((n, axes))
    spiked[n // 2] = 1.0
    plain, other = (output(replace(run, feedback=run.feedback + by * spiked)) for by in (0, 1))
    np.testing.assert_allclose((plain - other)[:, axes:], spiked, atol=1e-9)


def test_a_law_needs_reference_and_torque_of_each_axis():
    with pytest.raises(ValueError, match="a correction needs 2 columns, got 1"):
        TwoStageLaw("motor", (AXIS,)).check(100, 1)


@pytest.fixture(scope="module")
def experiment():
    strokes = Strokes(robot=robot_of(M16IB), across_tool=True, individual=0)
    return prepare(strokes)


def test_the_first_input_carries_the_gears_load_at_rest(experiment):
    known, robot = first_input(experiment), experiment.nominal
    sag = assumed(experiment).stiffness * (known.motor - known.load)[0]
    held = experiment.loaded.controls[0, 2::3] * robot.drives.gear
    np.testing.assert_allclose(sag, held, atol=0.02 * np.abs(held).max())


def test_learned_torque_moves_the_motor_by_what_its_servo_yields(experiment):
    plant = TwoStagePlant(experiment, first_input(experiment).motor)
    n, axes = experiment.loaded.reference.shape
    torque = np.zeros((n, 2 * axes))
    torque[:, axes + 1] = 1200.0
    moved = [plant.run(u).recording.motor_angle[-1, 1] for u in (0.0 * torque, torque)]
    drives = experiment.loaded.model.drives
    yielded = 1200.0 / (drives.kp[1] * drives.gear[1] ** 2)
    friction = drives.static_friction[1] * drives.gear[1] / (drives.kp[1] * drives.gear[1] ** 2)
    assert moved[1] - moved[0] == pytest.approx(yielded, abs=2.2 * friction)


@pytest.mark.parametrize("side", ["motor", "load"])
def test_two_updates_leave_a_third_of_what_learning_can_reach(side):
    """Less the rest, which learning cannot reach. Individual 0 is one of development."""
    found = TwoStageJob(M16IB, side, 0, iterations=2).run()["tcp_rms_less_rest"]
    assert found[2] < found[1] / 2.0 < found[0] / 2.0
    assert found[2] < found[0] / 3.0
